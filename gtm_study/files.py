"""Files of a study, each written in one piece or not at all."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gtm_fmu.errors import InputError
from gtm_fmu.files import check_writable, write_whole
from gtm_study.style import figure_style

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def write_text(text: str, path: Path) -> None:
    """Write a text file."""
    write_whole(path, lambda partial: partial.write_text(text, encoding="utf-8"))


def write_bytes(content: bytes, path: Path) -> None:
    """Write a file of bytes."""
    write_whole(path, lambda partial: partial.write_bytes(content))


def save_figure(figure: "Figure", path: Path) -> None:
    """Write a figure as SVG or as PNG, by the ending of its name; the same figure gives the same bytes."""
    ending = path.suffix.removeprefix(".")
    metadata: dict[str, Any] = {"metadata": {"Date": None}} if ending == "svg" else {}
    with figure_style():
        write_whole(path, lambda partial: figure.savefig(partial, format=ending, **metadata))


def save_figures(figure: "Figure", stem: Path) -> list[Path]:
    """Write a figure as .svg and as .png, and return the files."""
    paths = [stem.with_name(f"{stem.name}{ending}") for ending in (".svg", ".png")]
    for path in paths:
        save_figure(figure, path)
    return paths


def check_picture(path: Path) -> None:
    """Refuse the name of neither a picture nor a page, before anything is computed for it.

    Raises:
        InputError: another ending, or a place that cannot be written.
    """
    if path.suffix not in (".png", ".html"):
        raise InputError(f"{path} ends in neither .png nor .html; name the picture or the page so.")
    check_writable(path)


def save_picture(path: Path, figure: "Callable[[], Figure]", page: Callable[[], str]) -> None:
    """Write a figure as a picture (.png) or as an interactive page (.html), by the ending of its name.

    Raises:
        InputError: another ending, or a place that cannot be written.
    """
    check_picture(path)
    if path.suffix == ".png":
        with figure_style():
            save_figure(figure(), path)
    else:
        write_text(page(), path)
