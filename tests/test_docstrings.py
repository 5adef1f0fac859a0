"""What the public names tell a reader: every argument, the shapes of arrays, units, and the errors that are raised.

Public are the names that a package exports, and the public methods of the classes among them. An argument of a function
has an entry under ``Args``; one of a method may be named in a sentence. A method that another exported class of its
package has as well, as ``sample`` of `sensitivity.Block`, is told of there.
"""

import ast
import inspect
import re
import textwrap
from importlib import import_module
from types import FunctionType
from typing import NamedTuple

import pytest
from numpy.typing import ArrayLike

PACKAGES = ("gtm_fmu", "surrogate", "sensitivity", "fmu_src")
INTERFACES = ("Block", "Density")
ARRAYS = re.compile(r"\b(ArrayLike|ndarray|Array)\b")
SHAPE = re.compile(
    r"\((\.\.\.?,|[a-zA-Z]\w*(\(names\))?,|\d+\b|9 or 10|stop - start)[^()]*(\([^()]*\))?[^()]*\)|broadcast"
)
UNITS = re.compile(r"%|\b(ft|kn|deg|rad|s|lbf?|SI|units?|share|probability|core units|FMU)\b")
SUFFIXES = ("_ft", "_kt", "_deg", "_deg_s", "_pct", "_lb", "_s", "_lbf", "_n")


class Documented(NamedTuple):
    """A function or method, and what is told of it."""

    name: str
    function: FunctionType
    told: str
    is_method: bool

    @property
    def entries(self) -> dict[str, str]:
        """Text by argument under ``Args``."""
        section = re.search(r"^Args:\n((?:(?:    .*)?\n?)*)", self.told, re.MULTILINE)
        found = re.split(r"^    (\w+(?:, \w+)*): ", section[1] if section else "", flags=re.MULTILINE)[1:]
        pairs = zip(found[::2], found[1::2], strict=True)
        return {name: text for names, text in pairs for name in names.split(", ")}

    @property
    def arguments(self) -> dict[str, str]:
        """Annotations by argument; older NumPy has no name for ``ArrayLike``, but a long union."""
        parameters = inspect.signature(self.function).parameters
        annotations = {name: each.annotation for name, each in parameters.items() if name not in ("self", "cls")}
        return {name: "ArrayLike" if each == ArrayLike else str(each) for name, each in annotations.items()}

    @property
    def raised(self) -> set[str]:
        """Errors that the function raises itself."""
        nodes, found = [ast.parse(textwrap.dedent(inspect.getsource(self.function)))], set()
        while nodes:
            node = nodes.pop()
            inner = [*node.handlers, *node.orelse, *node.finalbody] if isinstance(node, ast.Try) else []
            nodes += inner or ast.iter_child_nodes(node)  # what is raised inside `try` may be caught
            if isinstance(node, ast.Raise) and isinstance(node.exc, ast.Call):
                found.add(ast.unparse(node.exc.func))
        return {name for name in found if name[0].isupper()}


def documented(package: str) -> list[Documented]:
    """Functions and public methods of a package's exported names."""
    module = import_module(package)
    exported = {name: getattr(module, name) for name in module.__all__ if not name.startswith("__")}
    found = []
    for name, value in exported.items():
        if isinstance(value, FunctionType):
            found.append(Documented(name, value, inspect.getdoc(value) or "", False))
        elif inspect.isclass(value):
            told_elsewhere = {
                each for base in INTERFACES if base in exported and base != name for each in vars(exported[base])
            }
            for method, member in vars(value).items():
                function = getattr(member, "__func__", member)
                if isinstance(function, FunctionType) and not method.startswith("_") and method not in told_elsewhere:
                    found.append(Documented(f"{name}.{method}", function, inspect.getdoc(function) or "", True))
    return found


ALL = {package: documented(package) for package in PACKAGES}


def test_there_are_many():
    assert sum(map(len, ALL.values())) > 140


@pytest.mark.parametrize("package", PACKAGES)
def test_arguments(package):
    faults = []
    for each in ALL[package]:
        named = {name for name in each.arguments if each.is_method and re.search(rf"\b{name}\b", each.told)}
        faults += [f"{each.name}: {name} is missing" for name in set(each.arguments) - set(each.entries) - named]
        faults += [f"{each.name}: {name} is no argument" for name in set(each.entries) - set(each.arguments)]
    assert not faults


@pytest.mark.parametrize("package", PACKAGES)
def test_shapes(package):
    faults = []
    for each in ALL[package]:
        first = each.told.partition("\n\n")[0]
        for name, annotation in each.arguments.items():
            if ARRAYS.search(annotation) and "Callable" not in annotation:
                is_told = SHAPE.search(each.entries.get(name) or each.told) or SHAPE.search(first)
                faults += [] if is_told else [f"{each.name}: {name}"]
    assert not faults


@pytest.mark.parametrize("package", PACKAGES)
def test_raised_errors(package):
    faults = [(each.name, each.raised) for each in ALL[package] if not all(error in each.told for error in each.raised)]
    assert not faults


def test_units():
    """Of numbers of the aircraft: in the name, or in what is told."""
    faults = []
    for each in ALL["gtm_fmu"]:
        for name, annotation in each.arguments.items():
            if re.search(r"\bfloat\b", annotation) and "Callable" not in annotation and not name.endswith(SUFFIXES):
                faults += [] if UNITS.search(each.entries.get(name) or each.told) else [f"{each.name}: {name}"]
    assert not faults
