"""The way through the house: no module imports a room above its own, and no imports go in a circle."""

import ast
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
ROOMS = (
    ("gtm_fmu.conformal", "gtm_fmu.errors", "gtm_fmu.files", "gtm_fmu.interrupt", "gtm_fmu.progress", "gtm_fmu.units"),
    ("gtm_fmu.airframe",),
    ("gtm_fmu.core",),
    ("gtm_fmu.aircraft",),
    ("gtm_fmu.trims",),
    ("gtm_fmu.envelopes",),
    ("gtm_fmu.datasets",),
    ("gtm_fmu",),
    ("surrogate.scaling",),
    ("surrogate.core",),
    ("surrogate.models",),
    ("surrogate.training",),
    ("surrogate.exports",),
    ("surrogate",),
    ("surrogate.rudder",),
    ("fmu_src.slaves",),
    ("fmu_src.description",),
    ("fmu_src.packing",),
    ("fmu_src", "build_fmu"),
    ("sensitivity",),
    ("gtm_study.files", "gtm_study.kept", "gtm_study.progress", "gtm_study.style", "gtm_study.tables"),
    ("gtm_study.figures",),
    ("gtm_study.explorer",),
    ("gtm_study.research",),
    ("gtm_study.paper",),
    ("gtm_study.report",),
    ("gtm_study.commands", "gtm_study", "gtm_fmu.__main__"),
)
"""From the ground up, as docs/architecture.md says; a module is in the room with the longest name that begins its."""

MODULES = {
    ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__"): path
    for top in ("gtm_fmu", "surrogate", "fmu_src", "sensitivity", "gtm_study", "build_fmu.py")
    for path in ([ROOT / top] if top.endswith(".py") else (ROOT / top).rglob("*.py"))
}


@cache
def imports(module: str) -> frozenset[str]:
    """Modules of ours that a module imports when it is loaded or later; what only a type checker reads is left out."""
    found = set()
    nodes = [ast.parse(MODULES[module].read_text(encoding="utf-8"))]
    package = module if MODULES[module].name == "__init__.py" else module.rpartition(".")[0]
    while nodes:
        node = nodes.pop()
        if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING":
            nodes += node.orelse
            continue
        nodes += ast.iter_child_nodes(node)
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            base = package.split(".")[: len(package.split(".")) - node.level + 1] if node.level else []
            home = ".".join([*base, *([node.module] if node.module else [])])
            found |= {name if (name := f"{home}.{alias.name}") in MODULES else home for alias in node.names}
    return frozenset(found & MODULES.keys() - {module})


def level(module: str) -> int:
    """How high its room lies."""
    fits = [
        (len(name), floor) for floor, names in enumerate(ROOMS) for name in names if f"{module}.".startswith(name + ".")
    ]
    return max(fits)[1]


@pytest.mark.parametrize("module", sorted(MODULES))
def test_imports_nothing_from_above(module):
    above = {found for found in imports(module) if level(found) > level(module)}
    assert not above, f"{module} imports {', '.join(sorted(above))}, which lie above it"


def test_no_circles():
    try:
        TopologicalSorter({module: imports(module) for module in MODULES}).prepare()
    except CycleError as error:
        pytest.fail(" imports ".join(reversed(error.args[1])))


def test_finds_what_goes_up():
    """The walk sees imports inside functions, of submodules by their package, and relative ones."""
    assert "gtm_study.paper.pipeline" in imports("gtm_study.commands.study")
    assert "surrogate.models.network" in imports("surrogate.rudder.networks")
    assert "sensitivity.plots" in imports("sensitivity.result")
    assert level("gtm_study.commands.cli") > level("surrogate.rudder.emulator") > level("gtm_fmu.envelopes.maps")
