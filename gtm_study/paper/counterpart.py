"""A figure or table of the paper beside what the study has in its place."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

from gtm_study.tables import Cell

Verdict = Literal["same", "better", "different", "none"]
"""None: no counterpart, or its stage is not finished."""

Results = Mapping[str, Mapping[str, Any]]
"""Values of the stages that are finished, by the stage's name."""


class Finding(NamedTuple):
    """What the study found in the place of a published figure or table.

    Attributes:
        ours: our numbers in words.
        why: what the verdict rests on.
    """

    ours: str
    verdict: Verdict
    why: str


@dataclass(frozen=True)
class Counterpart:
    """A figure or table of the paper and its counterpart in the study.

    Attributes:
        number: as "Figure 10" or "Table 2".
        shows: what it shows.
        published: what the paper says there, as facts.
        stage: the stage of the study that computes ours; None where there is no counterpart.
        find: our finding, from the results of `stage` and of the stages that it needs.
        reason: without a stage, why there is no counterpart.
        figure: stem of a picture that the stage leaves in the study's folder as .svg and .png.
        table: key of a table in the stage's values: {"heads": [..], "rows": [[..], ..]}.
    """

    number: str
    shows: str
    published: str
    stage: str | None = None
    find: Callable[[Results], Finding] | None = None
    reason: str = ""
    figure: str | None = None
    table: str | None = None

    def finding(self, results: Results) -> Finding:
        """What the study found, by the stages that are finished."""
        if self.stage is None or self.find is None:
            return Finding("", "none", self.reason)
        if self.stage not in results:
            return Finding("", "none", f"Not computed yet: gtm-fmu study --only {self.stage}")
        return self.find(results)


def table(heads: Sequence[str], rows: Sequence[Sequence[Cell]]) -> dict[str, list[Any]]:
    """A table as the results of a stage hold it: cells are text, or numbers as they were computed."""
    return {"heads": list(heads), "rows": [list(row) for row in rows]}
