"""GtmSurrogate through FMPy against the networks that it carries, evaluated with NumPy."""

import json
import math
from contextlib import suppress

import fmpy
import numpy as np
import pytest
from fmpy.validation import validate_fmu

from fmu_src import build
from gtm_fmu.aircraft.client import FmuClient, FmuError
from gtm_fmu.errors import InputError

from .conftest import CASE_RANGES, random_networks, read

pytestmark = pytest.mark.slow

CASE = ("altitude", "gamma", "rudder.lower", "rudder.upper")
ENVELOPE = ("v_min", "v_max", "v_min_std", "v_max_std")
OUTPUTS = (*ENVELOPE, "margin.slow", "margin.fast", "feasible", "in_domain")
SI = np.array([0.3048, math.pi / 180, math.pi / 180, math.pi / 180])
KN = 0.3048 / 0.592487


@pytest.fixture(scope="module")
def opened(surrogate_fmu):
    with FmuClient(surrogate_fmu) as fmu:
        yield fmu


@pytest.fixture
def fmu(opened):
    opened.reset()
    opened.messages.clear()
    return opened


def random_cases(count: int) -> np.ndarray:
    rng = np.random.default_rng(3)
    cases = rng.uniform(*np.array(CASE_RANGES).T, (count, 4))
    cases[:, 2:].sort(axis=1)
    return cases


def test_fmpy_validation_is_clean(surrogate_fmu):
    assert validate_fmu(str(surrogate_fmu)) == []


def test_interface(surrogate_fmu):
    variables = {v.name: v for v in fmpy.read_model_description(surrogate_fmu).modelVariables}
    assert {name for name, v in variables.items() if v.causality == "input"} == {*CASE, "tas"}
    assert {name for name, v in variables.items() if v.causality == "output"} == set(OUTPUTS)
    assert [v.type for v in variables.values() if v.name in ("feasible", "in_domain")] == ["Boolean", "Boolean"]
    units = {name: (v.unit, v.displayUnit) for name, v in variables.items()}
    assert (units["altitude"], units["gamma"]) == (("m", "ft"), ("rad", "deg"))
    assert units["v_min_std"] == units["margin.fast"] == units["tas"] == ("m/s", "kn")


def test_same_values_as_the_networks(fmu, networks):
    speeds, throttle, _ = networks
    seen = set()
    for case in random_cases(200):
        fmu.set((*CASE, "tas"), [*(case * SI), 110 * KN])
        v_min, v_max = speeds.predict(case)
        expected = np.array([v_min, v_max, *speeds.predict_std(case), 110 - v_min, v_max - 110])
        got = fmu.get((*ENVELOPE, "margin.slow", "margin.fast")) / KN
        np.testing.assert_allclose(got, expected, rtol=1e-11, atol=1e-10)
        feasible = bool(throttle.predict(case)[0] <= 100 and v_min <= v_max)
        assert fmu.get_boolean("feasible") is feasible
        assert fmu.get_boolean("in_domain") is True
        seen.add((feasible, bool(v_min <= v_max)))
    assert seen == {(True, True), (False, True), (False, False)}


def test_a_step_takes_new_inputs(fmu, networks):
    case = random_cases(1)[0]
    fmu.step(0.1)
    fmu.set(CASE, case * SI)
    fmu.step(0.1)
    np.testing.assert_allclose(fmu.get(("v_min", "v_max")) / KN, networks[0].predict(case), rtol=1e-12)


@pytest.mark.parametrize("end", [0, 1])
@pytest.mark.parametrize("place", range(4))
def test_domain(fmu, place, end):
    """On the edge of the training data, a rounding beyond it, and outside."""
    case = np.array([1000.0, 0.0, -30.0, 30.0])
    case[2:] = (CASE_RANGES[place][end],) * 2 if place >= 2 else case[2:]
    case[place] = edge = CASE_RANGES[place][end]
    outward = 2 * end - 1
    for value, inside in ((edge, True), (edge + outward * 1e-12, True), (edge + outward * 0.01, False)):
        case[place] = value
        case[2:].sort()
        fmu.set(CASE, case * SI)
        assert fmu.get_boolean("in_domain") is inside


def test_far_outside_is_finite(fmu):
    fmu.set(CASE, [1e9, 1e6, -1e3, 1e3])
    fmu.step(0.1)
    assert not fmu.get_boolean("in_domain")
    assert np.isfinite(fmu.get(OUTPUTS[:6])).all()


class TestBadInput:
    @pytest.mark.parametrize(
        ("values", "sentence"),
        [
            (
                {"rudder.lower": 0.2, "rudder.upper": 0.1},
                "rudder limits are reversed: lower 0.2 is above upper 0.1 rad",
            ),
            ({"altitude": math.nan}, "altitude was given as nan, allowed is a finite number"),
            ({"tas": math.inf}, "tas was given as inf, allowed is a finite number"),
            ({"altitude": 1.7e308, "gamma": 1.7e308}, "not finite at these inputs"),
        ],
    )
    def test_step_is_discarded(self, fmu, values, sentence):
        fmu.step(0.1)
        before = fmu.get(OUTPUTS[:6])
        fmu.messages.clear()
        with suppress(FmuError):  # a number that is not finite
            fmu.set(tuple(values), list(values.values()))
        with pytest.raises(FmuError, match=sentence):
            fmu.step(0.1)
        assert fmu.messages[-1].status == 2
        status, after = read(fmu, [fmu.reference(name) for name in OUTPUTS[:6]])
        assert status == 2
        np.testing.assert_array_equal(after, before)
        fmu.set((*CASE, "tas"), [1000.0, 0.0, -0.1, 0.1, 50.0])
        fmu.step(0.1)

    def test_reading_is_refused(self, fmu):
        fmu.set(("rudder.lower", "rudder.upper"), [0.2, 0.1])
        with pytest.raises(FmuError, match="reversed"):
            fmu.get(("v_min",))

    def test_networks_missing(self, tmp_path):
        with pytest.raises(InputError, match="3 networks were given for the surrogate FMU: give speeds and throttle"):
            build("surrogate", tmp_path, [tmp_path] * 3)
        with pytest.raises(InputError, match="cannot read the model file"):
            build("surrogate", tmp_path, [tmp_path / "a.json", tmp_path / "b.json"])

    def test_networks_swapped(self, networks, tmp_path):
        with pytest.raises(InputError, match="is not a network of v_min_kt, v_max_kt over altitude_ft, gamma_deg"):
            build("surrogate", tmp_path, networks[2][::-1])

    def test_network_damaged(self, networks, tmp_path):
        text = networks[2][0].read_text()
        weight = str(json.loads(text)["model"]["biases"][0][0])
        (tmp_path / "speeds.json").write_text(text.replace(weight, "0.5"))
        with pytest.raises(InputError, match="is damaged"):
            build("surrogate", tmp_path, [tmp_path / "speeds.json", networks[2][1]])
        assert not list(tmp_path.glob("*.fmu"))


class TestOneProcess:
    def test_two_different_fmus(self, dynamics_fmu, surrogate_fmu, networks):
        """Both have a module called slave; each runs its own."""
        with FmuClient(dynamics_fmu) as dynamics, FmuClient(surrogate_fmu) as surrogate:
            for fmu in (dynamics, surrogate, dynamics):
                fmu.step(0.1)
            case = random_cases(1)[0]
            surrogate.set(CASE, case * SI)
            np.testing.assert_allclose(surrogate.get(("v_min", "v_max")) / KN, networks[0].predict(case), rtol=1e-12)
            assert dynamics.get(("air.tas",)) / 0.3048 == pytest.approx(164.14225, abs=1e-6)

    def test_two_surrogates(self, surrogate_fmu, networks, tmp_path):
        others = random_networks(11, tmp_path)
        with FmuClient(surrogate_fmu) as one, FmuClient(build("surrogate", tmp_path, others[2])) as other:
            for case in random_cases(3):
                for fmu, (speeds, *_) in ((one, networks), (other, others)):
                    fmu.set(CASE, case * SI)
                    np.testing.assert_allclose(fmu.get(("v_min", "v_max")) / KN, speeds.predict(case), rtol=1e-12)


def test_equal_networks_give_equal_bytes(surrogate_fmu, networks, tmp_path):
    assert build("surrogate", tmp_path, networks[2]).read_bytes() == surrogate_fmu.read_bytes()


def test_state_set_back(fmu):
    state = fmu.instance.getFMUstate()
    before = fmu.get(OUTPUTS[:6])
    fmu.set(CASE, random_cases(1)[0] * SI)
    assert (fmu.get(OUTPUTS[:6]) != before).all()
    fmu.instance.setFMUstate(state)
    np.testing.assert_array_equal(fmu.get(OUTPUTS[:6]), before)
    fmu.instance.freeFMUstate(state)
