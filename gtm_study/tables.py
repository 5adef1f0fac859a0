"""Tables, text and numbers of a report, from which its Markdown and its page are made."""

from collections.abc import Iterable, Sequence
from typing import NamedTuple


class Table(NamedTuple):
    """Cells under heads, all of them text."""

    heads: Sequence[str]
    rows: Sequence[Sequence[str]]
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


def markdown_table(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table with a line of heads."""
    lines = [heads, ["---"] * len(heads), *rows]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


def short(value: float, digits: int = 3) -> str:
    """A number to so many significant digits."""
    return f"{value:.{digits}g}"
