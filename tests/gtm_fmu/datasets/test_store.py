"""The store of a data set: what it holds, what it refuses, what a stopped writer, a full disk or a scratch leaves."""

import fcntl
import json
import os
import shutil
import signal
import socket
import subprocess
import sys
import warnings
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from gtm_fmu.aircraft.inputs import INPUTS
from gtm_fmu.datasets import export, results
from gtm_fmu.datasets.axes import choices, levels
from gtm_fmu.datasets.cases import CaseTable
from gtm_fmu.datasets.store import LOCK, METADATA, CaseStore, chunk_size, open_cases, slices, writer_lock
from gtm_fmu.errors import InputError
from tests.gtm_fmu.datasets.rudder_store import CHUNK, OPTIONS, TABLE, fill, jams

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def found() -> dict[str, np.ndarray]:
    return results.evaluate(TABLE.rows(0, 6))


@pytest.fixture
def path(tmp_path, found) -> Path:
    return fill(tmp_path / "jams.zarr", found)


def files(path: Path) -> dict[str, bytes]:
    return {str(file.relative_to(path)): file.read_bytes() for file in path.rglob("*") if file.is_file()}


class TestContents:
    def test_xarray_opens_it_without_a_word(self, path, found):
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            data = xr.open_zarr(path).load()
        assert data.sizes == {"case": 6}
        assert set(data.coords) == {column.name for column in INPUTS}
        for name, values in found.items():
            np.testing.assert_array_equal(data[name], values)
        np.testing.assert_array_equal(data.rudder_lower, [0, 3, 10, 14.5, 22, 30])
        assert data.finished.all()

    def test_units_and_legend(self, path):
        data = open_cases(path)
        assert {name: data[name].units for name in ("altitude", "throttle_upper", "v_min", "turn_rate_at_v_max")} == {
            "altitude": "ft",
            "throttle_upper": "%",
            "v_min": "kt",
            "turn_rate_at_v_max": "deg/s",
        }
        legend = data.limits_at_v_max.attrs
        meaning = dict(zip(legend["flag_meanings"].split(), legend["flag_masks"], strict=True))
        assert (data.limits_at_v_max[:5] & meaning["throttle.upper"]).astype(bool).all()  # SPEC 9: V_max has 100 %

    def test_choices_are_numbers_with_a_legend(self, tmp_path):
        held = [levels("altitude", [20000.0]), levels("gamma", [0.0]), levels("aileron_rate", [40.0])]
        table = CaseTable.lattice([*held, choices("damage_case", [2, 5]), choices("engine_out", [1])])
        store = CaseStore(tmp_path / "a.zarr", table, OPTIONS, CHUNK)
        nothing = {name: np.zeros(2, dtype) for name, (dtype, _) in results.schema().items()}
        store.write(range(2), nothing)
        data = open_cases(tmp_path / "a.zarr").load()
        assert (data.damage_case.dtype, data.damage_case.values.tolist()) == (np.uint8, [2, 5])
        assert data.damage_case.flag_meanings.split()[5] == "left_elevator_off"
        assert data.engine_out.flag_meanings.split()[int(data.engine_out[0])] == "left"
        assert (data.aileron_rate.units, data.aileron_rate.values.tolist()) == ("deg/s", [40.0, 40.0])
        table = export.frame(data)
        assert table.damage_case.tolist() == ["vertical_tail_off", "left_elevator_off"]
        assert table.aileron_rate_deg_s.tolist() == [40.0, 40.0]

    def test_provenance(self, path):
        made = open_cases(path).attrs
        assert made["sampling"] == "lattice"
        assert made["cases"] == 6
        assert made["alpha_deg"] == [-5.0, 10.5]
        assert made["axis_altitude"] == "held at [20000.0]"
        assert {"gtm_fmu_version", "aerodynamic_data_sha256", "core_sha256", "numpy_version"} <= set(made)

    def test_unfinished(self, tmp_path, found):
        path = fill(tmp_path / "half.zarr", found, range(0, 4))
        data = open_cases(path).load()
        assert data.finished.values.tolist() == [True] * 4 + [False] * 2
        assert np.isnan(data.v_min[4:]).all()
        assert CaseStore(path, TABLE, OPTIONS, CHUNK).unfinished() == [range(4, 6)]

    def test_chunk_without_any_envelope(self, tmp_path, found):
        """All its results are the fill values; it is finished all the same."""
        none = {name: np.repeat(values[5:], 6) for name, values in found.items()}
        path = fill(tmp_path / "none.zarr", none)
        assert CaseStore(path, TABLE, OPTIONS, CHUNK).unfinished() == []
        assert not open_cases(path).feasible.any()

    def test_same_bytes_in_any_order(self, path, tmp_path, found):
        other = fill(tmp_path / "other.zarr", found, range(4, 6), range(0, 4))
        assert files(other) == files(path)

    def test_chunk_size(self):
        assert [chunk_size(n) for n in (1, 1232, 20000, 10**6)] == [64, 64, 512, 1024]


class TestDamage:
    def test_removed_file_is_computed_again(self, path, found):
        before = files(path)
        (path / "beta_at_v_min" / "c" / "1").unlink()
        assert CaseStore(path, TABLE, OPTIONS, CHUNK).unfinished() == [range(4, 6)]
        fill(path, found)
        assert files(path) == before

    @pytest.mark.parametrize("scratch", [lambda raw: raw[:-3], lambda raw: raw[:9] + bytes([raw[9] ^ 1]) + raw[10:]])
    def test_scratched_chunk(self, path, scratch, found):
        before = files(path)
        file = path / "v_max" / "c" / "1"
        file.write_bytes(scratch(file.read_bytes()))
        for names in (None, ["v_min"]):
            with pytest.raises(InputError, match=r"damaged at cases 4 to 5 .*give the command that made it again"):
                list(slices(path, names))
        assert CaseStore(path, TABLE, OPTIONS, CHUNK).unfinished() == [range(4, 6)]
        assert files(fill(path, found)) == before

    @pytest.mark.parametrize("name", ["v_max", "rudder_lower", "limits_at_v_min", "checksum", "all of them"])
    def test_chunk_in_the_place_of_another(self, tmp_path, found, name):
        """Each carries a valid check value of its own content."""
        six = {column: np.concatenate([values, values[:2]]) for column, values in found.items()}
        path = tmp_path / "eight.zarr"
        eight = jams(0.0, 3.0, 10.0, 14.5, 22.0, 30.0, 0.5, 3.5)
        with writer_lock(path):
            store = CaseStore(path, eight, OPTIONS, CHUNK)
            for cases in store.unfinished():
                store.write(cases, {column: values[cases.start : cases.stop] for column, values in six.items()})
        assert len(list(slices(path))) == 2
        for folder in path.iterdir() if name == "all of them" else [path / name]:
            if folder.is_dir():
                shutil.copy(folder / "c" / "0", folder / "c" / "1")
        assert CaseStore(path, eight, OPTIONS, CHUNK).unfinished() == [range(4, 8)]
        with pytest.raises(InputError, match=r"damaged at cases 4 to 7 \(the values are not those"):
            list(slices(path, ["feasible"]))

    def test_folder_in_the_place_of_a_chunk(self, path):
        (path / "v_max" / "c" / "1").unlink()
        (path / "v_max" / "c" / "1").mkdir()
        with pytest.raises(InputError, match="damaged at cases 4 to 5"):
            list(slices(path))
        with pytest.raises(InputError, match=r"v_max/c/1 is a folder in the place of a chunk; remove it and give"):
            CaseStore(path, TABLE, OPTIONS, CHUNK).unfinished()

    def test_lost_chunk_is_no_infeasible_case(self, path):
        """Zarr reads a missing chunk as NaN."""
        (path / "v_max" / "c" / "0").unlink()
        with pytest.raises(InputError, match="damaged at cases 0 to 3"):
            list(slices(path))

    def test_left_part_of_a_stopped_writer(self, path, found):
        before = files(path)
        (path / "v_max" / "c" / "1.0123.partial").write_bytes(b"half")
        fill(path, found)
        assert files(path) == before

    @pytest.mark.parametrize("metadata", ["zarr.json", "phi_at_v_max/zarr.json", "finished/zarr.json"])
    def test_damaged_metadata(self, path, metadata):
        (path / metadata).write_text("{")
        kept = files(path)
        with pytest.raises(InputError, match="is no readable data set"):
            CaseStore(path, TABLE, OPTIONS, CHUNK)
        with pytest.raises(InputError, match="is no readable data set"):
            list(slices(path))
        assert files(path) == kept

    def test_missing_variable(self, path):
        shutil.rmtree(path / "v_min")
        with pytest.raises(InputError, match="is no readable data set"):
            CaseStore(path, TABLE, OPTIONS, CHUNK)

    def test_no_store_at_all(self, tmp_path):
        (tmp_path / "letters").mkdir()
        (tmp_path / "letters" / "a.txt").write_text("Dear")
        for name in ("letters", "letters/a.txt"):
            with pytest.raises(InputError, match="is no readable data set"):
                CaseStore(tmp_path / name, TABLE, OPTIONS)
        assert [file.read_text() for file in tmp_path.rglob("*.txt")] == ["Dear"]
        with pytest.raises(InputError, match="is no readable data set"):
            open_cases(tmp_path / "nothing")

    def test_an_empty_folder_may_become_one(self, tmp_path, found):
        (tmp_path / "new").mkdir()
        assert open_cases(fill(tmp_path / "new", found)).finished.all()


class TestRefusal:
    @pytest.mark.parametrize(
        ("table", "options", "chunk", "reason"),
        [
            (jams(0.0, 3.0), OPTIONS, CHUNK, r"with other options \(cases: 6, now 2\)"),
            (jams(0.0, 3.0, 10.0, 14.5, 22.0, 29.0), OPTIONS, CHUNK, r"with other options \(axis_rudder"),
            (TABLE, OPTIONS | {"phi_deg": [-30.0, 20.0]}, CHUNK, r"\(phi_deg: \[-30.0, 30.0\], now \[-30.0, 20.0\]\)"),
            (TABLE, OPTIONS, 3, r"\(chunk: 4, now 3\)"),
        ],
    )
    def test_other_options(self, path, table, options, chunk, reason):
        kept = files(path)
        with pytest.raises(InputError, match=reason):
            CaseStore(path, table, options, chunk)
        assert files(path) == kept

    def test_an_axis_more_or_less(self, path, tmp_path):
        """Of the same number of cases: neither store may pass for the other."""
        damaged = CaseTable.lattice([*TABLE.axes, choices("damage_case", [4])])
        with pytest.raises(InputError, match=r"with other options \(axis_damage_case: None, now"):
            CaseStore(path, damaged, OPTIONS, CHUNK)
        other = tmp_path / "damaged.zarr"
        inputs = tuple(column.name for column in damaged.columns)
        CaseStore(other, damaged, OPTIONS, CHUNK).write(range(4), results.evaluate(damaged.rows(0, 4), inputs=inputs))
        kept = files(other)
        with pytest.raises(InputError, match=r"with other options \(axis_damage_case: .*, now None\)"):
            CaseStore(other, TABLE, OPTIONS, CHUNK)
        assert files(other) == kept

    @pytest.mark.parametrize("name", ["gtm_fmu_version", "aerodynamic_data_sha256", "core_sha256", "scipy_version"])
    def test_another_version(self, path, name):
        metadata = json.loads((path / "zarr.json").read_text())
        metadata["attributes"][name] = "0.0.1"
        (path / "zarr.json").write_text(json.dumps(metadata))
        kept = files(path)
        with pytest.raises(InputError, match=rf"was made by another version \({name}: 0\.0\.1, now .* left as it is"):
            CaseStore(path, TABLE, OPTIONS, CHUNK)
        assert files(path) == kept

    def test_unwritable_folder(self, tmp_path):
        (tmp_path / "file").touch()
        for place in (tmp_path / "file" / "a", tmp_path / ("n" * 300), tmp_path / "/".join(["deep"] * 1000)):
            with pytest.raises(InputError, match="choose a folder you may write to"), writer_lock(place):
                pass

    def test_nothing_but_a_store_is_locked(self, tmp_path):
        (tmp_path / "letters").mkdir()
        (tmp_path / "letters" / "a.txt").write_text("Dear")
        os.mkfifo(tmp_path / "pipe")
        kept = sorted(tmp_path.rglob("*"))
        for place in ("letters", "letters/a.txt", "pipe", "/", "."):
            with pytest.raises(InputError, match="is no readable data set"), writer_lock(tmp_path / place):
                pass
        assert sorted(tmp_path.rglob("*")) == kept

    def test_a_folder_is_only_kept_if_something_was_written(self, tmp_path):
        (tmp_path / "mine").mkdir()
        for name in ("mine", "new"):
            with writer_lock(tmp_path / name):
                pass
        assert [path.name for path in tmp_path.iterdir()] == ["mine"]


HOLD = """
import sys, time
from pathlib import Path
from gtm_fmu.datasets.store import writer_lock
with writer_lock(Path(sys.argv[1])):
    print("held", flush=True)
    time.sleep(60)
"""


class TestLock:
    @pytest.fixture
    def holder(self, tmp_path):
        path = tmp_path / "a.zarr"
        with subprocess.Popen([sys.executable, "-c", HOLD, path], stdout=subprocess.PIPE, text=True) as process:
            assert process.stdout.readline() == "held\n"
            yield process, path
            process.kill()

    def test_second_writer_is_refused(self, holder):
        process, path = holder
        sentence = rf"a\.zarr is being written by process {process.pid} on {socket.gethostname()}; wait"
        for _ in range(2):
            with pytest.raises(InputError, match=sentence), writer_lock(path):
                pass

    def test_it_is_the_store_that_is_locked_and_not_its_name(self, holder):
        process, path = holder
        path.with_name("link.zarr").symlink_to(path)
        path.with_name("folder").symlink_to(path.parent)
        for name in (path.with_name("link.zarr"), path.parent / "folder" / path.name):
            with pytest.raises(InputError, match=f"is being written by process {process.pid}"), writer_lock(name):
                pass

    def test_lock_of_a_dead_process_is_taken_over(self, holder):
        process, path = holder
        process.send_signal(signal.SIGKILL)
        process.wait()
        lock = path / LOCK
        assert str(process.pid) in lock.read_text()
        with writer_lock(path):
            assert f"process {os.getpid()} on" in lock.read_text()
        assert not lock.exists()

    def test_lock_that_vanishes_while_it_is_taken(self, tmp_path, monkeypatch):
        """Its holder removes the file between the opening and the locking of it; the lock must be on the new one."""
        path, flock, seen = tmp_path / "a.zarr", fcntl.flock, []

        def remove_once(descriptor, operation):
            if not seen:
                (path / LOCK).unlink()
            seen.append(descriptor)
            flock(descriptor, operation)

        monkeypatch.setattr(fcntl, "flock", remove_once)
        with writer_lock(path):
            assert len(seen) == 2
            with pytest.raises(InputError, match=f"process {os.getpid()} on"), writer_lock(path):
                pass


def test_writer_that_was_stopped_before_the_metadata(tmp_path, found):
    """They are moved into the folder one by one, those of the group last."""
    whole, path = fill(tmp_path / "whole.zarr", found), tmp_path / "a.zarr"
    (path / "v_min").mkdir(parents=True)
    shutil.copy(whole / "v_min" / METADATA, path / "v_min" / METADATA)
    (path / ".gtm-fmu.new").mkdir()
    (path / LOCK).write_text("process 1 on nowhere")
    assert files(fill(path, found)) == files(whole)


def fill_up(folder: Path) -> None:
    """Leave no byte free, in a file named ballast."""
    with (folder / "ballast").open("wb", buffering=0) as ballast, suppress(OSError):
        while ballast.write(bytes(1024)):
            pass


class TestFullDisk:
    @pytest.fixture
    def small_disk(self, tmp_path):
        """A megabyte of memory as a disk."""
        folder = tmp_path / "small"
        folder.mkdir()
        mounted = shutil.which("mount") and subprocess.run(
            ["mount", "-t", "tmpfs", "-o", "size=1m", "tmpfs", folder], capture_output=True
        )
        if not mounted or mounted.returncode:
            pytest.skip("a small disk cannot be mounted here (root only)")
        yield folder
        subprocess.run(["umount", folder], check=True)

    def test_finished_chunks_are_kept(self, small_disk, tmp_path, found):
        path = fill(small_disk / "a.zarr", found, range(0, 4))
        fill_up(small_disk)
        with pytest.raises(InputError, match=r"Cannot write .*\(No space left on device\); finished chunks are kept"):
            fill(path, found)
        assert not list(path.rglob("*.partial"))
        assert open_cases(path).load().finished.values.tolist() == [True] * 4 + [False] * 2
        (small_disk / "ballast").unlink()
        fill(path, found)
        assert files(path) == files(fill(tmp_path / "a.zarr", found))

    def test_no_room_for_a_new_store(self, small_disk, found):
        (small_disk / "ballast").write_bytes(bytes(900 * 1024))
        path = small_disk / "a.zarr"
        with pytest.raises(InputError, match="No space left on device"):
            fill(path, found)
        assert not path.exists()
        (small_disk / "ballast").unlink()
        assert open_cases(fill(path, found)).finished.all()
