"""A hook of MkDocs: pages that are made of the code and of files beside docs/ when the site is built."""

import inspect
import json
import re
from collections.abc import Callable, Iterable
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any

import notebooks
import paper
import typer
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files

from fmu_src import MODELS, NATIVE_MODELS
from fmu_src.description.model_description import ModelDescription, Variable
from gtm_study.commands import cli

ROOT = Path(__file__).parents[2]
PACKAGES = {
    "gtm_fmu": "Envelopes, trims, linear models, thrust maps, data sets and the client of an FMU.",
    "surrogate": "Networks and local model networks for any data.",
    "sensitivity": "Sensitivity of any model whose inputs may depend on each other.",
    "fmu_src": "Builds the FMUs.",
}


def on_config(config: MkDocsConfig) -> MkDocsConfig:
    """Pages that `nav` of mkdocs.yml does not name are guides."""
    named = set(re.findall(r"[\w/-]+\.md", str(config.nav)))
    guides = next(section["Guides"] for section in config.nav or [] if "Guides" in section)
    guides += sorted(path.name for path in Path(config.docs_dir).glob("*.md") if path.name not in named)
    return config


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the pages that are made."""
    for path, make in pages().items():
        files.append(File.generated(config, path, content=make()))
    return files


def on_post_build(config: MkDocsConfig) -> None:
    """The theme's page for what a server does not find is of no use to a site that is opened as a file."""
    Path(config.site_dir, "404.html").unlink(missing_ok=True)


def on_page_markdown(markdown: str, **_: Any) -> str:
    """Links to files outside docs/ lead to the pages that are made of them."""
    linked = re.sub(r"\]\(\.\./\.\./examples/notebooks/(\w+)\.py\)", r"](\1.md)", markdown)
    return linked.replace("](../README.md", "](index.md")


def pages() -> dict[str, Callable[[], str]]:
    """What makes the text of a page, by its path."""
    made: dict[str, Callable[[], str]] = {
        "index.md": front_page,
        "reference/command-line.md": command_line,
        "reference/fmu-variables.md": fmu_variables,
        "reference/benchmarks.md": benchmarks,
        "reference/paper.md": paper.page,
        "reference/results.md": paper.all_results,
        "reference/changes.md": lambda: _text("CHANGELOG.md"),
        "reference/contributing.md": lambda: _text("CONTRIBUTING.md").replace("](docs/", "](../"),
        "reference/notice.md": lambda: f"# Notice\n\n```text\n{_text('NOTICE')}```\n\nLicence: Apache-2.0.\n",
    }
    made |= {f"reference/{name}.md": partial(package, name) for name in PACKAGES}
    for path in notebooks.NOTEBOOKS:
        made |= {f"tutorials/{path.stem}.md": partial(notebooks.page, path)}
        made |= {f"tutorials/{path.stem}.ipynb": partial(notebooks.ipynb, path)}
    return made


def _text(path: str) -> str:
    return (ROOT / path).read_text(encoding="utf-8")


def front_page() -> str:
    """README, its links seen from docs/."""
    text = _text("README.md").replace("](docs/", "](").replace("](NOTICE)", "](reference/notice.md)")
    return f"---\nhide: [navigation]\n---\n\n{text}"


def benchmarks() -> str:
    """README's table of speeds, then every row that was measured, with the machine."""
    speed = re.search(r"^## Speed\n(.+?)(?=^## )", _text("README.md"), re.MULTILINE | re.DOTALL)
    assert speed, "README has a section on speed"
    parts = ["# Benchmarks", speed[1].strip(), "## Every measured row"]
    for path in sorted((ROOT / "benchmarks" / "results").glob("*.json")):
        result = json.loads(path.read_text(encoding="utf-8"))
        told = [f"### {path.stem}", f"*{result['machine']}*; `python benchmarks/{path.stem}.py`"]
        if "rows" in result:
            rows = [
                [row["name"], f"{row['value']:g} {row['unit']}"]
                + ([row["peer"], f"{row['peer_value']:g}", f"{row['ratio']:g}"] if "peer" in row else ["", "", ""])
                for row in result["rows"]
            ]
            told.append(table(("what", "here", "peer", "its value", "ratio"), rows))
        else:
            rows = [[name.replace("_", " "), f"{value:g}"] for name, value in result.items() if name != "machine"]
            told.append(table(("what, in the unit of its name", "value"), rows))
        parts += told
    return _page(parts)


def package(name: str) -> str:
    """The public names of a package, with their docstrings."""
    module = import_module(name)
    kinds: dict[str, list[str]] = {"Functions": [], "Classes": [], "Others": []}
    for each in sorted(module.__all__):
        value = getattr(module, each)
        kind = "Classes" if inspect.isclass(value) else "Functions" if inspect.isfunction(value) else "Others"
        # by its home, for a module of the package may have the same name
        home = name if kind == "Others" else value.__module__
        kinds[kind] += [] if each.startswith("__") else [f"::: {home}.{each}"]
    parts = [part for kind, names in kinds.items() if names for part in (f"## {kind}", *names)]
    return _page([f"# {name}", PACKAGES[name], *parts])


def command_line() -> str:
    """Every command with its options, as the commands themselves tell them."""
    parts = ["# The command line", "`gtm-fmu COMMAND --help` prints the same."]

    def describe(command: Any, name: str) -> None:
        context = typer.Context(command, info_name=name)
        usage = " ".join([name, *command.collect_usage_pieces(context)])
        parts.extend([f"## {name}", (command.help or "").strip(), f"    {usage}"])
        records = [record for each in command.get_params(context) if (record := each.get_help_record(context))]
        parts.append(table(("option", "what"), [[f"`{option}`", _escaped(what)] for option, what in records]))
        if examples := (command.epilog or "").partition("Example:\n")[2].strip().splitlines():
            parts.append("For example:\n\n" + "\n".join(f"    {line.strip()}" for line in examples))
        for child, each in getattr(command, "commands", {}).items():
            describe(each, f"{name} {child}")

    commands: Any = typer.main.get_command(cli.app)
    for name, command in commands.commands.items():
        describe(command, f"gtm-fmu {name}")
    return _page(parts)


def fmu_variables() -> str:
    """Variables of every FMU, of the tables that the FMUs are made of."""
    parts = [
        "# Variables of the FMUs",
        "The interface is in SI; start, least and greatest are in the display unit where there is one. A variable that "
        "only some FMUs of a model have says which.",
    ]
    models = [contents([]).model for contents in MODELS.values()]
    models += [contents([]).model for contents in NATIVE_MODELS.values()]
    families: dict[str, list[ModelDescription]] = {}
    for model in models:
        families.setdefault(re.sub(r"Native3?$", "", model.name), []).append(model)
    for name, family in families.items():
        parts += [f"## {name}", f"{family[-1].title}. {', '.join(f'`{model.name}`' for model in family)}."]
        groups: dict[str, dict[Variable, list[str]]] = {}
        for model in family:
            for group, variables in model.groups.items():
                for variable in variables:
                    groups.setdefault(group, {}).setdefault(variable, []).append(model.name)
        for group, found in groups.items():
            rows = [
                _variable_row(variable, [] if len(owners) == len(family) else owners)
                for variable, owners in found.items()
            ]
            heading = ("name", "meaning", "causality", "unit", "start", "range")
            parts += [f"### {name}: {group}", table(heading, rows)]
    return _page(parts)


def _variable_row(variable: Variable, owners: Iterable[str]) -> list[str]:
    unit = "Boolean" if variable.boolean else variable.unit
    if variable.items:
        unit = ", ".join(f"{number} {item}" for number, item in enumerate(variable.items, 1))
    if variable.display_unit:
        unit += f", shown in {variable.display_unit}"
    numbers = [variable.start, variable.minimum, variable.maximum]
    start, least, greatest = ("" if each is None else f"{variable.displayed(each):.6g}" for each in numbers)
    only = f" (only {', '.join(owners)})" if owners else ""
    return [
        f"`{variable.name}`",
        _escaped(variable.description + only),
        variable.causality,
        unit,
        start,
        f"{least} .. {greatest}" if least or greatest else "",
    ]


def table(heading: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """A table in Markdown."""
    lines = [list(heading)]
    lines += [["---"] * len(lines[0]), *map(list, rows)]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def _escaped(text: str) -> str:
    """Words that Markdown would take for something else."""
    return re.sub(r"([*_<>\[\]$|])", r"\\\1", text)


def _page(parts: Iterable[str]) -> str:
    return "\n\n".join(parts) + "\n"
