"""The explorer in a browser without a network: the page computes what Python does, as its sliders move."""

import json

import numpy as np
import pytest

from gtm_fmu.aircraft.failures import Failure
from gtm_fmu.aircraft.limits import ControlLimits
from gtm_fmu.airframe.names import PSI_DOT, V
from gtm_fmu.core import sections
from gtm_fmu.core.configuration import Configuration
from gtm_fmu.envelopes.envelope import FlightCondition, envelope
from gtm_fmu.envelopes.thrust_map import ThrustMap
from gtm_fmu.units import DEG_PER_RAD, FT_S_PER_KT
from gtm_study.explorer.page import explorer_page
from gtm_study.paper import rudder_grid, rudder_sensitivity
from gtm_study.paper.advice import shares_by_kind
from surrogate.rudder.emulator import RudderEmulator
from tests.browser import CHROMIUM, DESKTOP, NO_CHROMIUM, PHONE, assert_accessible, chromium, new_tab

pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
pytest.importorskip("ziglang", reason="Zig is not installed")
pytestmark = [pytest.mark.skipif(CHROMIUM is None, reason=NO_CHROMIUM), pytest.mark.slow]

EXACT_KT = 1e-9
RANDOM = np.random.default_rng(7)


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    path = tmp_path_factory.mktemp("explorer") / "explorer.html"
    path.write_text(explorer_page(shares_by_kind()), encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    with chromium(tmp_path_factory.mktemp("profile")) as context:
        yield context


@pytest.fixture(scope="module")
def opened(browser, page):
    with new_tab(browser) as (tab, complaints):
        tab.goto(page.as_uri())
        tab.wait_for_function("document.body.dataset.answered")
        yield tab, complaints


def answer(tab, values: dict) -> dict:
    """What the page computes for the healthy aircraft but for some values of its inputs."""
    tab.evaluate("values => controls.set(values)", values)
    tab.wait_for_function(
        "JSON.stringify(controls.condition) === document.body.dataset.answered && latest.condition !== null"
    )
    return tab.evaluate("latest")


def failures(count: int):
    """Values of the page's inputs, and the same condition as Python takes it."""
    for k in range(count):
        altitude_ft, gamma_deg = float(RANDOM.integers(0, 25000)), float(RANDOM.integers(-5, 4))
        low, high = sorted(RANDOM.uniform(-25.0, 25.0, 2).tolist())
        if k % 2:
            high = low
        values = {"altitude_ft": altitude_ft, "gamma_deg": gamma_deg, "rudder.lower": low, "rudder.upper": high}
        limits, configuration = {"rudder_deg": (low, high)}, {}
        if k % 4 == 0:
            values |= {"damage_case": str(1 + k % 6), "fuel_used_lb": 4.0, "flap_deg": 10.0}
            configuration = {"damage_case": 1 + k % 6, "fuel_used_lb": 4.0, "flap_deg": (10.0,) * 4}
        if k % 5 == 0:
            values |= {"engines": "left_out", "elevator.lower": -4.0}
            configuration["engine_running"] = (False, True)
            limits["elevator_deg"] = (-4.0, 30.0)
        yield values, (altitude_ft, gamma_deg, Failure(ControlLimits(**limits), Configuration(**configuration)))


def test_exact_envelopes_are_those_of_python(opened):
    tab, complaints = opened
    verdicts = []
    for values, condition in failures(24):
        found, exact = answer(tab, values)["exact"], envelope(*condition)
        verdicts.append(exact.feasible)
        assert found["feasible"] == exact.feasible, values
        if exact.feasible:
            assert found["v_min_kt"] == pytest.approx(exact.v_min_kt, abs=EXACT_KT)
            assert found["v_max_kt"] == pytest.approx(exact.v_max_kt, abs=EXACT_KT)
            assert tuple(found["held_at_v_min"]) == exact.at_v_min.limits_hit
            assert tuple(found["held_at_v_max"]) == exact.at_v_max.limits_hit
        elif exact.t_min_pct is not None:
            assert found["t_min_pct"] == pytest.approx(exact.t_min_pct, abs=1e-6)
    assert 4 < sum(verdicts) < 24
    assert complaints == []


def test_surrogates_answer_as_those_of_python(opened):
    tab, _ = opened
    for limits in ((15.0, 15.0), (-10.0, 20.0), (-25.0, -23.0)):
        values = {"altitude_ft": 12000.0, "rudder.lower": limits[0], "rudder.upper": limits[1]}
        found = answer(tab, values)
        for name, surrogate in (("map", ThrustMap.load()), ("network", RudderEmulator.load())):
            expected = surrogate.predict_one(12000.0, 0.0, limits)
            assert found[name]["feasible"] == expected["feasible"]
            for key in ("v_min_kt", "v_max_kt", "v_min_std_kt", "v_max_std_kt") if expected["feasible"] else ():
                assert found[name][key] == pytest.approx(expected[key], abs=1e-9)
    assert answer(tab, {"engines": "left_out"})["failed"] == "everything"


def test_sections_are_those_of_the_core(opened):
    """The turn rates that are left at every speed that is drawn, for a jam and for a range with an engine out."""
    tab, _ = opened
    for values, limits, configuration in (
        ({"rudder.lower": 15.0, "rudder.upper": 15.0}, {"rudder_deg": (15.0, 15.0)}, {}),
        (
            {"rudder.lower": -10.0, "engines": "left_out"},
            {"rudder_deg": (-10.0, 30.0)},
            {"engine_running": (False, True)},
        ),
    ):
        drawn = answer(tab, values)["section"]
        assert 20 < len(drawn) <= 25
        failure = Failure(ControlLimits(**limits), Configuration(**configuration))
        condition = FlightCondition(10000.0, 0.0, failure)
        for row in drawn[1:-1:4]:
            lower, upper = (bound.copy() for bound in condition.bounds)
            lower[V] = upper[V] = row["tas_kt"] * FT_S_PER_KT
            within = lower[PSI_DOT], upper[PSI_DOT]
            found = sections.section(sections.TURN_RATES, 10000.0, 0.0, lower, upper, within, failure.airframe)
            ends = [[each[side]["turn_rate_deg_s"] for side in ("low", "high")] for each in row["intervals"]]
            np.testing.assert_allclose(ends, found.ends * DEG_PER_RAD, rtol=0, atol=1e-7)


def test_steps_are_exact(opened):
    """What the next degree would cost, as envelopes solved in Python say."""
    tab, _ = opened
    answer(tab, {"rudder.lower": 5.0, "rudder.upper": 25.0, "gamma_deg": -5.0})
    tab.wait_for_function("document.body.dataset.steps === JSON.stringify(controls.condition)")
    lines = dict(tuple(line.split("\t", 1)) for line in tab.inner_text("#steps tbody").splitlines())
    here, there = (envelope(10000.0, -5.0, ControlLimits(rudder_deg=(low, 25.0))) for low in (5.0, 6.0))
    moves = [getattr(there, name) - getattr(here, name) for name in ("v_min_kt", "v_max_kt")]
    told = [float(text.replace("\u2212", "-")) for text in lines["rudder: 1 deg lost at the bottom"].split("\t")]
    assert told == pytest.approx(moves, abs=0.0051)


def test_shares_of_the_kind_of_failure(opened):
    """Total indices of the package's exact solutions: the flight path weighs most on V_max of a failed rudder."""
    tab, _ = opened
    answer(tab, {"rudder.lower": 5.0, "rudder.upper": 25.0})
    indices = rudder_sensitivity.given_an_envelope(rudder_grid.exact())
    row = dict(zip(("altitude", "flight path"), indices.total.value.tolist(), strict=False))
    for name, shares in row.items():
        assert f"{name} {shares[0]:.2f} and {shares[1]:.2f}" in tab.inner_text("#shares")
    answer(tab, {"engines": "left_out"})
    assert "controls, engines and structure fail at once: elevator 0.6" in tab.inner_text("#shares")


def test_sliders_by_keyboard(opened):
    tab, complaints = opened
    answer(tab, {})
    assert "Steady flight from" in tab.inner_text("#summary")
    tab.locator("[id='rudder.lower']").focus()
    tab.keyboard.press("End")  # the lower limit takes the upper one along
    tab.wait_for_function("JSON.parse(document.body.dataset.answered).limits.rudder[0] === 30")
    assert tab.evaluate("JSON.parse(document.body.dataset.answered).limits.rudder") == [30, 30]
    assert "No steady flight" in tab.inner_text("#summary") or "Steady flight" in tab.inner_text("#summary")
    assert "rudder.lower=30" in tab.evaluate("location.hash")
    assert complaints == []


def test_address_holds_what_was_set(browser, page):
    with new_tab(browser) as (tab, complaints):
        tab.goto(f"{page.as_uri()}#rudder.lower=15&rudder.upper=15&altitude_ft=10000&engines=nonsense&gamma_deg=1e9")
        tab.wait_for_function("document.body.dataset.answered")
        condition = json.loads(tab.evaluate("document.body.dataset.answered"))
        assert condition["limits"]["rudder"] == [15, 15]
        assert (condition["configuration"]["engines"], condition["gamma_deg"]) == ("both", 0)
        exact = envelope(10000.0, 0.0, ControlLimits(rudder_deg=(15.0, 15.0)))
        assert f"{exact.v_max_kt:.2f}" in tab.inner_text("#summary")
        assert complaints == []


@pytest.mark.parametrize("size", [PHONE, DESKTOP], ids=["phone", "desktop"])
def test_page_fits_the_window(opened, size):
    tab, _ = opened
    tab.set_viewport_size(size)
    answer(tab, {"rudder.lower": 10.0})
    assert tab.evaluate("document.documentElement.scrollWidth <= window.innerWidth")
    for scheme in ("light", "dark"):
        tab.emulate_media(color_scheme=scheme)
        assert_accessible(tab)


def test_number_that_is_not_allowed_changes_nothing(opened):
    tab, _ = opened
    answer(tab, {})
    altitude = tab.locator("#altitude_ft ~ input")
    altitude.fill("90000")
    assert "36089" in altitude.evaluate("each => each.validationMessage")
    assert tab.evaluate("controls.condition.altitude_ft") == 10000
