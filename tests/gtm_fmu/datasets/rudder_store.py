"""A small store of rudder jams, for the tests of what is written and of what is read."""

from pathlib import Path

import numpy as np

from gtm_fmu.datasets.axes import levels, limit_levels
from gtm_fmu.datasets.cases import CaseTable
from gtm_fmu.datasets.store import CaseStore, writer_lock

OPTIONS = {"alpha_deg": [-5.0, 10.5], "phi_deg": [-30.0, 30.0]}
CHUNK = 4


def jams(*deflections: float, altitude_ft: float = 20000.0) -> CaseTable:
    return CaseTable.lattice(
        [
            levels("altitude", [altitude_ft]),
            levels("gamma", [0.0]),
            limit_levels("rudder", [(deflection, deflection) for deflection in deflections]),
        ]
    )


TABLE = jams(0.0, 3.0, 10.0, 14.5, 22.0, 30.0)
"""Six cases, two chunks; the last has no envelope."""


def fill(path: Path, found: dict[str, np.ndarray], *chunks: range) -> Path:
    with writer_lock(path):
        store = CaseStore(path, TABLE, OPTIONS, CHUNK)
        for cases in chunks or store.unfinished():
            store.write(cases, {name: values[cases.start : cases.stop] for name, values in found.items()})
    return path
