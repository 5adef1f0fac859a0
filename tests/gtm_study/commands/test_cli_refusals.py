"""The command line refuses every mistake with exit code 2 and one sentence on standard error."""

import json
import re
import shutil
import zipfile

import pytest

from surrogate.rudder.emulator import RudderEmulator
from surrogate.rudder.names import SPEEDS_FILE, THROTTLE_FILE

pytestmark = pytest.mark.slow

AT = "--altitude-ft 10000 --tas-kt 118.5"


def assert_sentence(answer, pattern: str) -> None:
    """Exit code 2 and one sentence on standard error, nothing else."""
    assert answer.code == 2, answer
    assert answer.out == ""
    assert re.fullmatch(r"gtm-fmu: [^\n]+\.\n", answer.err), answer.err
    assert re.search(pattern, answer.err), answer.err


BAD_FLIGHT = [
    ("--altitude-ft -1", "altitude in ft -1 is outside 0 .. 36089"),
    ("--altitude-ft 36090", "altitude in ft 36090 is outside 0 .. 36089"),
    ("--altitude-ft nan", "altitude in ft nan is outside"),
    ("--altitude-ft inf", "altitude in ft inf is outside"),
    ("--altitude-ft ten", "--altitude-ft.*number"),
    ("--gamma-deg nan", "gamma in deg nan is outside -45 .. 45"),
    ("--gamma-deg 46", "gamma in deg 46 is outside"),
    ("--gamma-deg", "--gamma-deg"),
    ("--rudder-deg 10 -10", "rudder in deg: limits 10 -10 are reversed"),
    ("--rudder-deg -31 10", "rudder in deg: limits -31 10 are outside -30 .. 30"),
    ("--rudder-deg 0 30.001", "rudder in deg: limits 0 30.001 are outside -30 .. 30"),
    ("--rudder-deg nan 10", "rudder in deg: limits nan 10 are not finite"),
    ("--rudder-deg 0 inf", "not finite"),
    ("--rudder-deg a b", "--rudder-deg.*number"),
    ("--rudder-deg 10", "--rudder-deg.*takes 2 values"),  # the next option is no number
    ("--rudder-deg 1 2 3", r"unexpected extra argument.*3"),
    ("--nonsense 1", "No such option: --nonsense"),
    ("nonsense", "unexpected extra argument.*nonsense"),
]
BAD_LIMITS = [
    ("--elevator-deg -31 0", "elevator in deg: limits -31 0 are outside -30 .. 30"),
    ("--aileron-deg -21 0", "aileron in deg: limits -21 0 are outside -20 .. 20"),
    ("--throttle-pct 0 101", "throttle in %: limits 0 101 are outside 0 .. 100"),
    ("--throttle-pct 60 40", "throttle in %: limits 60 40 are reversed"),
    ("--alpha-deg 10 -5", "alpha in deg 10 -5 are reversed"),
    ("--alpha-deg nan 5", "alpha in deg nan is outside"),
    ("--phi-deg -90 90", "phi in deg -90 is outside -80 .. 80"),
]
BAD_TARGETS = [
    ("--tas-kt nan", "tas in kn nan is outside 20 .. 350"),
    ("--tas-kt 0", "tas in kn 0 is outside 20 .. 350"),
    ("--tas-kt 351", "tas in kn 351 is outside 20 .. 350"),
    ("--turn-rate-deg-s nan", "turn rate in deg/s nan is outside -90 .. 90"),
]
FLIGHT = {command: AT for command in ("trim", "linearize")}
FLIGHT |= {command: "--altitude-ft 10000" for command in ("envelope", "predict")}


class TestBadInput:
    @pytest.mark.parametrize("command", FLIGHT)
    @pytest.mark.parametrize(("given", "sentence"), BAD_FLIGHT)
    def test_flight(self, ask, command, given, sentence):
        assert_sentence(ask(f"{command} {FLIGHT[command]} {given} --json"), sentence)

    @pytest.mark.parametrize("command", ["trim", "linearize", "envelope"])
    @pytest.mark.parametrize(("given", "sentence"), BAD_LIMITS)
    def test_limits(self, ask, command, given, sentence):
        assert_sentence(ask(f"{command} {FLIGHT[command]} {given} --json"), sentence)

    @pytest.mark.parametrize("command", ["trim", "linearize"])
    @pytest.mark.parametrize(("given", "sentence"), BAD_TARGETS)
    def test_targets(self, ask, command, given, sentence):
        assert_sentence(ask(f"{command} {FLIGHT[command]} {given} --json"), sentence)

    @pytest.mark.parametrize("command", FLIGHT)
    def test_missing_option(self, ask, command):
        assert_sentence(ask(command), "Missing option '--altitude-ft'; see `gtm-fmu .* --help`")

    def test_missing_speed(self, ask):
        assert_sentence(ask("trim --altitude-ft 1000"), "No speed is given; give one")

    @pytest.mark.parametrize(
        ("words", "command", "held"),
        [
            ("--altitude-ft 10000 --rudder-deg 5", "envelope", "5"),
            ("--altitude-ft 10000 --rudder-deg 5 --tas-kt 80", "trim", "5"),
            ("--altitude-ft 10000 --rudder-deg --tas-kt 80", "linearize", "nothing"),
            ("--altitude-ft 10000 --rudder-deg 5", "predict", "5"),
            ("store --cases 3 --rudder-deg", "dataset", "nothing"),
            ("--plot map.html --rudder-deg 5", "map limits", "5"),
        ],
    )
    def test_pair_with_too_few_values(self, ask, words, command, held):
        sentence = f"'--rudder-deg' takes 2 values (LOWER UPPER), but {held} was given; see `gtm-fmu {command} --help`"
        assert_sentence(ask(f"{command} {words}"), re.escape(sentence))

    def test_option_without_its_value(self, ask):
        sentence = "'--over' takes 4 values (AXIS LOWER UPPER STEP), but gamma -5 5 was given; see `gtm-fmu envelope"
        assert_sentence(ask("envelope --altitude-ft 0 --over gamma -5 5"), re.escape(sentence))
        assert_sentence(ask("predict --altitude-ft"), "--altitude-ft.*see `gtm-fmu predict --help`")

    @pytest.mark.parametrize(
        ("command", "sentence"),
        [
            ("fly --altitude-ft 1000", "No such command 'fly'"),
            ("--json", "No such option: --json"),
            ("build glider", "No FMU is called 'glider': choose one of dynamics, "),
            ("build dynamics --model here", "--model here is for the FMUs of surrogates"),
            ("study --seed -1", "--seed.*-1 is not in the range 0"),
            ("study --seed one", "--seed.*integer"),
        ],
    )
    def test_commands(self, ask, tmp_path, monkeypatch, command, sentence):
        monkeypatch.chdir(tmp_path)
        assert_sentence(ask(command), sentence)
        assert not list(tmp_path.iterdir())


class TestBadFmu:
    def refused(self, ask, path, sentence):
        for command in ("trim", "linearize"):
            assert_sentence(ask(command, *AT.split(), "--fmu", path, "--json"), sentence)

    def test_missing(self, ask, tmp_path):
        self.refused(ask, tmp_path / "none.fmu", "There is no FMU '.*none.fmu'")
        self.refused(ask, tmp_path, "There is no FMU")

    def test_no_archive(self, ask, tmp_path):
        path = tmp_path / "text.fmu"
        path.write_text("no archive")
        self.refused(ask, path, "is not an FMU or is damaged")

    def test_cut_short(self, ask, tmp_path, fmus):
        path = tmp_path / "cut.fmu"
        path.write_bytes(fmus["dynamics"].read_bytes()[:100000])
        self.refused(ask, path, "is not an FMU or is damaged")

    def test_flipped_bytes(self, ask, tmp_path, fmus):
        data = bytearray(fmus["dynamics"].read_bytes())
        for place in range(50000, len(data) - 50000, 500):
            data[place] ^= 0xFF
        path = tmp_path / "flipped.fmu"
        path.write_bytes(data)
        self.refused(ask, path, "build it (again|here)")

    def test_another_archive(self, ask, tmp_path):
        with zipfile.ZipFile(tmp_path / "other.fmu", "w") as archive:
            archive.writestr("letter.txt", "dear reader")
        self.refused(ask, tmp_path / "other.fmu", "no valid model description")

    def test_another_model(self, ask, fmus):
        self.refused(ask, fmus["surrogate"], "has no real variable 'state.u'")

    def test_core_of_no_platform(self, ask, tmp_path, fmus):
        path = tmp_path / "nowhere.fmu"
        with zipfile.ZipFile(fmus["dynamics"]) as whole, zipfile.ZipFile(path, "w") as part:
            for name in whole.namelist():
                if not name.startswith("resources/core/"):
                    part.writestr(name, whole.read(name))
        self.refused(ask, path, "no compiled core for this platform")


class TestBadFiles:
    @pytest.fixture
    def blocked(self, tmp_path):
        """A folder that nobody can make, not even root."""
        (tmp_path / "file").write_text("in the way")
        return tmp_path / "file" / "folder"

    @pytest.mark.parametrize("command", ["build dynamics", "build surrogate", "study"])
    def test_no_permission(self, ask, blocked, command):
        assert_sentence(ask(*command.split(), "--output", blocked), "Cannot write .*choose (another|a) folder")
        assert_sentence(ask(*command.split(), "--output", blocked.parent), "Cannot write .*choose (another|a) folder")
        assert blocked.parent.read_text() == "in the way"

    def predict_and_build(self, ask, folder, sentence):
        output = folder.parent / "fmu"
        assert_sentence(ask("predict", "--altitude-ft", 10000, "--model", folder, "--json"), sentence)
        assert_sentence(ask("build", "surrogate", "--model", folder, "--output", output), sentence)
        assert not output.exists()

    @pytest.fixture
    def model(self, tmp_path):
        """A folder of networks, to be damaged."""
        folder = tmp_path / "model"
        folder.mkdir()
        RudderEmulator.load().save(folder)
        return folder

    def test_missing_model(self, ask, tmp_path):
        self.predict_and_build(ask, tmp_path / "none", "--model was given as '.*none': give thrust-map, network, paper")

    def test_file_as_model(self, ask, model):
        self.predict_and_build(ask, model / SPEEDS_FILE, "is no readable thrust map")

    @pytest.mark.parametrize("name", [SPEEDS_FILE, THROTTLE_FILE])
    def test_half_a_model(self, ask, model, name):
        (model / name).unlink()
        self.predict_and_build(ask, model, f"cannot read the model file '.*{name}'")

    @pytest.mark.parametrize("name", [SPEEDS_FILE, THROTTLE_FILE])
    def test_damaged_model(self, ask, model, name):
        text = (model / name).read_text()
        (model / name).write_text(text[: len(text) // 2])
        self.predict_and_build(ask, model, f"{name}' is not a model file or is damaged")
        (model / name).write_text("{}")
        self.predict_and_build(ask, model, f"{name}' is a JSON file but holds no model")

    def test_changed_weight(self, ask, model):
        document = json.loads((model / SPEEDS_FILE).read_text())
        document["model"]["biases"][0][0] += 0.1
        (model / SPEEDS_FILE).write_text(json.dumps(document))
        self.predict_and_build(ask, model, "is damaged, as its checksum does not match")

    def test_another_model(self, ask, model):
        shutil.copy(model / THROTTLE_FILE, model / SPEEDS_FILE)
        self.predict_and_build(ask, model, "holds networks of another model")
