"""Interactive pages in a browser without a network: they load, draw, turn and tell what is under the pointer."""

from pathlib import Path

import pytest

from gtm_fmu.aircraft.limits import ControlLimits
from gtm_fmu.envelopes.envelope import FlightCondition
from gtm_fmu.envelopes.family import envelope_family
from gtm_study.figures.envelopes import save_envelope
from gtm_study.figures.families import family_page
from gtm_study.files import write_text
from tests.browser import CHROMIUM, DESKTOP, NO_CHROMIUM, PHONE, chromium, new_tab

pytest.importorskip("playwright.sync_api", reason="playwright is not installed")

pytestmark = [pytest.mark.skipif(CHROMIUM is None, reason=NO_CHROMIUM), pytest.mark.slow]


@pytest.fixture(scope="module")
def pages(tmp_path_factory) -> dict[str, Path]:
    folder = tmp_path_factory.mktemp("pages")
    files = {name: folder / f"{name}.html" for name in ("envelope", "volume")}
    condition = FlightCondition(10000.0, -5.0, ControlLimits(rudder_deg=(12.0, 12.0)))
    save_envelope(condition, files["envelope"])
    write_text(family_page(envelope_family(condition, "gamma", (-4.0, 4.0), 4.0, 2.0)), files["volume"])
    return files


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    with chromium(tmp_path_factory.mktemp("profile")) as context:
        yield context


@pytest.fixture
def opened(browser, pages):
    """A page at the width of a phone, and what it complained of or asked for."""
    with new_tab(browser) as (tab, complaints):

        def open_page(name: str):
            tab.goto(pages[name].as_uri())
            tab.wait_for_selector(".js-plotly-plot .main-svg")
            return tab, complaints

        yield open_page


def assert_fills_the_window(tab, size) -> None:
    tab.set_viewport_size(size)
    tab.wait_for_function(f"document.querySelector('.js-plotly-plot')._fullLayout.width == {size['width']}")
    box = tab.locator(".js-plotly-plot").bounding_box()
    assert box["height"] > 0.9 * size["height"]
    assert tab.evaluate("document.documentElement.scrollWidth <= window.innerWidth")
    for text in tab.locator(".gtitle, .legend").all():
        place = text.bounding_box()
        assert -1 <= place["x"] <= place["x"] + place["width"] <= size["width"] + 1
    room = tab.evaluate("document.querySelector('.js-plotly-plot')._fullLayout._size")
    assert room["w"] > 0.7 * size["width"]
    assert room["h"] > 0.5 * size["height"]


def test_page_of_an_envelope(opened):
    tab, complaints = opened("envelope")
    assert tab.evaluate("document.querySelector('.js-plotly-plot').data.length") > 5
    assert_fills_the_window(tab, PHONE)
    assert_fills_the_window(tab, DESKTOP)
    plot = tab.locator(".js-plotly-plot .nsewdrag").bounding_box()
    tab.mouse.move(plot["x"] + 0.5 * plot["width"], plot["y"] + 0.5 * plot["height"])
    told = tab.locator(".hoverlayer .hovertext").first
    told.wait_for()
    for part in ("kn", "deg/s", "angle of attack", "throttle"):
        assert part in told.text_content()
    assert complaints == []


def test_page_of_a_volume(opened):
    tab, complaints = opened("volume")
    assert tab.evaluate("document.querySelector('.js-plotly-plot').data.length") > 4
    assert_fills_the_window(tab, PHONE)
    camera = "document.querySelector('.js-plotly-plot')._fullLayout.scene.camera.eye.x"
    before = tab.evaluate(camera)
    tab.mouse.move(195, 300)
    tab.mouse.down()
    tab.mouse.move(300, 310, steps=3)
    tab.mouse.up()
    tab.wait_for_function(f"Math.abs({camera} - {before}) > 0.05")
    assert_fills_the_window(tab, DESKTOP)
    assert complaints == []
