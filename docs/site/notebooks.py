"""Notebooks of examples/notebooks, which are Python with cells marked by ``# %%``, as pages and as .ipynb.

python docs/site/notebooks.py

draws their figures anew into docs/images/notebooks, which the pages show.
"""

import os
import re
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import nbformat

ROOT = Path(__file__).parents[2]
NOTEBOOKS = sorted((ROOT / "examples" / "notebooks").glob("*.py"))
IMAGES = ROOT / "docs" / "images" / "notebooks"
DRAWS = "plt.subplots"
"""In the cell that draws a notebook's figure."""


class Cell(NamedTuple):
    """A cell: its first line in the file, whether it is text in Markdown, and what it holds."""

    line: int
    is_text: bool
    text: str


def cells(path: Path) -> Iterator[Cell]:
    """The cells of a notebook, in order."""
    line = 1
    for part in re.split(r"^(?=# %%)", path.read_text(encoding="utf-8"), flags=re.MULTILINE):
        mark, _, text = part.partition("\n")
        is_text = "[markdown]" in mark
        if mark.startswith("# %%"):
            yield Cell(line, is_text, (re.sub(r"^# ?", "", text, flags=re.MULTILINE) if is_text else text).strip())
        line += part.count("\n")


def page(path: Path) -> str:
    """A page: text and programs, and the figure under the one that draws it."""
    parts = []
    for cell in cells(path):
        parts.append(cell.text if cell.is_text else f"```python\n{cell.text}\n```")
        if not cell.is_text and DRAWS in cell.text:
            parts.append(f"![What the program draws](../images/notebooks/{path.stem}.png)")
    parts.append(
        f"[Download it as a notebook]({path.stem}.ipynb), or take `examples/notebooks/{path.name}`, which VS Code, "
        "PyCharm and Jupyter with jupytext open as one. It runs in that folder."
    )
    return "\n\n".join(parts) + "\n"


def ipynb(path: Path) -> str:
    """A notebook for Jupyter."""
    made = nbformat.v4.new_notebook(metadata={"language_info": {"name": "python"}})
    for number, cell in enumerate(cells(path)):
        new = nbformat.v4.new_markdown_cell if cell.is_text else nbformat.v4.new_code_cell
        made.cells.append(new(cell.text, id=f"cell-{number}"))
    return nbformat.writes(made)


def draw() -> None:
    """Run all notebooks and keep their figures."""
    import matplotlib
    import matplotlib.pyplot as plt

    matplotlib.use("Agg")
    os.chdir(NOTEBOOKS[0].parent)
    for path in NOTEBOOKS:
        exec(compile(path.read_text(encoding="utf-8"), path, "exec"), {"__name__": "__main__"})
        plt.savefig(IMAGES / f"{path.stem}.png")
        plt.close("all")


if __name__ == "__main__":
    draw()
