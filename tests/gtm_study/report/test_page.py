"""The page of the study: complete, self-contained, readable by everybody; as PDF; and what stands in its way."""

import csv
import hashlib
import io
import json
import re
from pathlib import Path

import pytest
from rich.console import Console

from gtm_fmu.airframe.tables import DATA_FILE
from gtm_fmu.errors import InputError
from gtm_study.kept import Part
from gtm_study.paper import pipeline
from gtm_study.paper.counterpart import Counterpart, Finding
from gtm_study.paper.registry import COUNTERPARTS
from gtm_study.paper.stages import STAGES, Sizes
from gtm_study.report.browser import write_pdf
from gtm_study.report.findings import findings
from gtm_study.report.page import PAGE, write_page
from tests.browser import CHROMIUM, DESKTOP, NO_CHROMIUM, PHONE, assert_accessible, chromium, new_tab
from tests.gtm_study.paper.test_report import RESULTS

pytestmark = pytest.mark.slow
in_browser = pytest.mark.skipif(CHROMIUM is None, reason=NO_CHROMIUM)

DONE = ("jams", "limits", "surrogate-fmu")
SMALL = Sizes(jams_deg=(0.0, 30.0), limit_step_deg=20.0)


@pytest.fixture(scope="module")
def pages() -> list[str]:
    """The page as it is at the start and after each stage."""
    return []


@pytest.fixture(scope="module")
def folder(tmp_path_factory, pages) -> Path:
    """A study of which three stages are finished."""
    folder = tmp_path_factory.mktemp("study") / "new"

    def tell(run, finished) -> None:
        write_page(run, finished)
        pages.append((folder / PAGE).read_text(encoding="utf-8"))

    pipeline.run(folder, 1, only=DONE, sizes=SMALL, console=Console(file=io.StringIO()), after_stage=tell)
    return folder


@pytest.fixture(scope="module")
def page(folder) -> str:
    return (folder / PAGE).read_text(encoding="utf-8")


def articles(page: str) -> dict[str, str]:
    """What the page says of each figure and table, by its number."""
    found = re.findall(r"<article aria.*?</article>", page, re.DOTALL)
    return {re.search(r'class="number">([^<]+)<', text).group(1): text for text in found}


class TestContents:
    def test_it_grows(self, folder, pages):
        told = [re.search(r"(\d+) of (\d+) stages are finished", page).groups() for page in pages]
        assert told == [(str(k), str(len(STAGES))) for k in range(len(DONE) + 1)]
        assert pages[-1] == (folder / PAGE).read_text(encoding="utf-8")

    def test_every_figure_and_table_of_the_paper(self, page):
        """Those with a counterpart have a place of their own, the others their reason."""
        there = [each for each in COUNTERPARTS if each.stage]
        assert list(articles(page)) == [each.number for each in there]
        left_out = page.split('id="left-out"')[1].split("</section>")[0]
        assert re.findall(r"<li>((?:Figure|Table) \d+),", left_out) == [
            each.number for each in COUNTERPARTS if not each.stage
        ]

    def test_pictures_of_what_is_finished(self, folder, page):
        for each in COUNTERPARTS:
            if each.stage and each.figure:
                alts = re.findall(r'<img src="data:image/[^"]+" alt="([^"]+)"', articles(page)[each.number])
                drawn = each.stage in DONE and (folder / f"{each.figure}.svg").is_file()
                assert len(alts) == drawn, each.number
                assert all(alt.startswith(f"{each.number}: ") and len(alt) > 30 for alt in alts)
        assert sum(f'alt="{each.number}:' in page for each in COUNTERPARTS) >= 2

    def test_what_is_not_finished_says_so(self, page):
        for each in COUNTERPARTS:
            if each.stage and each.stage not in DONE:
                assert "not yet run" in articles(page)[each.number]
                assert f"<code>gtm-fmu study --only {each.stage} --seed 1</code>" in articles(page)[each.number]

    def test_asks_no_network(self, folder, page):
        """Addresses are inside the page, or files beside it."""
        found = re.findall(r'(?:href|src|action)="([^"]*)"', page) + re.findall(r"url\(([^)]*)\)", page)
        anchors = set(re.findall(r'id="([^"]+)"', page))
        assert len(found) > 50
        for address in found:
            if address.startswith("#"):
                assert address[1:] in anchors
            elif not address.startswith("data:"):
                assert (folder / address).is_file(), address
        assert not re.search(r"@import|<link|<iframe|fetch\(|XMLHttp", page)

    def test_what_was_run(self, folder, page):
        digest = re.search(r"<td>([0-9a-f]{64})</td>", page).group(1)
        provenance = json.loads((folder / "parts" / "jams.json").read_text())
        assert digest == hashlib.sha256(DATA_FILE.read_bytes()).hexdigest()
        assert f"<td>{provenance['seconds']:.1f}</td>" in page
        assert re.search(r">seed</th><td>1</td>", page)

    def test_downloads(self, folder, page):
        assert '<a href="GtmSurrogate.fmu" download="GtmSurrogate.fmu">' in page
        assert '<a href="data:application/json;base64,' in page
        assert "GtmDynamics.fmu</a>" not in page  # its stage has not run

    def test_markup_of_results_stays_text(self, tmp_path, monkeypatch):
        finding = Finding("1 < 2 & `x_min`", "better", "V_min <b>")
        each = Counterpart("Table 99", "<i>", "&", "jams", lambda results: finding, table="numbers")
        monkeypatch.setattr("gtm_study.report.page.COUNTERPARTS", (each,))
        table = {"heads": ["<script>", "b", "c"], "rows": [["1", "V_max", 0.123456789]]}
        write_page(pipeline.Run(tmp_path, 0, Sizes()), {"jams": Part({"numbers": table}, (), 1.0)})
        text = articles((tmp_path / PAGE).read_text())["Table 99"]
        for told in (
            "1 &lt; 2 &amp; <code>x_min</code>",
            "<i>V</i><sub>min</sub> &lt;b&gt;",
            "&lt;script&gt;",
            "<i>V</i><sub>max</sub>",
            'class="verdict better"',
            '<td data-whole="0.123456789">0.1235</td>',  # shown short, whole in a download
        ):
            assert told in text


def test_findings_are_those_of_the_results():
    """The numbers of the results beside those that the paper prints (Tables 14 and 15, section III-C)."""
    told = " ".join(sentence for each in findings(RESULTS) for sentence in each.sentences)
    for number in ("210", "211", "3.2e-09", "1043", "1102", "0.000125", "9.43e-05", "0.11 kn", "3.3 kn", "98.76%"):
        assert number in told, number
    for number in ("5.7%", "0.17 there", "0.46 there"):
        assert number in told, number
    assert findings({}) == []


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    with chromium(tmp_path_factory.mktemp("profile")) as context:
        yield context


@in_browser
class TestInBrowser:
    @pytest.fixture
    def opened(self, browser, folder):
        with new_tab(browser) as (tab, complaints):
            tab.goto((folder / PAGE).as_uri())
            yield tab
            assert complaints == []

    @pytest.mark.parametrize("scheme", ["light", "dark"])
    def test_everybody_can_read_it(self, opened, scheme):
        """At both widths nothing sticks out and axe has nothing to say; figures lie on white in a dark page too."""
        opened.emulate_media(color_scheme=scheme)
        for size in (PHONE, DESKTOP):
            opened.set_viewport_size(size)
            assert opened.evaluate("document.documentElement.scrollWidth <= window.innerWidth")
            if scheme == "light" or size == PHONE:
                assert_accessible(opened)
        loaded = opened.evaluate("[...document.images].map(image => image.complete && image.naturalWidth > 100)")
        assert len(loaded) >= 3
        assert all(loaded)
        ground, panel = (
            opened.evaluate(f"getComputedStyle(document.querySelector('{name}')).backgroundColor")
            for name in ("body", "img")
        )
        assert panel == "rgb(255, 255, 255)"
        assert (ground == panel) == (scheme == "light")

    def test_tables_sort_by_keyboard(self, opened):
        head = opened.locator("#table-stages thead th", has_text="time")
        column = "#table-stages tbody td:nth-child(3)"
        for order in ("ascending", "descending"):
            head.locator("button").focus()
            opened.keyboard.press("Enter")
            assert head.get_attribute("aria-sort") == order
            told = opened.locator(column).all_inner_texts()
            times = [float(text) for text in told if text[0].isdigit()]
            assert times == sorted(times, reverse=order == "descending")
            assert len(times) == len(DONE)
        opened.locator("#table-stages thead button").first.press("Space")
        assert head.get_attribute("aria-sort") is None
        names = opened.locator("#table-stages tbody th").all_inner_texts()
        assert names == sorted(names, key=str.lower)

    def test_tables_download(self, opened, tmp_path):
        with opened.expect_download() as download:
            opened.get_by_role("button", name="Download as CSV: All counterparts").press("Enter")
        assert download.value.suggested_filename == "counterparts.csv"
        download.value.save_as(tmp_path / "table.csv")
        heads, *rows = list(csv.reader((tmp_path / "table.csv").open(newline="", encoding="utf-8")))
        assert heads == ["item", "verdict", "published", "here"]
        assert [row[0] for row in rows] == [each.number for each in COUNTERPARTS if each.stage]

    def test_contents_lead_there(self, opened):
        for link in opened.locator("nav a").all():
            assert opened.locator(f"[id='{link.get_attribute('href')[1:]}']").count() == 1
        opened.keyboard.press("Tab")
        assert opened.evaluate("document.activeElement.textContent") == "To the content"

    def test_pdf(self, folder, tmp_path):
        write_pdf(folder / PAGE, tmp_path / "study.pdf")
        content = (tmp_path / "study.pdf").read_bytes()
        assert content.startswith(b"%PDF")
        assert len(re.findall(rb"/Type\s*/Page\b", content)) >= 5
        assert [path.name for path in tmp_path.iterdir()] == ["study.pdf"]


class TestWithoutPdf:
    def test_no_browser(self, ask, tmp_path, monkeypatch):
        monkeypatch.setenv("PATH", str(tmp_path))
        told = ask("study", "--pdf", "--output", tmp_path / "study")
        assert told.code == 2
        assert re.fullmatch(
            r"gtm-fmu: The PDF is printed by Chromium, and none of .* is here; install one .*\n", told.err
        )
        assert not (tmp_path / "study").exists()

    @pytest.mark.parametrize(
        ("script", "reason"),
        [("echo no display >&2; exit 3", r"did not print the page \(no display\)"), ("exit 0", "made no study.pdf of")],
    )
    def test_browser_that_fails(self, tmp_path, monkeypatch, script, reason):
        """One sentence, and an older PDF stays."""
        browser, page, pdf = (tmp_path / name for name in ("bin/chromium", "index.html", "study.pdf"))
        browser.parent.mkdir()
        browser.write_text(f"#!/bin/sh\n{script}\n")
        browser.chmod(0o755)
        monkeypatch.setenv("PATH", str(browser.parent))
        page.write_text("<p>page")
        pdf.write_text("old")
        with pytest.raises(InputError, match=reason):
            write_pdf(page, pdf)
        assert pdf.read_text() == "old"
        assert sorted(path.name for path in tmp_path.iterdir()) == ["bin", "index.html", "study.pdf"]
