"""The lattice data set: its cases and units, written whole or not at all, and read back with the same values."""

import os
import shutil
import threading

import numpy as np
import pytest
import xarray as xr

from gtm_fmu.aircraft.limits import ControlLimits
from gtm_fmu.datasets import lattice as dataset
from gtm_fmu.envelopes.envelope import envelope
from gtm_fmu.errors import InputError

ALTITUDES_FT = (0.0, 30000.0)
GAMMAS_DEG = (-5.0, 0.0, 5.0)
FAILURES = [(-30.0, 30.0), (8.0, 8.0), (-25.0, -18.0), (30.0, 30.0)]


@pytest.fixture(scope="module")
def lattice() -> xr.Dataset:
    return dataset.lattice(ALTITUDES_FT, GAMMAS_DEG, FAILURES, workers=1)


def test_the_lattice_of_the_paper():
    """4 altitudes, 11 flight-path angles (paper Table 7), 7 jams and 21 restrictions: 1232 cases."""
    failures = dataset.rudder_failures(dataset.PAPER_RUDDERS_DEG)
    assert len(failures) == len(set(failures)) == 28
    assert sum(lower == upper for lower, upper in failures) == 7
    assert all(-30 <= lower <= upper <= 30 for lower, upper in failures)
    assert dataset.PAPER_ALTITUDES_FT == (0, 10000, 20000, 30000)
    assert list(dataset.PAPER_GAMMAS_DEG) == list(range(-5, 6))
    assert len(dataset.PAPER_ALTITUDES_FT) * len(dataset.PAPER_GAMMAS_DEG) * len(failures) == 1232


def test_every_case_is_the_envelope_of_its_coordinates(lattice):
    assert dict(lattice.sizes) == {"altitude": 2, "gamma": 3, "failure": 4}
    feasible = 0
    for i, j, k in np.ndindex(2, 3, 4):
        case = lattice.isel(altitude=i, gamma=j, failure=k)
        assert (float(case.altitude), float(case.gamma)) == (ALTITUDES_FT[i], GAMMAS_DEG[j])
        assert (float(case.rudder_lower), float(case.rudder_upper)) == FAILURES[k]
        found = envelope(ALTITUDES_FT[i], GAMMAS_DEG[j], ControlLimits(rudder_deg=FAILURES[k]))
        assert bool(case.feasible) == found.feasible
        least = np.nan if found.t_min_pct is None else found.t_min_pct
        np.testing.assert_equal(float(case.t_min), least)
        for end in ("v_min", "v_max"):
            trim = getattr(found, f"at_{end}")
            names = {"alpha": "deg", "turn_rate": "deg_s", "elevator": "deg", "throttle": "pct", "rudder": "deg"}
            expected = {f"{name}_at_{end}": getattr(trim, f"{name}_{unit}", None) for name, unit in names.items()}
            for name, value in ({end: getattr(found, f"{end}_kt")} | expected).items():
                np.testing.assert_equal(float(case[name]), value if found.feasible else np.nan)
        feasible += found.feasible
    assert 8 < feasible < 24


def test_units_are_attributes(lattice):
    units = {"altitude": "ft", "gamma": "deg", "rudder_lower": "deg", "rudder_upper": "deg"}
    units |= {"v_min": "kt", "v_max": "kt", "t_min": "%"}
    units |= {"phi_at_v_min": "deg", "turn_rate_at_v_max": "deg/s", "throttle_at_v_min": "%"}
    for name, unit in units.items():
        assert lattice[name].attrs["units"] == unit
    assert len(lattice.attrs["aerodynamic_data_sha256"]) == 64
    assert lattice.attrs["gtm_fmu_version"]


def test_more_workers_give_the_same(lattice):
    reports = []
    again = dataset.lattice(ALTITUDES_FT, GAMMAS_DEG, FAILURES, lambda done, all_: reports.append((done, all_)), 2)
    xr.testing.assert_identical(again, lattice)
    assert reports == [(k, 6) for k in range(1, 7)]


def test_samples_follow_their_inputs(lattice):
    inputs, speeds, least = dataset.samples(lattice)
    assert inputs.shape == (24, 4)
    assert speeds.shape == (24, 2)
    assert least.shape == (24,)
    for row, (v_min, v_max), t_min in zip(inputs, speeds, least, strict=True):
        altitude_ft, gamma_deg, lower, upper = row
        k = FAILURES.index((lower, upper))
        case = lattice.sel(altitude=altitude_ft, gamma=gamma_deg).isel(failure=k)
        np.testing.assert_equal([v_min, v_max, t_min], [float(case[name]) for name in ("v_min", "v_max", "t_min")])
    assert len(np.unique(inputs, axis=0)) == 24


@pytest.mark.parametrize(
    ("altitudes", "gammas", "failures"),
    [
        ([], GAMMAS_DEG, FAILURES),
        (ALTITUDES_FT, [], FAILURES),
        (ALTITUDES_FT, GAMMAS_DEG, []),
        ([40000.0], GAMMAS_DEG, FAILURES),
        ([np.nan], GAMMAS_DEG, FAILURES),
        (ALTITUDES_FT, [60.0], FAILURES),
        (ALTITUDES_FT, GAMMAS_DEG, [(5.0, -5.0)]),
        (ALTITUDES_FT, GAMMAS_DEG, [(-40.0, 0.0)]),
        (ALTITUDES_FT, GAMMAS_DEG, [(0.0, np.nan)]),
    ],
)
def test_wrong_axes(altitudes, gammas, failures):
    with pytest.raises(InputError) as told:
        dataset.lattice(altitudes, gammas, failures)
    assert str(told.value).endswith(".")
    assert "\n" not in str(told.value)


def test_a_store_gives_back_what_was_saved(lattice, tmp_path):
    path = tmp_path / "deep" / "lattice.zarr"
    assert dataset.save(lattice, path) == path
    xr.testing.assert_identical(dataset.load(path), lattice)
    assert dataset.load(str(path)).feasible.dtype == bool


def test_a_later_store_replaces_the_earlier_one(lattice, tmp_path):
    path = tmp_path / "lattice.zarr"
    dataset.save(lattice, path)
    dataset.save(lattice.isel(gamma=[1]), path)
    xr.testing.assert_identical(dataset.load(path), lattice.isel(gamma=[1]))
    assert os.listdir(tmp_path) == ["lattice.zarr"]


@pytest.mark.parametrize("error", [KeyboardInterrupt, MemoryError, OSError(28, "No space left on device")])
def test_a_write_that_is_cut_off_leaves_the_earlier_store(lattice, tmp_path, monkeypatch, error):
    path = tmp_path / "lattice.zarr"
    dataset.save(lattice, path)
    to_zarr = xr.Dataset.to_zarr

    def cut_off(data, store, **options):
        to_zarr(data[["v_min"]], store, **options)
        raise error

    monkeypatch.setattr(xr.Dataset, "to_zarr", cut_off)
    expected = InputError if isinstance(error, OSError) else error
    with pytest.raises(expected):
        dataset.save(lattice.isel(gamma=[0]), path)
    xr.testing.assert_identical(dataset.load(path), lattice)

    monkeypatch.undo()
    dataset.save(lattice.isel(gamma=[0]), path)
    xr.testing.assert_identical(dataset.load(path), lattice.isel(gamma=[0]))
    assert os.listdir(tmp_path) == ["lattice.zarr"]


def test_a_folder_that_cannot_be_written(lattice, tmp_path):
    (tmp_path / "file").write_text("no folder")
    with pytest.raises(InputError, match=r"Cannot write .*file \(.*\); choose a folder you may write to\."):
        dataset.save(lattice, tmp_path / "file" / "lattice.zarr")
    if os.geteuid() == 0:
        return  # root may write anywhere
    tmp_path.chmod(0o500)
    with pytest.raises(InputError, match="Permission denied"):
        dataset.save(lattice, tmp_path / "lattice.zarr")


@pytest.mark.parametrize("foreign", ["letters.zarr", "other.zarr", "file.zarr", "with_notes.zarr"])
def test_nothing_but_an_earlier_store_is_replaced(lattice, tmp_path, foreign):
    path = tmp_path / foreign
    if foreign == "file.zarr":
        path.write_text("Dear")
    if foreign == "other.zarr":
        lattice[["v_min"]].to_zarr(path, consolidated=False)
    if foreign == "with_notes.zarr":
        dataset.save(lattice, path)
        (path / "notes.txt").write_text("mine")
    if foreign == "letters.zarr":
        path.mkdir()
        (path / "letter.txt").write_text("Dear")
    kept = {file: file.read_bytes() for file in tmp_path.rglob("*") if file.is_file()}
    with pytest.raises(InputError, match=r"is no data set of the study and is left as it is; choose another name\."):
        dataset.save(lattice, path)
    assert {file: file.read_bytes() for file in tmp_path.rglob("*") if file.is_file()} == kept


def test_a_link_to_a_store_stays_one(lattice, tmp_path):
    link, target = tmp_path / "link.zarr", tmp_path / "target.zarr"
    dataset.save(lattice.isel(gamma=[0]), target)
    link.symlink_to(target)
    dataset.save(lattice, link)
    assert link.is_symlink()
    xr.testing.assert_identical(dataset.load(target), lattice)


def damage_nothing(path):
    shutil.rmtree(path)


def damage_metadata(path):
    (path / "zarr.json").write_text("{")


def damage_no_metadata(path):
    (path / "zarr.json").unlink()


def damage_variable(path):
    shutil.rmtree(path / "v_max")


def damage_chunk(path):
    for file in path.rglob("*"):
        if file.is_file() and file.name != "zarr.json":
            file.write_bytes(file.read_bytes()[: file.stat().st_size // 2])


def damage_to_a_file(path):
    shutil.rmtree(path)
    path.write_text("not a store")


@pytest.mark.parametrize(
    "damage",
    [damage_nothing, damage_metadata, damage_no_metadata, damage_variable, damage_chunk, damage_to_a_file],
)
def test_a_missing_or_damaged_store(lattice, tmp_path, damage):
    path = tmp_path / "lattice.zarr"
    dataset.save(lattice, path)
    damage(path)
    with pytest.raises(InputError, match=r"is no readable data set .*; make one with `gtm-fmu study`\."):
        dataset.load(path)


def test_a_lost_chunk_is_no_infeasible_case(lattice, tmp_path):
    """Zarr reads a missing chunk as NaN, which would say that no envelope exists."""
    path = tmp_path / "lattice.zarr"
    dataset.save(lattice, path)
    shutil.rmtree(path / "v_min" / "c")
    with pytest.raises(InputError, match="is no readable data set"):
        dataset.load(path)


def test_two_lattices_at_once(lattice):
    """The solver keeps no state: threads do not disturb each other."""
    found = []
    threads = [
        threading.Thread(target=lambda: found.append(dataset.lattice(ALTITUDES_FT, GAMMAS_DEG, FAILURES, workers=2)))
        for _ in range(2)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for data in found:
        xr.testing.assert_identical(data, lattice)
    assert len(found) == 2
