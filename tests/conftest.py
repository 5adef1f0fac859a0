"""Fixtures that several tests share."""

from pathlib import Path
from types import SimpleNamespace

import pytest
from scipy.io import loadmat


@pytest.fixture(scope="session")
def shared_folder() -> Path:
    """The folder of sources that are not part of the repository (specification, database)."""
    folder = Path(__file__).resolve().parents[2] / "shared"
    if not folder.is_dir():
        pytest.skip("the folder ../shared with the specification and the database is not here")
    return folder


@pytest.fixture(scope="session")
def database_tables(shared_folder: Path) -> dict[str, SimpleNamespace]:
    """The tables of SPEC 5 straight from the database, with `axes` and `values`, by name."""
    axes = {
        "C6_bas": ("alpha", "beta"),
        "dC6_rud": ("alpha", "beta", "rud"),
        "dC6_ail": ("alpha", "beta", "ail"),
        "dC3_ele": ("alpha", "beta", "stab", "elev"),
        "dC3_p": ("alpha", "phat"),
        "dC3_q": ("alpha", "qhat"),
        "dC3_r": ("alpha", "rhat"),
        "dC6_w": ("alpha", "what", "beta"),
    }
    database = loadmat(shared_folder / "gtm" / "T2_polynomial_aerodatabase.mat", simplify_cells=True)
    return {
        name: SimpleNamespace(
            axes=tuple(database[name][axis].astype(float) for axis in names), values=database[name]["data"]
        )
        for name, names in axes.items()
    }
