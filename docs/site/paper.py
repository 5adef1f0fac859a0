"""The paper beside our results, as a page of the site: of a whole run of the study, which is kept in docs.

python docs/site/paper.py build/study

keeps the results and the pictures of a finished `gtm-fmu study` anew.
"""

import argparse
import json
import shutil
import sys
from collections import Counter
from pathlib import Path

from gtm_study.paper.counterpart import Counterpart, Results
from gtm_study.paper.registry import FIGURES, TABLES
from gtm_study.paper.report import study_report
from gtm_study.tables import markdown_table

DOCS = Path(__file__).parents[1]
RESULTS = DOCS / "results" / "study.json"
IMAGES = DOCS / "images"
INTRODUCTION = """\
R. Norouzi, A. Kosari, M. H. Sabour: *Investigating the Generalization Capability and Performance of Neural Networks and
Neuro-Fuzzy Systems for Nonlinear Dynamics Modeling of Impaired Aircraft*, IEEE Access 7 (2019).

Every figure and table of it, with what `gtm-fmu study` has in its place. *Same*, *better* or *different* is judged by
rules in the code, from the results. The command under each computes ours anew. All tables are in [the study's
results](results.md), all numbers in [study.json](../results/study.json). [Networks against local model
networks](../network-comparison.md), [better surrogates](../better-surrogates.md) and
[sensitivity](../sensitivity.md#the-aircraft) go further."""


def results() -> Results:
    """Values of the stages of the study that is kept, by stage."""
    found: Results = json.loads(RESULTS.read_text(encoding="utf-8"))
    return found


def page() -> str:
    """Figures and tables of the paper, each with ours."""
    found = results()
    there = [each for each in (*FIGURES, *TABLES) if each.stage]
    counts = Counter(each.finding(found).verdict for each in there)
    told = ", ".join(f"{counts[verdict]} {verdict}" for verdict in ("same", "better", "different"))
    parts = ["# The paper, figure by figure", INTRODUCTION, f"Of {len(there)} figures and tables: {told}."]
    for title, group in (("Figures", FIGURES), ("Tables", TABLES)):
        parts.append(f"## {title}")
        for each in group:
            parts += _counterpart(each, found) if each.stage else []
        drawings = [f"{each.number} ({each.shows[0].lower()}{each.shows[1:]})" for each in group if not each.stage]
        parts += [f"No results stand in {', '.join(drawings)}."] if drawings else []
    return "\n\n".join(parts) + "\n"


def _counterpart(each: Counterpart, found: Results) -> list[str]:
    finding = each.finding(found)
    parts = [
        f"### {each.number}",
        f"*{each.shows}*",
        f"The paper: {each.published}",
        f"Here: {finding.ours} **{finding.verdict.capitalize()}.** {finding.why}",
    ]
    if each.figure:
        parts.append(f"![{each.number}, ours: {each.shows}](../images/{each.figure}.png)")
    values = found.get(each.stage or "", {}).get(each.table or "")
    if values:
        parts.append(markdown_table(values["heads"], values["rows"]))
    return [*parts, f"`gtm-fmu study --only {each.stage}`"]


def all_results() -> str:
    """The tables of the study's results.md."""
    _, _, tables = study_report(dict(results())).partition("\n")
    return f"# The study's results\n\nThe tables that `gtm-fmu study` writes to `results.md`.\n{tables}"


def keep(study: Path) -> None:
    """Take results and pictures out of the folder of a finished study; other pictures of it that docs show, too."""
    if not (study / "results.json").is_file():
        sys.exit(f"There is no study in {study}: run `gtm-fmu study --output {study}` first.")
    RESULTS.parent.mkdir(exist_ok=True)
    shutil.copyfile(study / "results.json", RESULTS)
    wanted = {each.figure for each in (*FIGURES, *TABLES)} | {path.stem for path in IMAGES.glob("*.png")}
    for picture in sorted(study.glob("*.png")):
        if picture.stem in wanted:
            _smaller(picture, IMAGES / picture.name)


def _smaller(picture: Path, target: Path) -> None:
    """A picture with a palette of 256 colours: a third of the bytes."""
    from PIL import Image

    with Image.open(picture) as whole:
        whole.convert("RGB").quantize(256).save(target, optimize=True)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Keep the results and the pictures of a finished study.")
    parser.add_argument("study", type=Path, help="its folder")
    keep(parser.parse_args().study)
