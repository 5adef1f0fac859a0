"""The explorer: from a slider's move to the picture, in headless Chromium, beside the same boundary in Python.

It leaves the picture that README shows in build/benchmarks/explorer.png.
"""

import statistics
import sys
import time
from pathlib import Path
from tempfile import TemporaryDirectory

sys.path.insert(0, str(Path(__file__).parents[1]))

from benchmarks.table import RESULTS, row, write
from gtm_fmu.aircraft.limits import ControlLimits
from gtm_fmu.envelopes.boundary import envelope_boundary
from gtm_fmu.envelopes.envelope import FlightCondition
from gtm_study.explorer.page import explorer_page
from gtm_study.paper.advice import shares_by_kind
from tests.browser import DESKTOP, chromium, new_tab

MOVES = 40
FAILURES = {"jam of the rudder": (15.0, 15.0), "range of the rudder": (-10.0, 20.0)}


def latencies_ms(tab, limits: tuple[float, float]) -> list[float]:
    """From each press of a key on the slider of the altitude to the picture."""
    values = {"rudder.lower": limits[0], "rudder.upper": limits[1], "tas_kt": 110.0, "turn_rate_deg_s": -3.0}
    tab.evaluate("values => controls.set(values)", values)
    settled = "document.body.dataset.answered === JSON.stringify(controls.condition)"
    tab.wait_for_function(settled)
    tab.locator("#altitude_ft").focus()
    found = []
    for _ in range(MOVES):
        tab.keyboard.press("ArrowRight")
        tab.wait_for_function(settled)
        found.append(float(tab.evaluate("document.body.dataset.latency")))
    return found


def in_python_ms(limits: tuple[float, float]) -> float:
    """The boundary of the same envelope by `envelope_boundary`, median over altitudes."""
    times = []
    for k in range(5):
        condition = FlightCondition(10000.0 + 250.0 * k, 0.0, ControlLimits(rudder_deg=limits))
        started = time.perf_counter()
        envelope_boundary(condition)
        times.append(1e3 * (time.perf_counter() - started))
    return statistics.median(times)


def main() -> None:
    """Measure, and take the picture."""
    rows = []
    with TemporaryDirectory() as folder, chromium(Path(folder, "profile")) as browser, new_tab(browser) as (tab, _):
        page = Path(folder, "explorer.html")
        page.write_text(explorer_page(shares_by_kind()), encoding="utf-8")
        tab.set_viewport_size(DESKTOP)
        tab.goto(page.as_uri())
        tab.wait_for_function("document.body.dataset.answered")
        for name, limits in FAILURES.items():
            found = sorted(latencies_ms(tab, limits))
            python_ms = in_python_ms(limits)
            median = statistics.median(found)
            peer = "the boundary alone, gtm_fmu.envelopes.boundary in Python"
            rows.append(row(f"slider to picture, {name}, median", median, "ms", peer, python_ms, python_ms / median))
            rows.append(row(f"slider to picture, {name}, 95 %", found[int(0.95 * MOVES)], "ms"))
        tab.evaluate("controls.set({'rudder.lower': 15, 'rudder.upper': 15, 'tas_kt': 110, 'turn_rate_deg_s': -3})")
        tab.wait_for_function("document.body.dataset.steps === JSON.stringify(controls.condition)")
        RESULTS.mkdir(parents=True, exist_ok=True)
        tab.set_viewport_size({"width": DESKTOP["width"], "height": 1250})
        tab.wait_for_timeout(500)
        tab.screenshot(path=RESULTS / "explorer.png")
    write("explorer", rows)


if __name__ == "__main__":
    main()
