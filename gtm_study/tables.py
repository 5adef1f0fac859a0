"""Tables, text and numbers of a report, from which its Markdown and its page are made."""

from collections.abc import Iterable, Sequence
from typing import NamedTuple

Cell = str | float
"""Text, or a number, which is shown to a few digits and kept whole for a download."""


class Table(NamedTuple):
    """Cells under heads."""

    heads: Sequence[str]
    rows: Sequence[Sequence[Cell]]
    caption: str = ""
    """For a page; Markdown has none."""


class Section(NamedTuple):
    """A titled part of a report: paragraphs and tables; ``level`` 1 is the whole."""

    title: str
    level: int
    parts: tuple[str | Table, ...]


def markdown(sections: Iterable[Section]) -> str:
    """A report as Markdown."""
    blocks = []
    for section in sections:
        blocks.append(f"{'#' * section.level} {section.title}\n")
        blocks += [
            markdown_table(part.heads, part.rows) if isinstance(part, Table) else f"{part}\n" for part in section.parts
        ]
    return "\n".join(blocks)


def markdown_table(heads: Sequence[str], rows: Sequence[Sequence[Cell]]) -> str:
    """A table with a line of heads."""
    lines = [heads, ["---"] * len(heads), *(map(shown, row) for row in rows)]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


def shown(cell: Cell) -> str:
    """A cell as it is read: a number to four digits, an integer whole."""
    return cell if isinstance(cell, str) else str(cell) if isinstance(cell, int) else short(cell, 4)


def short(value: float, digits: int = 3) -> str:
    """A number to so many significant digits."""
    return f"{value:.{digits}g}"
