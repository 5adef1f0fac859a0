"""Headless Chromium for tests of pages, without a network."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from gtm_study.report.browser import find_browser

CHROMIUM = find_browser()
FLAGS = (
    "--no-sandbox",
    "--disable-gpu",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--enable-unsafe-swiftshader",  # WebGL without a graphics card
)
PHONE, DESKTOP = {"width": 400, "height": 780}, {"width": 1280, "height": 800}
NO_CHROMIUM = "there is no chromium to open pages with"
_LOCAL = ("file:", "data:", "blob:")


@contextmanager
def chromium(profile: Path) -> Iterator:
    """A browser with a profile of its own."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        context = playwright.chromium.launch_persistent_context(
            profile, executable_path=CHROMIUM, args=list(FLAGS), offline=True
        )
        yield context
        context.close()


@contextmanager
def new_tab(browser) -> Iterator[tuple]:
    """A tab at the width of a phone, and what it complained of or asked a network for."""
    tab, complaints = browser.new_page(), []
    tab.set_viewport_size(PHONE)
    tab.on("console", lambda message: complaints.append(message.text) if message.type == "error" else None)
    tab.on("pageerror", lambda error: complaints.append(str(error)))
    tab.on("request", lambda asked: None if asked.url.startswith(_LOCAL) else complaints.append(asked.url))
    yield tab, complaints
    tab.close()


def assert_accessible(tab) -> None:
    """Fail with what axe finds wrong with a page: names, contrast, order of headings and the like."""
    from axe_playwright_python.sync_playwright import Axe

    found = Axe().run(tab)
    assert found.violations_count == 0, found.generate_report()
