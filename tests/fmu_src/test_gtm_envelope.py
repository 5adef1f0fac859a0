"""The envelope FMUs, in Python and in C, against `gtm_fmu.envelopes.envelope` in this process."""

import csv
import io
import math
import time
import zipfile
from ctypes import byref, c_void_p

import fmpy
import numpy as np
import pytest
from fmpy.validation import validate_fmu

from gtm_fmu.aircraft.client import FmuClient, FmuError
from gtm_fmu.aircraft.limits import ControlLimits
from gtm_fmu.envelopes.envelope import envelope
from tests.fmu_src.native_session import DISCARD, OK

pytestmark = pytest.mark.slow

CASE = ("altitude", "gamma", "rudder.lower", "rudder.upper")
SPEEDS = ("v_min", "v_max", "v_min_std", "v_max_std", "margin.slow", "margin.fast")
SI = np.array([0.3048, math.pi / 180, math.pi / 180, math.pi / 180])
KN = 0.3048 / 0.592487  # SPEC 1
TAS_KT = 90.0
# altitude in ft, gamma and rudder in deg; the last one leaves no envelope
CASES = ((10000, 0, -30, 30), (10000, -5, 10, 10), (25000, 2, -12, 3), (0, -3, -17.5, -17.5), (36000, 3, 28, 28))
FAILURE = ("limits.", "damage.", "engine.", "stabilizer.", "control.", "fuel.")
FOUND: dict[tuple, np.ndarray] = {}


@pytest.fixture(scope="module")
def opened(envelope_fmus):
    with FmuClient(envelope_fmus["python"]) as python, FmuClient(envelope_fmus[2]) as native:
        yield {"python": python, 2: native}


def expected(case) -> np.ndarray:
    """Speeds in kn and whether there is an envelope."""
    if case not in FOUND:
        left = envelope(*case[:2], ControlLimits(rudder_deg=case[2:]))
        v_min, v_max = left.v_min_kt or 0.0, left.v_max_kt or 0.0
        FOUND[case] = np.array([v_min, v_max, 0, 0, TAS_KT - v_min, v_max - TAS_KT, left.feasible])
    return FOUND[case]


def test_interface_is_that_of_the_surrogate(envelope_fmus, thrust_map_fmus, surrogate_fmu):
    """The exact envelope takes more failures, whose variables come after all of the interface."""
    theirs = fmpy.read_model_description(surrogate_fmu).modelVariables
    attributes = ("name", "valueReference", "causality", "variability", "initial", "unit", "displayUnit")
    attributes += ("start", "min", "max", "nominal")
    for path in (*envelope_fmus.values(), *thrust_map_fmus.values()):
        assert validate_fmu(str(path)) == []
        mine = fmpy.read_model_description(path).modelVariables
        others = [variable.name for variable in mine[len(theirs) :] if not variable.name.startswith(FAILURE)]
        assert others in ([], ["time"], ["fold", "v_min_safe", "v_max_safe", "feasible_safe", "time"])
        for ours, other in zip(mine, theirs, strict=False):
            for attribute in attributes:
                assert getattr(ours, attribute) == getattr(other, attribute), (ours.name, attribute)


@pytest.mark.parametrize("kind", ["python", 2])
def test_same_values_as_in_process(opened, kind):
    fmu = opened[kind]
    fmu.reset()
    for number, case in enumerate(CASES):
        fmu.set((*CASE, "tas"), [*(case * SI), TAS_KT * KN])
        fmu.step(0.1)
        got = [*(fmu.get(SPEEDS) / KN), fmu.get_boolean("feasible")]
        np.testing.assert_allclose(got, expected(case), rtol=0, atol=1e-9)
        assert fmu.get_boolean("in_domain")
        assert expected(case)[-1] == (number < len(CASES) - 1)


def test_same_values_in_model_exchange(envelope_session):
    session = envelope_session("me")
    session.call("EnterContinuousTimeMode")
    references = [session.names[name] for name in SPEEDS]
    for case in CASES:
        assert session.set(range(5), [*(case * SI), TAS_KT * KN]) == OK
        status, got = session.get(references)
        assert status == OK
        np.testing.assert_allclose(np.array(got) / KN, expected(case)[:-1], rtol=0, atol=1e-9)


@pytest.mark.parametrize("name", ["envelope-native", "manoeuvre-native", "thrust-map-native"])
def test_expected_results_that_travel_in_the_fmu(name, built):
    with zipfile.ZipFile(built(name)) as archive:
        tables = [
            list(csv.DictReader(io.StringIO(archive.read(f"extra/alt.gtm-fmu/reference_{name}.csv").decode())))
            for name in ("input", "result")
        ]
    with FmuClient(built(name)) as fmu:
        for given, result in zip(*tables, strict=True):
            inputs = [name for name in given if name != "time"]
            fmu.set(inputs, [float(given[name]) for name in inputs])
            names = [name for name in result if name not in ("time", "feasible")]
            np.testing.assert_allclose(fmu.get(names), [float(result[name]) for name in names], rtol=1e-8, atol=1e-12)
            assert fmu.get_boolean("feasible") is (result["feasible"] == "1")
    if name == "envelope-native":
        failing = [name for name in inputs if name.startswith(FAILURE)]
        assert len(failing) == 4
        assert all(len({row[name] for row in tables[0]}) > 1 for name in failing)


REVERSED = {"rudder.lower": 0.2, "rudder.upper": 0.1}
REFUSED = {
    "altitude": (math.nan, 12000.0, -1.0),
    "gamma": (-0.8,),
    "rudder.upper": (0.53,),
    "tas": (math.inf,),
}


class TestBadInput:
    def step_with(self, fmu, values):
        """In C a value is refused at once, in Python when the step is taken."""
        fmu.set(list(values), list(values.values()))
        fmu.step(0.1)

    @pytest.mark.parametrize("kind", ["python", 2])
    @pytest.mark.parametrize(
        ("values", "sentence"),
        [
            (REVERSED, "The rudder limits are reversed"),
            *(({name: value}, f"{name} was given as") for name, values in REFUSED.items() for value in values),
        ],
    )
    def test_step_is_discarded(self, opened, kind, values, sentence):
        fmu = opened[kind]
        fmu.reset()
        fmu.messages.clear()
        with pytest.raises(FmuError, match=sentence):
            self.step_with(fmu, values)
        fmu.set((*CASE, "tas"), [*(CASES[1] * SI), TAS_KT * KN])
        fmu.step(0.1)
        np.testing.assert_allclose(fmu.get(SPEEDS) / KN, expected(CASES[1])[:-1], rtol=0, atol=1e-9)

    @pytest.mark.parametrize("kind", ["cs", "me"])
    def test_status_and_sentence(self, envelope_session, kind):
        session = envelope_session(kind)
        outputs = [session.names[name] for name in SPEEDS]
        before = session.get(outputs)[1]
        for name, values in REFUSED.items():
            for value in values:
                assert session.set([session.names[name]], [value]) == DISCARD
                status, got = session.get(outputs)
                assert status == DISCARD
                assert got == before
                assert [text.split(" w")[0] for text in session.texts()] == [name, name]
                assert session.set([session.names[name]], [session.starts[name]]) == OK
        assert session.set([session.names[name] for name in REVERSED], list(REVERSED.values())) == OK
        assert session.get(outputs) == (DISCARD, before)
        if kind == "cs":
            assert session.step(0.0, 0.1) == DISCARD
        assert all("rudder limits are reversed" in text for text in session.texts())


def test_the_envelope_is_found_only_when_the_case_changes(envelope_session):
    """A thousand speeds in one case take less than thirty cases."""
    session = envelope_session("cs")

    def seconds(steps) -> float:
        start = time.process_time()
        for tas, altitude in steps:
            assert session.set([session.names["altitude"], session.names["tas"]], [altitude, tas]) == OK
            assert session.get([session.names["margin.slow"]])[0] == OK
        return time.process_time() - start

    assert seconds([(50.0 + 0.01 * i, 3000.0) for i in range(1000)]) < seconds([(50.0, 300.0 * i) for i in range(30)])


def test_saved_state_gives_the_same_bits(envelope_session):
    session = envelope_session("cs")
    outputs = [session.names[name] for name in SPEEDS]
    session.set(range(4), CASES[2] * SI)
    before = session.get(outputs)
    state = c_void_p()
    save, restore, free = session.state_functions
    assert session.call(save, byref(state)) == OK
    session.set(range(4), CASES[1] * SI)
    assert session.get(outputs) != before
    assert session.call(restore, state) == OK
    assert session.get(outputs) == before
    assert session.call(free, byref(state)) == OK
