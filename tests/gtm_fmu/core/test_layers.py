"""The C files of the core in layers: none uses one above it, the solver knows no aircraft, every build has them all."""

import re
import shutil
import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest

from gtm_fmu.core.library import library_path
from gtm_fmu.core.sources import DYNAMICS, THRUST_MAP, WHOLE

CORE = library_path().parent
ROOT = CORE.parents[1]
HEADERS = sorted(path.relative_to(CORE).as_posix() for path in CORE.rglob("*.h"))

COMMENT_OR_TEXT = re.compile(r'/\*.*?\*/|"[^"\n]*"', re.DOTALL)
NUMBERS = re.compile(r"^[-\d].*\n", re.MULTILINE)
INCLUDE = re.compile(r'^#include "([^"]+)"', re.MULTILINE)
DEFINITION = re.compile(r"^(?!static\b|extern\b|typedef\b)\w[\w *]*?\b(gtm_\w+) *[(\[=]", re.MULTILINE)
"""A function or array at the margin; the group is its name."""


def text(name: str) -> str:
    return (CORE / name).read_text()


@cache
def code(name: str) -> str:
    """A file without comments, strings and rows of numbers."""
    return COMMENT_OR_TEXT.sub("", NUMBERS.sub("", text(name)))


def defined(name: str) -> set[str]:
    """External names that a C file defines; CasADi's functions are in its headers."""
    header = name.replace(".c", ".h")
    if name.startswith("generated/") and (CORE / header).exists():
        return set(re.findall(r"^int (cas_\w+)\(const casadi_real", text(header), re.MULTILINE))
    return set(DEFINITION.findall(code(name)))


@pytest.fixture(scope="module")
def homes() -> dict[str, str]:
    """The file of each external name."""
    found = [(given, name) for name in WHOLE for given in defined(name)]
    assert len(found) == len(dict(found)), "a name has two homes"
    return dict(found)


def uses(name: str, homes: dict[str, str]) -> set[str]:
    """Other files whose functions and constants a C file names."""
    return {homes[word] for word in set(re.findall(r"\w+", code(name))) if word in homes} - {name}


def test_every_c_file_is_listed_once():
    assert sorted(WHOLE) == sorted(path.relative_to(CORE).as_posix() for path in CORE.rglob("*.c"))
    assert len(set(WHOLE)) == len(WHOLE)


def test_the_search_sees_calls_and_constants(homes):
    """Known calls, so that the tests below cannot pass for want of sight."""
    assert homes["gtm_newton"] == "solver/newton.c"
    assert homes["cas_trim_residual"] == "generated/airframe.c"
    assert homes["gtm_basic_table"] == "generated/tables.c"
    assert uses("solver/newton.c", homes) == {"solver/problem.c", "solver/linear_algebra.c"}
    assert {"solver/trim.c", "gtm_t2.c", "generated/airframe.c"} <= uses("manoeuvres.c", homes)
    assert "generated/tables.c" in uses("gtm/table.c", homes)


def test_no_file_uses_one_above_it(homes):
    upward = [(name, used) for k, name in enumerate(WHOLE) for used in uses(name, homes) & set(WHOLE[k + 1 :])]
    assert upward == []


@pytest.mark.parametrize("part", [DYNAMICS, THRUST_MAP], ids=["dynamics", "thrust map"])
def test_a_part_is_closed(part, homes):
    """What an FMU of these files calls is in them."""
    assert {used for name in part for used in uses(name, homes)} <= set(part)


@cache
def place(header: str) -> int:
    """Where a header stands: with its C file, else just above all that it includes."""
    own = header.replace(".h", ".c")
    if own in WHOLE:
        return WHOLE.index(own)
    return max((place(included) for included in INCLUDE.findall(text(header))), default=-1)


def test_no_file_includes_a_header_above_it():
    """But for tables, which are generated in the types of their look-ups."""
    lower = [name for name in (*WHOLE, *HEADERS) if not name.startswith("generated/")]
    above = [
        (name, included)
        for name in lower
        for included in INCLUDE.findall(text(name))
        if place(included) > place(name.replace(".c", ".h"))
    ]
    assert above == []


SOLVER = [name for name in (*WHOLE, *HEADERS) if name.startswith("solver/")]


@pytest.mark.parametrize("name", SOLVER)
def test_the_solver_knows_no_aircraft(name):
    """It includes its own headers and the order of the unknowns, nothing of the GTM."""
    allowed = {"generated/order.h", "generated/unknowns.h"}
    assert {path for path in INCLUDE.findall(text(name)) if not path.startswith("solver/")} <= allowed


def test_make_rebuilds_the_core_from_everything_it_is_made_of():
    """Every C file, header and module that generation imports is a prerequisite of the installation."""
    if shutil.which("make") is None:
        pytest.skip("no `make` on this machine")
    script = (
        "import sys, gtm_fmu.core\n"
        "before = set(sys.modules)\n"
        "import gtm_fmu.core.generate\n"
        "names = (name for name in set(sys.modules) - before if name.startswith('gtm_fmu'))\n"
        "print(*(sys.modules[name].__file__ for name in names), sep='\\n')"
    )
    imported = subprocess.run([sys.executable, "-c", script], check=True, capture_output=True, text=True, cwd=ROOT)
    modules = {Path(path).relative_to(ROOT).as_posix() for path in imported.stdout.split()}
    assert {"gtm_fmu/core/c_source.py", "gtm_fmu/core/stored_tables.py"} < modules
    c = {f"gtm_fmu/core/{name}" for name in (*WHOLE, *HEADERS) if not name.startswith("generated/")}

    database = subprocess.run(["make", "-pnq"], capture_output=True, text=True, cwd=ROOT).stdout
    rule = re.search(r"^\.venv/installed: (.*)$", database, re.MULTILINE)
    assert rule
    assert modules | c | {"gtm_fmu/core/sources.py", "setup.py"} <= set(rule[1].split())
