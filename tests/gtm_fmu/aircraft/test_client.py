"""The FMPy client: names, buffers, modes, the FMU's own words when it refuses, and files that are no FMU."""

import tempfile
import zipfile
from pathlib import Path

import numpy as np
import pytest
from pythonfmu import FmuBuilder

from fmu_src import build
from gtm_fmu.aircraft.client import FmuClient, FmuError
from gtm_fmu.errors import InputError

pytestmark = pytest.mark.slow

AUTOPILOT = Path(__file__).parents[3] / "examples" / "envelope_protection" / "autopilot.py"
"""A slave that pythonfmu wraps itself."""


@pytest.fixture(scope="module")
def path(tmp_path_factory) -> Path:
    return build("dynamics", tmp_path_factory.mktemp("fmu"))


@pytest.fixture
def fmu(path):
    with FmuClient(path) as fmu:
        yield fmu


def test_states_derivatives_and_controls_come_from_the_description(fmu):
    assert fmu.states[:2] == ("state.u", "state.v")
    assert fmu.derivatives == tuple(f"der({name})" for name in fmu.states)
    assert fmu.controls == ("control.elevator", "control.aileron", "control.rudder", "control.throttle")


def test_named_arguments_of_evaluate(path, fmu):
    x, u = fmu.get(fmu.states), fmu.get(fmu.controls)
    x[1] += 3
    expected = fmu.evaluate(x, u)
    names = {"states": ("state.v",), "derivatives": ("der(state.p)", "der(state.v)"), "controls": ()}
    with FmuClient(path, **names) as lateral:
        np.testing.assert_array_equal(lateral.evaluate([x[1]], []), expected[[3, 1]])
        lateral.set(["state.v"], [0.0])
        assert abs(lateral.evaluate([0.0], [])[0]) < 1e-4 < abs(expected[3])


def test_evaluate_gives_arrays_of_its_own(fmu):
    x, u = fmu.get(fmu.states), fmu.get(fmu.controls)
    first = fmu.evaluate(x, u)
    kept = first.copy()
    fmu.evaluate(x + 1, u)
    np.testing.assert_array_equal(first, kept)


def test_start_values(path):
    with FmuClient(path, start_values={"state.altitude": 3000.0, "limits.rudder.upper": 0.1}) as fmu:
        fmu.step(0.1)
        fmu.reset()
        np.testing.assert_array_equal(fmu.get(["state.altitude", "limits.rudder.upper"]), [3000.0, 0.1])


def test_reset(fmu):
    before = fmu.get(fmu.states)
    fmu.step(1.0)
    assert fmu.time_s == 1.0
    with pytest.raises(FmuError, match="call reset first"):
        fmu.evaluate(before, fmu.get(fmu.controls))
    fmu.reset()
    assert fmu.time_s == 0.0
    np.testing.assert_array_equal(fmu.get(fmu.states), before)


def test_simulate_sets_commands_at_each_step(fmu):
    times = []

    def commands(time_s):
        times.append(time_s)
        return {"control.throttle": 0.5 + time_s}

    record = fmu.simulate(0.3, 0.1, ["state.u", "engine.left.rotor_speed"], commands)
    np.testing.assert_allclose(times, [0.0, 0.1, 0.2], atol=1e-15)
    np.testing.assert_allclose(record["time"], [0.0, 0.1, 0.2, 0.3], atol=1e-15)
    t = 70.0  # the rotor speed of SPEC 6 at the throttle of the last step
    speed = 0.000033035538475 * t**3 - 0.008354385314499 * t**2 + 1.191126728328792 * t + 31.518959847101669
    assert record["engine.left.rotor_speed"][-1] == pytest.approx(speed / 100, rel=1e-12)
    again = fmu.simulate(0.5, 0.1, ["state.u"])
    assert again["time"][0] == pytest.approx(0.3)
    assert again["state.u"][0] == record["state.u"][-1]


def test_messages_of_two_instances_are_kept_apart(path, fmu):
    with FmuClient(path) as other:
        other.set(["control.rudder"], [1.0])
        other.step(0.1)
        assert len(other.messages) == 1
    fmu.set(["control.aileron"], [1.0])
    fmu.step(0.1)
    assert [message.category for message in fmu.messages] == ["logStatusWarning"]
    assert "control.aileron" in fmu.messages[0].text


@pytest.fixture
def temporary_folder(tmp_path, monkeypatch) -> Path:
    folder = tmp_path / "temporary"
    folder.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    return folder


def test_close(path, temporary_folder):
    fmu = FmuClient(path)
    assert len(list(temporary_folder.iterdir())) == 1
    fmu.close()
    fmu.close()
    assert not list(temporary_folder.iterdir())
    with pytest.raises(FmuError, match="closed"):
        fmu.get(["state.u"])
    with pytest.raises(FmuError, match="closed"):
        fmu.reset()


class TestBadInput:
    def test_unknown_names(self, path, fmu):
        with pytest.raises(InputError, match=r"no real variable 'state.x': it has state.u, .*\.\.\."):
            fmu.get(["state.u", "state.x"])
        with pytest.raises(InputError, match=r"no real variable 'control.flaps'"):
            fmu.set(["control.flaps"], [0.0])
        with pytest.raises(InputError, match=r"no Boolean variable 'state.u': it has none"):
            fmu.get_boolean("state.u")
        with pytest.raises(InputError, match=r"no real variable 'wind.north'"):
            FmuClient(path, controls=["wind.north"])

    def test_wrong_number_of_values(self, fmu):
        with pytest.raises(ValueError, match="broadcast"):
            fmu.set(["state.u", "state.v"], [1.0, 2.0, 3.0])

    @pytest.mark.parametrize("step_s", [0.0, -0.1, float("nan")])
    def test_steps_that_cannot_be_taken(self, fmu, step_s):
        with pytest.raises(InputError, match="give a positive step"):
            fmu.simulate(1.0, step_s, ["state.u"])

    def test_missing_file(self, tmp_path):
        with pytest.raises(InputError, match=r"There is no FMU '.*none.fmu': give a file that build_fmu.py has made"):
            FmuClient(tmp_path / "none.fmu")

    def test_not_an_archive(self, tmp_path):
        file = tmp_path / "text.fmu"
        file.write_text("no zip")
        with pytest.raises(InputError, match="is not an FMU or is damaged"):
            FmuClient(file)

    def test_truncated(self, path, tmp_path):
        file = tmp_path / "half.fmu"
        file.write_bytes(path.read_bytes()[:100_000])
        with pytest.raises(InputError, match="is not an FMU or is damaged"):
            FmuClient(file)

    def test_damaged_member(self, path, tmp_path):
        """A byte of the wrapper's binary is changed: its checksum does not match any more."""
        content = bytearray(path.read_bytes())
        content[5000] ^= 0xFF
        file = tmp_path / "damaged.fmu"
        file.write_bytes(content)
        with pytest.raises(InputError, match="does not load on this platform"):
            FmuClient(file)

    def test_archive_without_description(self, tmp_path):
        file = tmp_path / "empty.fmu"
        with zipfile.ZipFile(file, "w") as archive:
            archive.writestr("readme.txt", "nothing")
        with pytest.raises(InputError, match="has no valid model description"):
            FmuClient(file)

    def test_damaged_description(self, path, tmp_path):
        file = self._with_description(path, tmp_path, lambda xml: xml.replace(b"<ModelVariables>", b"<Variables>"))
        with pytest.raises(InputError, match="has no valid model description"):
            FmuClient(file)

    def test_model_exchange_without_its_functions(self, path, tmp_path):
        def to_model_exchange(xml):
            start, end = xml.index(b"<CoSimulation"), xml.index(b"/>", xml.index(b"<CoSimulation")) + 2
            return xml[:start] + b'<ModelExchange modelIdentifier="GtmDynamics"/>' + xml[end:]

        with pytest.raises(InputError, match=r"does not load on this platform .*fmi2"):
            FmuClient(self._with_description(path, tmp_path, to_model_exchange))

    def test_no_binary_for_this_platform(self, path, tmp_path):
        file = tmp_path / "elsewhere.fmu"
        with zipfile.ZipFile(path) as source, zipfile.ZipFile(file, "w") as target:
            for name in source.namelist():
                target.writestr(name.replace("binaries/linux64", "binaries/other"), source.read(name))
        with pytest.raises(InputError, match="does not load on this platform"):
            FmuClient(file)

    def test_temporary_folder_that_pythonfmu_cannot_read(self, tmp_path, monkeypatch):
        """Its own binary, in somebody else's FMU, would end this process."""
        foreign = FmuBuilder.build_FMU(AUTOPILOT, tmp_path / "Autopilot.fmu")
        folder = tmp_path / "Übung"
        folder.mkdir()
        monkeypatch.setattr(tempfile, "tempdir", str(folder))
        with pytest.raises(InputError, match="must have a plain ASCII name: set TMPDIR"):
            FmuClient(foreign)
        assert not list(folder.iterdir())

    def test_archive_that_would_fill_the_disk(self, tmp_path):
        file = tmp_path / "huge.fmu"
        with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
            archive.writestr("resources/zeros", bytes(1000))
            archive.filelist[0].file_size = 1_500_000_000
        with pytest.raises(InputError, match=r"huge.fmu' unpacks to 1500 MB, allowed is 1074 MB .*: leave out what"):
            FmuClient(file)

    def test_temporary_folder_with_a_space(self, path, tmp_path, monkeypatch):
        folder = tmp_path / "two words"
        folder.mkdir()
        monkeypatch.setattr(tempfile, "tempdir", str(folder))
        with FmuClient(path) as fmu:
            assert fmu.get(["air.mach"]) > 0

    def test_no_folder_is_left_behind(self, path, tmp_path, temporary_folder):
        self.test_no_binary_for_this_platform(path, tmp_path)
        self.test_damaged_member(path, tmp_path)
        assert not list(temporary_folder.iterdir())

    @staticmethod
    def _with_description(path, tmp_path, change):
        file = tmp_path / "changed.fmu"
        with zipfile.ZipFile(path) as source, zipfile.ZipFile(file, "w") as target:
            for name in source.namelist():
                content = source.read(name)
                target.writestr(name, change(content) if name == "modelDescription.xml" else content)
        return file
