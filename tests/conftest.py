"""Fixtures that several tests share."""

import shutil
from functools import reduce
from operator import getitem
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.io import loadmat

WITHOUT_TORCH = "torch is not here (extra `train`)"


@pytest.fixture(scope="session")
def torch():
    """The library, for tests that train; they are skipped without it."""
    return pytest.importorskip("torch", reason=WITHOUT_TORCH)


@pytest.fixture(scope="session")
def shared_folder() -> Path:
    """The folder of sources that are not part of the repository (specification, database)."""
    folder = Path(__file__).resolve().parents[2] / "shared"
    if not folder.is_dir():
        pytest.skip("the folder ../shared with the specification and the database is not here")
    return folder


@pytest.fixture(scope="session")
def database_tables(shared_folder: Path) -> dict[str, SimpleNamespace]:
    """The tables of SPEC 5 and 10 straight from the database, by name: `values`, and the `axes` with breakpoints."""
    axes = {
        "C6_bas": ("alpha", "beta"),
        "dC6_rud": ("alpha", "beta", "rud"),
        "dC6_ail": ("alpha", "beta", "ail"),
        "dC3_ele": ("alpha", "beta", "stab", "elev"),
        "dC3_p": ("alpha", "phat"),
        "dC3_q": ("alpha", "qhat"),
        "dC3_r": ("alpha", "rhat"),
        "dC6_w": ("alpha", "what", "beta"),
        "dC6_spo": ("alpha", "beta", "spo"),
        "dC3_lgr": ("alpha",),
        "dC6_damage.bas": ("alpha", "beta"),
        "dC6_damage.ddscale": ("alpha",),
        "dC6_damage.ddinc": ("alpha",),
    }
    database = loadmat(shared_folder / "gtm" / "T2_polynomial_aerodatabase.mat", simplify_cells=True)
    tables = {}
    for name, names in axes.items():
        entry = reduce(getitem, name.split("."), database)
        breakpoints = tuple(entry[axis].astype(float) for axis in names)
        tables[name] = SimpleNamespace(axes=breakpoints, values=entry["data"])
    panels = ("flaplob", "flaplib", "flaprib", "flaprob")
    flaps = np.array([database["flaps"][panel] for panel in panels])
    return {**tables, "flaps": SimpleNamespace(axes=(panels,), values=flaps)}


def pytest_collection_modifyitems(items) -> None:
    """Files with slow tests first: where several workers share a run, short ones fill its end."""
    slow = {item.path for item in items if item.get_closest_marker("slow")}
    items.sort(key=lambda item: item.path not in slow)


@pytest.fixture(scope="session")
def quick_compiler(tmp_path_factory) -> Path:
    """A folder for the front of PATH, with a C compiler that takes no time to optimise, where there is one at all."""
    folder = tmp_path_factory.mktemp("bin")
    if compiler := shutil.which("cc"):
        (folder / "cc").write_text(f'#!/bin/sh\nexec {compiler} "$@" -O0\n')
        (folder / "cc").chmod(0o755)
    return folder


def pytest_terminal_summary(terminalreporter) -> None:
    """Print the table of FMUs and importers, where its tests have run."""
    reports = [
        report for found in terminalreporter.stats.values() for report in found if hasattr(report, "user_properties")
    ]
    cells = {
        tuple(value[:2]): value[2] for report in reports for name, value in report.user_properties if name == "cell"
    }
    if cells:
        from tests.fmu_src.importer_matrix import CASES, table

        terminalreporter.section("FMUs in importers")
        terminalreporter.write_line(table(cells, CASES))
