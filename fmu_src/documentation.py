"""The documentation folder of an FMU: a page with every variable, and the licences."""

from importlib.metadata import Distribution, distribution
from importlib.resources import files
from pathlib import PurePath

from jinja2 import Environment, StrictUndefined

from fmu_src.description import ModelDescription

PROJECT = "gtm-fmu"


def _legal_texts(package: Distribution) -> dict[str, str]:
    """Licence and notice files of an installed package."""
    paths = [PurePath(path) for path in package.files or () if "licenses" in path.parts]
    return {path.name: package.read_text(f"licenses/{path.name}") or "" for path in paths}


def documentation(model: ModelDescription, platforms: list[str]) -> dict[str, bytes]:
    """Files of the documentation folder by their path in it."""
    project, wrapper = distribution(PROJECT), distribution("pythonfmu")
    own = _legal_texts(project)
    licences = {f"{PROJECT}-{name}.txt": text for name, text in own.items()}
    licences |= {f"pythonfmu-{name}.txt": text for name, text in _legal_texts(wrapper).items()}
    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, keep_trailing_newline=True)
    template = environment.from_string(files("fmu_src").joinpath("documentation.html").read_text(encoding="utf-8"))
    page = template.render(
        model=model,
        platforms=platforms,
        version=project.version,
        notice=own["NOTICE"],
        licences=sorted(licences),
    )
    return {"index.html": page.encode()} | {f"licenses/{name}": text.encode() for name, text in licences.items()}
