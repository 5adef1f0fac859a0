"""The manoeuvre FMUs against `gtm_fmu.trims` in this process."""

import math
from collections.abc import Callable, Iterator
from ctypes import byref, c_void_p
from dataclasses import dataclass, field
from pathlib import Path

import fmpy
import numpy as np
import pytest

from gtm_fmu.aircraft.client import FmuClient, FmuError
from gtm_fmu.aircraft.failures import Failure
from gtm_fmu.aircraft.limits import ControlLimits
from gtm_fmu.core.configuration import Configuration
from gtm_fmu.trims.linearization import linearize
from gtm_fmu.trims.steady import trim, trims
from tests.fmu_src.conftest import sessions
from tests.fmu_src.native_session import DISCARD, ERROR, OK, Session
from tests.fmu_src.test_failure_envelopes import DEG, FT, KN, Given, give, pair

pytestmark = pytest.mark.slow

ANGLES = ("alpha", "beta", "bank", "elevator", "aileron", "rudder")
THROTTLES = ("throttle.left", "throttle.right")
TRIM = [f"trim.{name}" for name in (*ANGLES, *THROTTLES)]
# SPEC 9; sideslip as far as the tables go
RANGES = {"alpha": (-5, 10.5), "beta": (-45, 45), "bank": (-30, 30), "elevator": (-30, 30), "aileron": (-20, 20)}
RANGES |= {"rudder": (-30, 30), "throttle.left": (0, 100), "throttle.right": (0, 100)}


@dataclass(frozen=True)
class Case:
    """A manoeuvre in ft, kn, deg and deg/s; what the FMU is told of the failure, and the failure that it is."""

    at: tuple[float, float, float, float]
    told: Given = field(default_factory=dict)
    failure: Failure = field(default_factory=Failure)
    ranges: dict[str, tuple[float, float]] = field(default_factory=dict)

    @property
    def given(self) -> Given:
        altitude_ft, tas_kt, gamma_deg, rate_deg_s = self.at
        condition = {"altitude": altitude_ft * FT, "tas": tas_kt * KN, "gamma": gamma_deg * DEG}
        return {**condition, "turn_rate": rate_deg_s * DEG, **self.told}


LEFT_OUT = Configuration(engine_running=(False, True))
CASES = {
    "nothing failed": Case((10000, 100, 0, 3)),
    "straight": Case((3000, 120, -3, 0)),
    "jam": Case((3000, 90, -2, 3), pair("rudder", 4, 4), Failure(ControlLimits(rudder_deg=(4, 4))), {"rudder": (4, 4)}),
    "too fast": Case((3000, 190, 0, 0), pair("rudder", 4, 4), Failure(ControlLimits(rudder_deg=(4, 4)))),
    "aileron": Case(
        (3000, 90, -2, 3), pair("aileron", -2, 1), Failure(ControlLimits(aileron_deg=(-2, 1))), {"aileron": (-2, 1)}
    ),
    "engine out": Case((3000, 90, -4, 2), {"engine.left.running": False}, Failure(configuration=LEFT_OUT)),
    "engines apart": Case(
        (3000, 90, -2, 2),
        {"engine.separate": True, **pair("throttle.left", 0, 20, 0.01), **pair("rudder", 6, 6)},
        Failure(ControlLimits(rudder_deg=(6, 6)), throttle_left_pct=(0, 20)),
        {"throttle.left": (0, 20)},
    ),
    "damage": Case(
        (3000, 100, -2, 2), {"damage.case": 4.0, "control.gear": 1.0}, Failure(configuration=Configuration(4, gear=1))
    ),
}


@pytest.fixture(scope="module")
def opened(manoeuvre_fmus) -> Iterator[dict]:
    with FmuClient(manoeuvre_fmus["python"]) as python, FmuClient(manoeuvre_fmus[2]) as native:
        yield {"python": python, 2: native}


@pytest.fixture(scope="module")
def folders(manoeuvre_fmus, tmp_path_factory) -> dict[int, Path]:
    folder = tmp_path_factory.mktemp("unpacked")
    return {fmi: Path(fmpy.extract(manoeuvre_fmus[fmi], folder / str(fmi))) for fmi in (2, 3)}


@pytest.fixture
def start(fmi, folders) -> Iterator[Callable[..., Session]]:
    yield from sessions(folders[fmi], fmi)


@pytest.mark.parametrize("kind", ["python", 2])
@pytest.mark.parametrize("name", CASES)
def test_trim_margins_and_verdicts(opened, kind, name):
    case, fmu = CASES[name], opened[kind]
    altitude_ft, tas_kt, gamma_deg, rate_deg_s = case.at
    expected = trim(altitude_ft, tas_kt, gamma_deg, rate_deg_s, case.failure)
    fmu.reset()
    give(fmu, case.given)
    fmu.step(0.1)
    angles = [getattr(expected, f"{angle}_deg") for angle in ("alpha", "beta", "phi", "elevator", "aileron", "rudder")]
    throttles = [expected.throttle_pct] * 2
    if expected.throttle_pct is None:
        throttles = [expected.throttle_left_pct, expected.throttle_right_pct]
    at = np.array([*angles, *throttles])
    unit = np.array([DEG] * 6 + [0.01] * 2)
    np.testing.assert_allclose(fmu.get(TRIM) / unit, at, rtol=0, atol=1e-6)
    assert fmu.get_boolean("found")
    assert fmu.get_boolean("feasible") is expected.feasible is (name != "too fast")
    if expected.feasible:
        model = linearize(expected)
        assert (fmu.get_boolean("stable"), fmu.get_boolean("controllable")) == (model.stable, model.controllable)
    ranges = RANGES | case.ranges
    if name == "too fast" or name == "engines apart":
        ranges["rudder"] = (at[5], at[5])
    margins = np.array([(value - ranges[n][0], ranges[n][1] - value) for n, value in zip(ranges, at, strict=True)])
    found = fmu.get([f"margin.{n}.{end}" for n in ranges for end in ("lower", "upper")]).reshape(-1, 2)
    np.testing.assert_allclose(found / unit[:, None], margins, rtol=0, atol=1e-6)


@pytest.mark.parametrize(
    ("name", "binding"),
    [("nothing failed", None), ("too fast", "throttle.upper"), ("aileron", None), ("engines apart", None)],
)
def test_binding_limit(opened, name, binding):
    """The limit with the least margin over the typical size of what it limits (rad, deg and % by the core's scales)."""
    size = np.array([0.05, 0.05, 0.17, 4 * DEG, 4 * DEG, 6 * DEG, 0.2, 0.2])
    names = [f"{n}.{end}" for n in RANGES for end in ("lower", "upper")]
    told = []
    for fmu in opened.values():
        fmu.reset()
        give(fmu, CASES[name].given)
        margins = fmu.get([f"margin.{n}" for n in names]) / np.repeat(size, 2)
        margins[np.array(margins) == 0] = np.inf
        nearest = names[int(np.argmin(margins))]
        if name != "engines apart":
            nearest = nearest.replace("throttle.left", "throttle")
        told.append(fmu.get_item("binding"))
        assert told[-1] == nearest
    assert told[0] == told[1] == (binding or told[0])


@pytest.mark.parametrize("kind", ["python", 2])
@pytest.mark.parametrize("name", ["jam", "engine out", "nothing failed"])
def test_ends_of_the_turn_rate(opened, kind, name):
    """By trims: the ends can be flown, and nothing beyond them on a fine grid."""
    case, fmu = CASES[name], opened[kind]
    altitude_ft, tas_kt, gamma_deg, _ = case.at
    fmu.reset()
    give(fmu, case.given)
    least, greatest = fmu.get(("turn_rate.least", "turn_rate.greatest")) / DEG
    assert -90 < least < 0 < greatest < 90
    rates = np.arange(-40, 40, 0.05)
    is_flown = trims(altitude_ft, tas_kt, gamma_deg, rates, case.failure).status == 0
    assert rates[is_flown].min() == pytest.approx(least, abs=0.051)
    assert rates[is_flown].max() == pytest.approx(greatest, abs=0.051)
    assert not is_flown[(rates < least - 1e-6) | (rates > greatest + 1e-6)].any()
    for end in (least, greatest):
        fmu.set(("turn_rate",), [(end - 1e-6 * np.sign(end)) * DEG])
        assert fmu.get_boolean("feasible")


@pytest.mark.parametrize("kind", ["python", 2])
def test_nothing_found(opened, kind):
    """A speed without any trim: defined numbers, and an empty interval of turn rates."""
    fmu = opened[kind]
    fmu.reset()
    give(fmu, Case((30000, 25, 0, 0)).given)
    assert not fmu.get_boolean("found")
    assert not fmu.get_boolean("feasible")
    assert fmu.get_item("binding") == "none"
    assert set(fmu.get(TRIM)) == {0.0}
    np.testing.assert_allclose(fmu.get(("turn_rate.least", "turn_rate.greatest")) / DEG, [90, -90], rtol=1e-12)


@pytest.mark.parametrize("kind", ["python", 2])
@pytest.mark.parametrize(
    ("values", "sentence"),
    [
        (pair("bank", 5, -5), "limits.bank.lower is above limits.bank.upper"),
        ({"damage.case": 0.5}, "damage.case is no whole number"),
        ({"tas": 5.0}, "tas was given as 5, allowed is 10.288"),
        ({"turn_rate": math.inf}, "turn_rate was given as inf, allowed is -1.57"),
        ({"altitude": -10.0}, "altitude was given as -10, allowed is 0"),
    ],
)
def test_bad_input(opened, kind, values, sentence):
    fmu = opened[kind]
    fmu.reset()
    fmu.messages.clear()

    def refused():
        give(fmu, values)
        fmu.get(("turn_rate.least",))
        fmu.step(0.1)

    with pytest.raises(FmuError, match=sentence):
        refused()


class TestNative:
    def test_enumeration(self, start):
        session = start()
        declared = next(v for v in session.description.modelVariables if v.name == "binding").declaredType
        items = {int(item.value): item.name for item in declared.items}
        assert (
            len(items) == 19
        )  # none, and two each of alpha, beta, bank, three surfaces and throttles left, right, both
        status, value = session.get_enumeration("binding")
        assert status == OK
        assert items[value] != "none"
        assert session.get_enumeration("trim.alpha")[0] == ERROR
        assert "There is no enumeration variable with value reference" in session.texts()[0]
        assert session.get([session.names["binding"]])[0] == ERROR

    def test_discrete_outputs_change_at_events(self, start):
        session = start("me")
        assert session.call("EnterContinuousTimeMode") == OK
        before = session.get_flags("feasible"), session.get_enumeration("binding")
        assert session.set_named(tas=90.0) == OK
        assert (session.get_flags("feasible"), session.get_enumeration("binding")) == before
        assert session.handle_event()
        after = session.get_flags("feasible"), session.get_enumeration("binding")
        assert after[0] != before[0]
        assert after[1] != before[1]

    def test_saved_state(self, start):
        session = start()
        outputs = [session.names[name] for name in (*TRIM, "turn_rate.least")]
        before = session.get(outputs)
        state = c_void_p()
        save, restore, free = session.state_functions
        assert session.call(save, byref(state)) == OK
        assert session.set_named(tas=60.0) == OK
        assert session.get(outputs) != before
        assert session.call(restore, state) == OK
        assert session.get(outputs) == before
        assert session.call(free, byref(state)) == OK

    def test_discard(self, start):
        session = start()
        before = session.get_named("turn_rate.least", "trim.alpha")
        assert session.set_named(limits__alpha__lower=0.5) == OK
        status, values = session.get([session.names[name] for name in ("turn_rate.least", "trim.alpha")])
        assert (status, values) == (DISCARD, before)
        assert session.get_enumeration("binding")[0] == DISCARD
