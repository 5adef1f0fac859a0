"""Envelope FMUs after any failure: every input that the solver takes, against `gtm_fmu.envelopes.envelope`."""

import math
from collections.abc import Iterator

import fmpy
import numpy as np
import pytest

from gtm_fmu.aircraft.client import FmuClient, FmuError
from gtm_fmu.aircraft.failures import Failure
from gtm_fmu.aircraft.limits import ControlLimits
from gtm_fmu.core.configuration import Configuration
from gtm_fmu.envelopes.envelope import envelope
from tests.fmu_src.native_session import DISCARD, ERROR, OK

pytestmark = pytest.mark.slow

FT, DEG, LB = 0.3048, math.pi / 180, 0.45359237
KN = 0.3048 / 0.592487  # SPEC 1
SHARED = {"altitude": 3000.0, "gamma": -2 * DEG}
Given = dict[str, float | bool]


def pair(name: str, lower: float, upper: float, unit: float = DEG) -> Given:
    return {f"limits.{name}.lower": lower * unit, f"limits.{name}.upper": upper * unit}


def settings(**fields) -> Failure:
    return Failure(configuration=Configuration(**fields))


RUDDER = ControlLimits(rudder_deg=(4, 9))
# what the FMU is given in SI, and the failure that it is; then bounds of alpha and phi in deg where they differ
CASES: dict[str, tuple] = {
    "elevator": (pair("elevator", -1, 2), Failure(ControlLimits(elevator_deg=(-1, 2)))),
    "aileron": (pair("aileron", 3, 3), Failure(ControlLimits(aileron_deg=(3, 3)))),
    "rudder": (pair("rudder", 4, 9), Failure(RUDDER)),
    "both rudders": ({**pair("rudder", 4, 20), "rudder.lower": -0.1, "rudder.upper": 9 * DEG}, Failure(RUDDER)),
    "throttle": (pair("throttle", 20, 60, 0.01), Failure(ControlLimits(throttle_pct=(20, 60)))),
    "damage": ({"damage.case": 5.0, **pair("rudder", 5, 5)}, None),
    "left engine": ({"engine.left.running": False}, settings(engine_running=(False, True))),
    "right engine": ({"engine.right.running": False}, settings(engine_running=(True, False))),
    "running engine": (
        {"engine.left.running": False, **pair("throttle.left", 0, 1, 0.01), **pair("throttle.right", 0, 80, 0.01)},
        Failure(configuration=Configuration(engine_running=(False, True)), throttle_right_pct=(0, 80)),
    ),
    "engines apart": (
        {"engine.separate": True, **pair("throttle.left", 0, 30, 0.01), **pair("rudder", 12, 12)},
        Failure(ControlLimits(rudder_deg=(12, 12)), throttle_left_pct=(0, 30)),
    ),
    "stabilizer": ({"stabilizer.setting": 2 * DEG}, settings(stabilizer_deg=2.0)),
    "flaps": ({"control.flaps": 20 * DEG}, settings(flap_deg=(20.0,) * 4)),
    "spoilers": ({"control.spoilers": 10 * DEG}, settings(spoiler_deg=(10.0,) * 4)),
    "gear": ({"control.gear": 1.0}, settings(gear=1.0)),
    "fuel": ({"fuel.used": 8 * LB}, settings(fuel_used_lb=8.0)),
    "most fuel": ({"fuel.used": 20 * LB}, settings(fuel_used_lb=20.0)),
    "alpha": (pair("alpha", -2, 6), Failure(), (-2, 6), (-30, 30)),
    "bank": (pair("bank", 5, 50), Failure(), (-5, 10.5), (5, 50)),
}
CASES["damage"] = (
    CASES["damage"][0],
    Failure(ControlLimits(rudder_deg=(5, 5)), Configuration(damage_case=5)),
)


def give(fmu: FmuClient, values: Given) -> None:
    for name, value in values.items():
        if isinstance(value, bool):
            fmu.set_boolean(name, value)
        else:
            fmu.set((name,), [value])


@pytest.fixture(scope="module")
def opened(envelope_fmus) -> Iterator[dict]:
    with FmuClient(envelope_fmus["python"]) as python, FmuClient(envelope_fmus[2]) as native:
        yield {"python": python, 2: native}


@pytest.mark.parametrize("case", CASES)
def test_every_input(opened, case):
    """The rudder is held to a narrow range where the case leaves it, which makes the search short."""
    values, failure, *bounds = CASES[case]
    is_free = failure.limits.rudder_deg == (-30, 30)
    given = {**SHARED, **({"rudder.lower": 0.0, "rudder.upper": 2 * DEG} if is_free else {}), **values}
    failure = failure.with_limits("rudder_deg", (0, 2)) if is_free else failure
    expected = envelope(3000 / FT, -2, failure, *bounds)
    healthy = envelope(3000 / FT, -2, ControlLimits(rudder_deg=failure.limits.rudder_deg))
    assert (expected.v_min_kt, expected.v_max_kt) != (healthy.v_min_kt, healthy.v_max_kt) or "rudder" in case
    for fmu in opened.values():
        fmu.reset()
        give(fmu, given)
        fmu.step(0.1)
        found = fmu.get(("v_min", "v_max")) / KN
        assert fmu.get_boolean("feasible") is expected.feasible
        wanted = [expected.v_min_kt, expected.v_max_kt] if expected.feasible else [0, 0]
        np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-9)


@pytest.fixture(scope="module")
def variables(envelope_fmus) -> dict:
    return {v.name: v for v in fmpy.read_model_description(envelope_fmus[2]).modelVariables}


class TestNames:
    """Those of GtmAircraft, so that limits, positions and settings connect one to one."""

    def test_old_references_stay(self, envelope_fmus, variables):
        old = ["altitude", "gamma", "rudder.lower", "rudder.upper", "tas", "v_min", "v_max", "v_min_std", "v_max_std"]
        old += ["feasible", "in_domain", "margin.slow", "margin.fast"]
        assert [variables[name].valueReference for name in (*old, "time")] == list(range(14))
        python = fmpy.read_model_description(envelope_fmus["python"]).modelVariables
        assert [variable.name for variable in python[:13]] == old

    def test_units_starts_and_ranges(self, aircraft_fmus, variables):
        theirs = {v.name: v for v in fmpy.read_model_description(aircraft_fmus["aircraft-native"]).modelVariables}
        shared = [name for name in variables if name in theirs and name != "time"]
        assert len(shared) == 8 + 1 + 2 + 1 + 3 + 1  # limits, damage, engines, stabiliser, flaps spoilers gear, fuel
        for name in shared:
            mine, its = variables[name], theirs[name]
            assert mine.causality == "input"
            for attribute in ("type", "unit", "displayUnit", "start", "min", "max"):
                given = getattr(its, attribute)
                assert given is None or getattr(mine, attribute) == given, (name, attribute)

    def test_what_the_aircraft_tells_is_taken(self, aircraft_fmus, opened):
        """All that is left of the controls after a failure, and the fuel, from outputs to inputs."""
        failed = {**pair("aileron", -12, 7), **pair("elevator", -3, 9), **pair("throttle", 0, 70, 0.01)}
        with FmuClient(aircraft_fmus["aircraft-native"]) as aircraft:
            give(aircraft, {**failed, **pair("rudder", 6, 6), "fuel.burn": True})
            for _ in range(20):
                aircraft.step(0.1)
            told = {
                f"limits.{control}.{end}": float(aircraft.get((f"authority.{control}.{end}",))[0])
                for control in ("elevator", "aileron", "rudder", "throttle")
                for end in ("lower", "upper")
            }
            told["fuel.used"] = float(aircraft.get(("fuel.used",))[0])
        left = ControlLimits(elevator_deg=(-3, 9), aileron_deg=(-12, 7), rudder_deg=(6, 6), throttle_pct=(0, 70))
        expected = envelope(3000 / FT, -2, Failure(left, Configuration(fuel_used_lb=told["fuel.used"] / LB)))
        opened[2].reset()
        give(opened[2], {**SHARED, **told})
        np.testing.assert_allclose(
            opened[2].get(("v_min", "v_max")) / KN, [expected.v_min_kt, expected.v_max_kt], rtol=0, atol=1e-9
        )


REFUSED: dict[str, tuple[Given, str]] = {
    "reversed": (pair("aileron", 3, -3), "limits.aileron.lower is above limits.aileron.upper"),
    "reversed alpha": (pair("alpha", 3, -3), "limits.alpha.lower is above limits.alpha.upper"),
    "reversed engine": (pair("throttle.right", 60, 50, 0.01), "limits.throttle.right.lower is above"),
    "no rudder": ({**pair("rudder", 5, 9), "rudder.upper": 0.0}, "No rudder is left"),
    "no throttle": ({**pair("throttle", 50, 90, 0.01), **pair("throttle.left", 0, 40, 0.01)}, "No throttle is left"),
    "no whole number": ({"damage.case": 1.5}, "damage.case is no whole number"),
    "no such damage": ({"damage.case": 7.0}, "damage.case was given as 7, allowed is 0 .. 6"),
    "too much fuel": ({"fuel.used": 10.0}, "fuel.used was given as 10, allowed is 0 .. 9.07"),
    "not a number": ({"control.flaps": math.nan}, "control.flaps was given as nan, allowed is "),
    "beyond": (pair("elevator", -40, 0), "limits.elevator.lower was given as "),
    "steep bank": (pair("bank", -30, 90), "limits.bank.upper was given as "),
}


class TestBadInput:
    @pytest.mark.parametrize("kind", ["python", 2])
    @pytest.mark.parametrize("case", REFUSED)
    def test_one_sentence(self, opened, kind, case):
        values, sentence = REFUSED[case]
        fmu = opened[kind]
        fmu.reset()
        fmu.messages.clear()
        give(fmu, {**SHARED, **pair("rudder", 0, 2)})
        before = fmu.get(("v_min", "v_max"))

        def refused():
            give(fmu, values)
            fmu.step(0.1)

        with pytest.raises(FmuError, match=sentence):
            refused()
        fmu.reset()
        give(fmu, {**SHARED, **pair("rudder", 0, 2)})
        np.testing.assert_array_equal(fmu.get(("v_min", "v_max")), before)

    def test_statuses(self, envelope_session):
        session = envelope_session("me")
        assert session.set_named(limits__rudder__lower=0.0, limits__rudder__upper=0.0) == OK
        before = session.get_named("v_min", "v_max")
        assert session.set_named(damage__case=2.5) == OK
        assert session.get([session.names["v_min"], session.names["v_max"]]) == (DISCARD, before)
        assert session.set_named(damage__case=-1.0) == DISCARD
        assert session.set_named(damage__case=0.0) == OK
        assert session.get_named("v_min", "v_max") == before

    def test_discrete_inputs_change_at_events(self, envelope_session):
        """FMI 2.0.5, 3.2.3, and FMI 3.0, 3.2.3: in Continuous-Time Mode only continuous inputs are set."""
        session = envelope_session("me")
        assert session.set_named(limits__rudder__lower=0.0, limits__rudder__upper=0.0) == OK
        assert session.set_flag("engine.left.running", False) == OK
        assert session.call("EnterContinuousTimeMode") == OK
        before = session.get_named("v_min", "v_max")
        session.messages.clear()
        assert session.set_flag("engine.left.running", True) == ERROR
        assert session.texts() == ["engine.left.running cannot be set in the present mode."]
        assert session.get_named("v_min", "v_max") == before
        assert session.call("EnterEventMode") == OK
        assert session.set_flag("engine.left.running", True) == OK
        assert session.get_named("v_min", "v_max") != before
