"""The page of the study, written anew after each stage: findings, counterparts of the paper, what was run, files."""

import base64
import re
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup, escape

from gtm_fmu import __version__
from gtm_study.figures.pages import page_style
from gtm_study.files import write_text
from gtm_study.kept import Part
from gtm_study.paper.counterpart import Counterpart, Finding, Verdict
from gtm_study.paper.registry import COUNTERPARTS
from gtm_study.paper.report import study_sections
from gtm_study.paper.stages import LEVELS, STAGES, Run, Stage
from gtm_study.report.captions import caption
from gtm_study.report.circumstances import circumstances
from gtm_study.report.findings import findings
from gtm_study.tables import Table, shown

PAGE = "index.html"
OPENING = "envelope_jams"
"""The figure beside the findings."""
VERDICTS: dict[Verdict, str] = {
    "same": "=",
    "better": "\N{BLACK UP-POINTING TRIANGLE}",
    "different": "\N{NOT EQUAL TO}",
}
"""Verdicts with a sign beside the colour."""
LARGEST_INLINE = 50_000
"""Bytes of a download that the page carries inside; larger ones lie beside it."""
LARGEST_DRAWING = 300_000
"""Bytes of an SVG; a larger one is shown as its PNG."""
MOST_BESIDE = 4
"""Columns of a table that stands beside its words."""
DOWNLOADS = {
    "GtmDynamics.fmu": "6-DOF dynamics, FMI 2.0 co-simulation",
    "GtmSurrogate.fmu": "V_min and V_max of a failed rudder from the thrust map",
    "rudder_speeds.json": "the network of V_min and V_max",
    "rudder_throttle.json": "the network of the least throttle",
    "results.json": "all results as numbers",
    "results.md": "all results as Markdown",
}
PAGES = {
    "explorer.html": "Explorer: exact envelopes while sliders move",
    "volume.html": "The envelope over flight path, to turn about",
}
_MEDIA = {".svg": "image/svg+xml", ".png": "image/png", ".json": "application/json", ".md": "text/markdown"}


@dataclass(frozen=True)
class Picture:
    """A picture inside the page; sizes in pixels of the page."""

    address: str
    width: int
    height: int


@dataclass(frozen=True)
class Item:
    """A counterpart with what the study found."""

    counterpart: Counterpart
    finding: Finding
    is_finished: bool
    picture: Picture | None
    table: Table | None
    command: str

    @property
    def anchor(self) -> str:
        """Of its place in the page."""
        return self.counterpart.number.lower().replace(" ", "-")

    @property
    def is_beside(self) -> bool:
        """Whether a wide page has room for it at the side of its words."""
        return self.picture is not None or (self.table is not None and len(self.table.heads) <= MOST_BESIDE)

    @property
    def said(self) -> str:
        """The picture in words."""
        told = self.finding.ours or self.counterpart.published
        return f"{self.counterpart.number}: {self.counterpart.shows.rstrip('.')}. {told}"


@dataclass(frozen=True)
class Beyond:
    """Figures and tables of a stage that stand for nothing in the paper; each picture with its words."""

    stage: Stage
    command: str
    pictures: dict[str, Picture]
    tables: dict[str, Table]


@dataclass(frozen=True)
class File:
    """A file to download, inside the page where it is small."""

    name: str
    what: str
    address: str
    size: str


def write_page(run: Run, finished: Mapping[str, Part]) -> None:
    """Write the page of all that is finished into the study's folder; to be called after each stage."""
    write_text(report_page(run, finished), run.folder / PAGE)


def report_page(run: Run, finished: Mapping[str, Part]) -> str:
    """The page, which asks no network for anything."""
    results = {name: part.values for name, part in finished.items()}
    items = [_item(each, run, results) for each in COUNTERPARTS]
    environment = Environment(
        loader=PackageLoader("gtm_study.report", "web"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {"prose": _prose, "anchor": _anchor, "shown": shown}
    return environment.get_template("report.html").render(
        css=Markup(page_style() + _web("report.css")),
        script=Markup(_web("report.js")),
        version=__version__,
        findings=findings(results),
        counts=_counts(items),
        items=items,
        opening=next((item for item in items if item.counterpart.figure == OPENING and item.picture), None),
        verdicts=VERDICTS,
        circumstances=circumstances(run.seed),
        stages=_stages(run, finished),
        beyond=_beyond(run, finished),
        done=sum(each.name in finished for each in STAGES),
        total=len(STAGES),
        go_on=_go_on(run, finished),
        sections=study_sections(results),
        downloads=[_file(run.folder / name, what) for name, what in DOWNLOADS.items() if (run.folder / name).is_file()],
        pages={name: what for name, what in PAGES.items() if (run.folder / name).is_file()},
    )


def _item(each: Counterpart, run: Run, results: Mapping[str, Mapping[str, Any]]) -> Item:
    is_finished = each.stage in results
    found = results.get(each.stage or "", {}).get(each.table) if each.table else None
    table = Table(found["heads"], found["rows"], f"{each.number}, ours: {each.shows}") if found else None
    picture = _picture(run.folder / each.figure) if is_finished and each.figure else None
    command = _command(run, each.stage) if each.stage else ""
    return Item(each, each.finding(results), is_finished, picture, table, command)


def _counts(items: list[Item]) -> dict[str, int]:
    """How many counterparts there are by verdict, how many wait for their stage, and how many there are none of."""
    there = [item for item in items if item.counterpart.stage]
    counts = {str(name): sum(item.finding.verdict == name for item in there) for name in VERDICTS}
    return counts | {"there": len(there), "waiting": sum(not item.is_finished for item in there)}


def _go_on(run: Run, finished: Mapping[str, Part]) -> str:
    """The command that runs what is left: of the usual level first, then of all."""
    left = {each.level for each in STAGES if each.name not in finished}
    return f"gtm-fmu study{'' if left - {LEVELS[-1]} else f' --level {LEVELS[-1]}'}{_seed(run)}"


def _web(name: str) -> str:
    return (files("gtm_study.report") / "web" / name).read_text(encoding="utf-8")


def _beyond(run: Run, finished: Mapping[str, Part]) -> list[Beyond]:
    """What the finished stages leave that no counterpart shows."""
    of_the_paper = {each.figure for each in COUNTERPARTS} | {each.table for each in COUNTERPARTS}
    found = []
    for stage in (stage for stage in STAGES if stage.name in finished):
        part = finished[stage.name]
        stems = [
            Path(name).stem for name in part.files if name.endswith(".svg") and Path(name).stem not in of_the_paper
        ]
        drawn = {caption(stem): _picture(run.folder / stem) for stem in stems}
        pictures = {words: picture for words, picture in drawn.items() if picture}
        tables = {
            key: Table(value["heads"], value["rows"], caption(key))
            for key, value in part.values.items()
            if isinstance(value, dict) and value.keys() == {"heads", "rows"} and key not in of_the_paper
        }
        if pictures or tables:
            found.append(Beyond(stage, _command(run, stage.name), pictures, tables))
    return found


def _command(run: Run, stage: str) -> str:
    """The command that computes what a stage does."""
    return f"gtm-fmu study --only {stage}{_seed(run)}"


def _seed(run: Run) -> str:
    """The option of a seed that is not the usual one."""
    return f" --seed {run.seed}" if run.seed else ""


def _stages(run: Run, finished: Mapping[str, Part]) -> Table:
    rows = [(stage.title, stage.level, _time(stage, finished), f"`{_command(run, stage.name)}`") for stage in STAGES]
    return Table(("stage", "level", "time, s", "command"), rows, "Stages, what they took, and how to run one")


def _time(stage: Stage, finished: Mapping[str, Part]) -> str:
    return f"{finished[stage.name].seconds:.1f}" if stage.name in finished else "not yet run"


def _picture(stem: Path) -> Picture | None:
    """The drawing as SVG, or as PNG where that is large."""
    drawing, pixels = stem.with_suffix(".svg"), stem.with_suffix(".png")
    if not drawing.is_file():
        return None
    svg = drawing.read_bytes()
    size = re.search(rb'width="([\d.]+)pt" height="([\d.]+)pt"', svg)
    width, height = (round(float(points) * 96 / 72) for points in size.groups()) if size else (0, 0)
    shown = pixels if len(svg) > LARGEST_DRAWING and pixels.is_file() else drawing
    return Picture(_inline(shown), width, height)


def _file(path: Path, what: str) -> File:
    size = path.stat().st_size
    address = _inline(path) if size <= LARGEST_INLINE and path.suffix in _MEDIA else path.name
    return File(path.name, what, address, f"{size / 1e6:.1f} MB" if size >= 1e6 else f"{max(1, round(size / 1e3))} kB")


def _inline(path: Path) -> str:
    return f"data:{_MEDIA[path.suffix]};base64,{base64.b64encode(path.read_bytes()).decode()}"


def _prose(text: str) -> Markup:
    """Text with names in backticks as code, V_min and its like with an index, and numbers in one piece."""
    marked = re.sub(r"`([^`]+)`", r"<code>\1</code>", str(escape(text)))
    marked = re.sub(r"\b\d[\d.]*e-\d+\b", r'<span class="whole">\g<0></span>', marked)
    return Markup(re.sub(r"\b([VtS])(_|\^)(min|max|T)\b", lambda m: _indexed(*m.groups()), marked))


def _indexed(symbol: str, place: str, index: str) -> str:
    tag = "sub" if place == "_" else "sup"
    return f"<i>{symbol}</i><{tag}>{index}</{tag}>"


def _anchor(title: str) -> str:
    return re.sub(r"\W+", "-", title.lower()).strip("-")
