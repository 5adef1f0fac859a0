"""The study from end to end, stage by stage: what is finished is kept, and told at once in results and report."""

import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from rich.console import Console

from gtm_fmu.errors import InputError
from gtm_fmu.extras import check_installed
from gtm_study.files import write_text
from gtm_study.kept import Kept, Part, check_run_folder, run_folder
from gtm_study.paper.registry import comparison
from gtm_study.paper.report import study_report
from gtm_study.paper.stages import LEVELS, STAGES, USUAL_LEVEL, Run, Sizes, Stage
from gtm_study.progress import stages
from gtm_study.style import figure_style
from gtm_study.tables import markdown

Finished = dict[str, Part]
"""The stages that are finished by name, in the order of `STAGES`: their values, files and seconds."""


def run(
    output: Path,
    seed: int = 0,
    level: str = USUAL_LEVEL,
    only: Sequence[str] = (),
    sizes: Sizes | None = None,
    console: Console | None = None,
    after_stage: Callable[[Run, Finished], None] | None = None,
) -> dict[str, Any]:
    """Run the stages of the study into a folder and return the values of all that are finished, by stage.

    A stage that is finished is not run again unless something has changed that it follows from; so a stopped run goes
    on where it was. Every file is written in one piece or not at all. The same seed gives the same results.

    Args:
        level: how far: the stages of this one and of those before it in `LEVELS`.
        only: names of stages, with those that they need; empty: all of the level.
        sizes: how large the stages are.
        after_stage: called at the start and after each stage with the run and all that is finished.

    Raises:
        InputError: the folder cannot be written or is not of a study, there is no such level or stage, or torch is
            missing.
    """
    wanted = chosen(level, only)
    check_run_folder(output)
    check_installed("torch", "The study trains networks with")
    this = Run(run_folder(output), seed, sizes or Sizes())
    kept = Kept(this.folder, seed=seed, sizes=this.sizes)

    def finished() -> Finished:
        found = {each.name: kept.find(each.name) for each in STAGES}
        return {name: part for name, part in found.items() if part is not None}

    def tell() -> None:
        told = finished()
        _write(results(told), this.folder)
        if after_stage:
            after_stage(this, told)

    tell()
    missing = [each for each in wanted if kept.find(each.name) is None]
    with figure_style(), stages(console or Console(stderr=True), sum(each.seconds for each in missing)) as stage:
        for each in missing:
            with stage(each.title, each.seconds) as advance:
                written: list[Path] = []
                kept.part(each.name, lambda: each.run(this, advance, written), lambda: written)  # noqa: B023
            tell()
    return results(finished())


def results(finished: Finished) -> dict[str, Any]:
    """Values of the finished stages, by stage."""
    return {name: part.values for name, part in finished.items()}


def chosen(level: str, only: Sequence[str]) -> list[Stage]:
    """The stages that are asked for, with all that they need, in order.

    Raises:
        InputError: there is no such level or stage.
    """
    if level not in LEVELS:
        raise InputError(f"There is no level '{level}': give {', '.join(LEVELS)}.")
    by_name = {each.name: each for each in STAGES}
    if unknown := [name for name in only if name not in by_name]:
        raise InputError(f"There is no stage '{unknown[0]}': give some of {', '.join(by_name)}.")
    reached = LEVELS[: LEVELS.index(level) + 1]
    names = set(only) or {each.name for each in STAGES if each.level in reached}
    for each in reversed(STAGES):
        if each.name in names:
            names |= set(each.needs)
    return [each for each in STAGES if each.name in names]


def _write(values: dict[str, Any], output: Path) -> None:
    write_text(json.dumps(values, indent=1, allow_nan=False), output / "results.json")
    write_text(f"{study_report(values)}\n{markdown([comparison(values)])}", output / "results.md")
