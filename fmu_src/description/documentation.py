"""The documentation folder of an FMU: a page with every variable, and the licences."""

from importlib.metadata import distributions, version
from importlib.resources import files
from pathlib import PurePath

from jinja2 import Environment, StrictUndefined

from fmu_src.description.model_description import EXTRA, ModelDescription

PROJECT = "gtm-fmu"


def legal_texts(name: str) -> dict[str, bytes]:
    """Licence and notice files of an installed package, by their names in an FMU."""
    texts: dict[str, bytes] = {}
    for package in distributions(name=name):  # a folder in which it was built, without these, may come first
        paths = [PurePath(path) for path in package.files or () if "licenses" in path.parts]
        for path in paths:
            texts.setdefault(f"{name}-{path.name}.txt", (package.read_text(f"licenses/{path.name}") or "").encode())
    return texts


def documentation(model: ModelDescription, platforms: list[str], licences: dict[str, bytes]) -> dict[str, bytes]:
    """Files of the documentation folder by their path in it.

    Args:
        licences: those of others' works in the FMU, by file name.
    """
    own = legal_texts(PROJECT)
    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, keep_trailing_newline=True)
    template = environment.from_string(
        files("fmu_src.description").joinpath("documentation.html").read_text(encoding="utf-8")
    )
    page = template.render(
        model=model,
        platforms=platforms,
        extra=EXTRA,
        version=version(PROJECT),
        notice=own[f"{PROJECT}-NOTICE.txt"].decode() if model.origin is None else model.origin,
        licences=sorted(own | licences),
    )
    texts = own | licences
    entry = "The licences of what is in this FMU:\n" + "".join(f"{name}\n" for name in sorted(texts))
    legal = {f"licenses/{name}": text for name, text in (texts | {"license.txt": entry.encode()}).items()}
    return {"index.html": page.encode(errors="backslashreplace")} | legal
