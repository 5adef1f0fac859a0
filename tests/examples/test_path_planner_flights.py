"""A path planned for a failure is flown inside what it leaves, one for the aircraft in order is not; and their page."""

import sys
from contextlib import nullcontext
from dataclasses import replace
from importlib.util import find_spec

import numpy as np
import pytest

from examples.path_planner import run
from examples.path_planner.flight.failure import bounds_of, failure_of
from examples.path_planner.flight.flight import FAILED_S
from examples.path_planner.flight.review import TRACK_FT, TRACK_M
from examples.path_planner.page.charts import Chart, ticks
from examples.path_planner.page.page import render
from examples.path_planner.planner import read_scenario
from gtm_fmu import InputError, envelope, turn_rate_interval
from tests.browser import CHROMIUM, DESKTOP, NO_CHROMIUM, PHONE, assert_accessible, chromium, new_tab

pytestmark = pytest.mark.slow

SCENARIO = """
title = "A short way to the <right>"
[failure]
limits.rudder.lower = 18
limits.rudder.upper = 18
[start]
altitude_ft = 6000
heading_deg = 0
[wind]
from_deg = 270
speed_kt = 8
[terrain]
ground_ft = 4000
[goal]
north_m = 2500
east_m = 2200
altitude_ft = [5900, 6500]
[cost]
of = "second failure"
engine_out = false
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """With the FMUs, once they are built."""
    path = tmp_path_factory.mktemp("path_planner")
    (path / "short.toml").write_text(SCENARIO)
    return path


@pytest.fixture(scope="module")
def outcome(folder):
    """One run that all tests share."""
    return run.run(read_scenario(folder / "short.toml"), folder, list(run.IMPORTERS), lambda name: nullcontext())


@pytest.fixture(scope="module")
def page(outcome, folder):
    path = folder / "short.html"
    path.write_text(render(outcome), encoding="utf-8")
    return path


def test_flown_as_planned(outcome):
    """To the end of the plan, on its track, with positive margins everywhere."""
    flown = outcome.flights["FMPy"]
    assert flown.is_as_planned, flown.summary
    assert flown.flight.columns["time_s"][-1] == pytest.approx(outcome.plan.measures.time_s, rel=0.03)
    assert flown.across_m < TRACK_M / 2
    assert flown.above_ft < TRACK_FT / 2
    for name, least in flown.least.items():
        assert least > 0, name
    assert flown.least["clearance_ft"] > outcome.scenario.clearance_ft


def test_the_failure_happens_in_flight(outcome):
    """The rudder stands at zero about before the failure, and at 18 deg from a second after it on."""
    columns = outcome.flown.flight.columns
    rudder, time = columns["rudder_deg"], columns["time_s"]
    assert np.abs(rudder[time < -FAILED_S]).max() < 1
    np.testing.assert_allclose(rudder[time > -FAILED_S + 1], 18, atol=1e-9)


def test_margins_are_those_of_the_exact_envelope(outcome):
    """Against `gtm_fmu.envelope` and `turn_rate_interval` at the flown samples themselves, every tenth second."""
    flown = outcome.flown
    columns = {
        name: np.interp(flown.time_s, flown.flight.columns["time_s"], v) for name, v in flown.flight.columns.items()
    }
    limits = failure_of(outcome.scenario.failure)
    for k in range(3, len(flown.time_s), 10):
        exact = envelope(columns["altitude_ft"][k], columns["gamma_deg"][k], limits)
        assert exact.v_min_kt < columns["tas_kt"][k] < exact.v_max_kt
        assert flown.v_min_kt[k] == pytest.approx(exact.v_min_kt, abs=1.0)
        assert flown.v_max_kt[k] == pytest.approx(exact.v_max_kt, abs=6.0)  # the flight path is rounded to 0.5 deg
        turns = turn_rate_interval(columns["altitude_ft"][k], columns["tas_kt"][k], columns["gamma_deg"][k], limits)
        assert flown.turns_deg_s[k] == pytest.approx(turns.intervals[0], abs=0.3)


def test_planned_for_the_aircraft_in_order(outcome):
    """It turns right at once, which the jam does not leave: the same autopilot leaves its track."""
    first = outcome.healthy.segments[0]
    _, right = turn_rate_interval(6000, first.tas_kt, first.gamma_deg, failure_of(outcome.scenario.failure)).intervals[
        0
    ]
    assert first.turn_rate_deg_s > right + 3
    flight = outcome.healthy_flight
    assert not flight.is_as_planned
    assert flight.left_track_s < 20
    assert flight.across_m > 3 * TRACK_M
    assert "off the track from" in flight.summary


def test_second_importer(outcome):
    """Ecos flies the same."""
    if "ecospy" not in outcome.flights:
        assert any("ecospy" in note for note in outcome.notes)
        pytest.skip("; ".join(outcome.notes))
    for name, values in outcome.flights["FMPy"].flight.columns.items():
        np.testing.assert_allclose(outcome.flights["ecospy"].flight.columns[name], values, rtol=1e-9, atol=1e-6)


def test_what_the_page_tells(outcome, page):
    text = page.read_text(encoding="utf-8")
    assert "A short way to the &lt;right&gt;" in text
    for plan in (outcome.plan, *outcome.plan.alternatives):
        assert f'<th scope="row">{plan.name}</th><td>{plan.measures.time_s:.0f}</td>' in text
    for name in ("Plan view", "Altitude", "Speed", "Turn rate", "Margin of the speed", "Alpha and bank"):
        assert f">{name}</h2>" in text
    assert "after rudder 5 deg further" in text
    assert outcome.healthy_flight.flight.end in text
    assert "nan" not in text
    assert len(text) < 400_000


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    if CHROMIUM is None or find_spec("playwright") is None:
        pytest.skip(NO_CHROMIUM)
    with chromium(tmp_path_factory.mktemp("profile")) as found:
        yield found


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_page_in_a_browser(browser, page, scheme):
    """At both widths nothing runs off the side, asks a network or complains; every picture has words."""
    with new_tab(browser) as (tab, complaints):
        tab.emulate_media(color_scheme=scheme)
        for size in (PHONE, DESKTOP):
            tab.set_viewport_size(size)
            tab.goto(page.as_uri())
            assert tab.evaluate("document.documentElement.scrollWidth") <= size["width"]
            assert tab.locator("svg[role=img]").count() == 6
            assert all(
                len(words) > 20
                for words in tab.locator("svg[role=img]").evaluate_all(
                    "all => all.map(each => each.getAttribute('aria-label'))"
                )
            )
            assert_accessible(tab)
        assert complaints == []


@pytest.mark.parametrize(
    ("before", "after", "code", "words"),
    [
        ('of = "second failure"', 'of = "beauty"', 2, "beauty"),
        ("limits.rudder.lower = 18", "limits.ruder.lower = 18", 2, "ruder"),
        ("altitude_ft = 6000", "altitude_ft = 4100", 3, "ground"),
        (
            "limits.rudder.lower = 18",
            "damage.case = 2\nlimits.elevator.lower = 20\nlimits.rudder.lower = 18",
            3,
            "left",
        ),
    ],
)
def test_requests_that_cannot_be_met(outcome, folder, monkeypatch, capsys, before, after, code, words):
    """One sentence and an exit code, and no page."""
    assert before in SCENARIO
    path = folder / "wrong.toml"
    path.write_text(SCENARIO.replace(before, after, 1))
    monkeypatch.setattr(sys, "argv", ["run.py", str(path), "--output", str(folder)])
    assert run.main() == code
    told = capsys.readouterr()
    assert words in told.err
    assert len(told.err.strip().splitlines()) == 1
    assert "Traceback" not in told.err
    assert not (folder / "wrong.html").exists()


def test_failures_by_name():
    found = failure_of({"limits.aileron.lower": -5, "engine.left.running": False, "damage.case": 4})
    assert found.limits.aileron_deg == (-5, 20)
    assert found.configuration.engine_running == (False, True)
    assert found.configuration.damage_case == 4
    assert bounds_of({"limits.bank.upper": 20}) == ((-5.0, 10.5), (-30.0, 20.0))  # SPEC 9
    with pytest.raises(InputError, match=r"no failure 'control\.flaps'"):
        failure_of({"control.flaps": 10.0})


def test_charts():
    """Round ticks; a gap in a line is a gap; no number is written that a browser does not read."""
    assert ticks(0, 10).tolist() == [0, 2, 4, 6, 8, 10]
    assert ticks(-0.13, 0.31).tolist() == pytest.approx([-0.1, 0, 0.1, 0.2, 0.3])
    chart = Chart((0.0, 4.0), (0.0, 1.0), ("x", "y & z"))
    chart.line(np.arange(5.0), np.array([0.1, 0.2, np.nan, 0.4, 0.5]), "plan")
    svg = chart.svg("one", 'words of "it"')
    assert svg.count("<polyline") == 2
    assert "y &amp; z" in svg
    assert "&quot;it&quot;" in svg
    assert "nan" not in svg


def test_fixed_thrust_is_planned_and_not_flown(outcome, folder, monkeypatch):
    """The page says why, and has no flights."""
    monkeypatch.setattr(run, "planned", lambda *_, **__: outcome.plan)
    stuck = replace(outcome.scenario, failure={"limits.throttle.lower": 40.0, "limits.throttle.upper": 40.0})
    found = run.run(stuck, folder, ["FMPy"], lambda name: nullcontext())
    assert found.flown is None
    text = render(found)
    assert "Not flown: the autopilot holds speed and flight path by the throttle" in text
    assert ">Flights</h2>" not in text
