"""The documentation as a site: it builds without a warning, needs no network, and tells what the code has."""

import html
import os
import re
import subprocess
import sys
from importlib import import_module
from pathlib import Path
from types import FunctionType

import pytest
import typer

from fmu_src import MODELS, NATIVE_MODELS
from gtm_study.commands import cli
from gtm_study.paper.registry import COUNTERPARTS
from tests.browser import CHROMIUM, DESKTOP, NO_CHROMIUM, PHONE, chromium, new_tab

pytest.importorskip("mkdocs", reason="the extra `docs` is not installed")
pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[1]
PACKAGES = ("gtm_fmu", "surrogate", "sensitivity", "fmu_src")


@pytest.fixture(scope="module")
def site(tmp_path_factory) -> Path:
    """The site as `make docs` builds it: a warning, as of a link that leads nowhere, ends it."""
    folder = tmp_path_factory.mktemp("site")
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet", "--site-dir", str(folder)]
    settings = os.environ | {"NO_MKDOCS_2_WARNING": "1"}
    done = subprocess.run(command, capture_output=True, text=True, cwd=ROOT, env=settings, timeout=120)
    assert done.returncode == 0, done.stdout + done.stderr
    return folder


def text(site: Path, page: str) -> str:
    return html.unescape((site / page).read_text(encoding="utf-8"))


def test_nothing_is_loaded_from_a_network(site):
    pages = list(site.rglob("*.html"))
    assert len(pages) > 20
    for page in pages:
        loaded = re.findall(r"<(?:script|img|iframe|source)[^>]*\ssrc=\"?([^\s\">]+)", page.read_text(encoding="utf-8"))
        loaded += re.findall(r"<link[^>]*\shref=\"?([^\s\">]+)", page.read_text(encoding="utf-8"))
        assert loaded
        assert not [url for url in loaded if url.startswith(("http:", "https:", "//"))], page
    for sheet in site.rglob("*.css"):
        assert not re.search(r"url\([\"']?(https?:)?//", sheet.read_text(encoding="utf-8")), sheet


def test_every_command_and_option_is_told(site):
    page = text(site, "reference/command-line.html")

    def check(command, name: str) -> None:
        assert f">{name}<" in page, name
        for parameter in command.params:
            told = parameter.opts if parameter.opts[0].startswith("-") else [parameter.metavar or parameter.name]
            assert all(f"<code>{each}" in page for each in told), f"{name} {told}"
        for child, each in getattr(command, "commands", {}).items():
            check(each, f"{name} {child}")

    commands = typer.main.get_command(cli.app).commands
    assert len(commands) >= 19
    for name, command in commands.items():
        check(command, f"gtm-fmu {name}")


def test_every_variable_of_every_fmu_is_told(site):
    page = text(site, "reference/fmu-variables.html")
    named, cells = set(re.findall("<code>(.*?)</code>", page)), set(re.findall("<td>(.*?)</td>", page))
    for contents in (*MODELS.values(), *NATIVE_MODELS.values()):
        model = contents([]).model
        assert model.name in named
        for variable in model.variables:
            assert variable.name in named
            assert any(cell.startswith(variable.description) for cell in cells), variable.name


@pytest.mark.parametrize("package", PACKAGES)
def test_every_public_name_has_an_entry(site, package):
    anchors = set(re.findall(r'id="([\w.]+)"', text(site, f"reference/{package}.html")))
    module = import_module(package)
    names = {name: getattr(module, name) for name in module.__all__ if not name.startswith("__")}
    for name, value in names.items():
        home = value.__module__ if isinstance(value, type | FunctionType) else package
        assert f"{home}.{name}" in anchors


def test_notebooks(site):
    """Each is a page with its figure, and a notebook to download."""
    nbformat = pytest.importorskip("nbformat")
    paths = sorted((ROOT / "examples/notebooks").glob("*.py"))
    assert len(paths) >= 5
    for path in paths:
        assert f"images/notebooks/{path.stem}.png" in text(site, f"tutorials/{path.stem}.html")
        notebook = nbformat.read(site / f"tutorials/{path.stem}.ipynb", as_version=4)
        nbformat.validate(notebook)
        assert {cell.cell_type for cell in notebook.cells} == {"code", "markdown"}


def test_the_paper_beside_ours(site):
    """Each figure and table of the paper that has results stands beside ours; the study that is kept is a whole one."""
    page = text(site, "reference/paper.html")
    for each in COUNTERPARTS:
        if each.stage:
            assert f'id="{each.number.lower().replace(" ", "-")}"' in page
            assert f"gtm-fmu study --only {each.stage}" in page
        if each.figure:
            assert (site / "images" / f"{each.figure}.png").exists()
    assert "Not computed yet" not in page
    assert "9.43e-05" in page  # the least error of the paper's networks, its Table 6
    assert "1102" in text(site, "reference/results.html")  # its feasible cases, section III-C
    assert (site / "results" / "study.json").exists()


def test_equations_need_no_script(site):
    pages = {page.stem: page.read_text(encoding="utf-8") for page in site.rglob("*.html")}
    assert not any("arithmatex" in page for page in pages.values())
    assert "<mi>cos</mi><mspace" in pages["trim-manifold"]  # cos theta is no product
    assert '<mo form="prefix">&#x02212;' in pages["trim-manifold"]


def test_every_page_is_one_to_be_opened_as_a_file(site):
    assert not (site / "404.html").exists()


@pytest.mark.skipif(CHROMIUM is None, reason=NO_CHROMIUM)
def test_search_and_pages_from_a_file(site, tmp_path):
    """A reader opens the page as a file, without a network, and searches; pages are no wider than a phone."""
    with chromium(tmp_path) as browser, new_tab(browser) as (tab, complaints):
        for page in ("index", "airframe", "better-surrogates", "reference/fmu-variables", "reference/gtm_fmu"):
            tab.goto((site / f"{page}.html").as_uri())
            assert tab.evaluate("document.documentElement.scrollWidth") <= PHONE["width"], page
        tab.set_viewport_size(DESKTOP)
        tab.goto((site / "index.html").as_uri())
        tab.fill("input.md-search__input", "thrust map")
        tab.wait_for_selector(".md-search-result__item")
        assert "Better surrogates" in tab.inner_text(".md-search-result__list")
        tab.goto((site / "mathematics" / "airframe.html").as_uri())
        loaded = tab.evaluate("document.fonts.load('1em Equations', 'V').then(faces => faces.map(face => face.status))")
        assert loaded == ["loaded"]
        assert not complaints
