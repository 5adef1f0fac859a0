"""The exact data that the models of `surrogate_study` learn from and are measured on, each in a store of its own."""

from collections.abc import Mapping
from functools import partial
from pathlib import Path

from gtm_fmu.datasets import off_lattice
from gtm_fmu.datasets.cases import CaseTable, Sampling
from gtm_fmu.datasets.off_lattice import OffLattice, case_table
from gtm_fmu.progress import Advance

JAMS, CASES = 2048, 2048
OTHER_FAILURES: Mapping[str, tuple[str, ...]] = {
    "rudder and aileron": ("rudder", "aileron"),
    "rudder, aileron and elevator": ("rudder", "aileron", "elevator"),
    "aileron": ("aileron",),
    "elevator": ("elevator",),
}
"""Failures with 6, 8, 4 and 4 inputs."""
OTHER_CASES, OTHER_TEST_CASES = 512, 256
FURTHER_TEST_CASES = 1000


def rudder_sets() -> dict[str, CaseTable]:
    """What models of a failed rudder learn from: jams and cases by Sobol sequences, and jams by chance."""
    return {
        "sobol_jams": case_table(cases=JAMS, seed=1, jam_share=1.0, sampling=Sampling.SOBOL),
        "random_jams": case_table(cases=JAMS // 2, seed=2, jam_share=1.0),
        "sobol_cases": case_table(cases=CASES, seed=3, jam_share=0.5, sampling=Sampling.SOBOL),
    }


def further_cases() -> dict[str, CaseTable]:
    """What the surrogates of the package are measured on beside the test set."""
    return {"further_cases": case_table(cases=off_lattice.FURTHER_CASES, seed=off_lattice.FURTHER_SEED)}


def other_sets(failure: str) -> dict[str, CaseTable]:
    """What models of another failure learn from, and are measured on: a third of each control's limits are jams."""
    controls, name = OTHER_FAILURES[failure], failure.replace(", ", "_").replace(" and ", "_")
    return {
        f"{name}_sobol": case_table(controls, OTHER_CASES, 4, 1 / 3, Sampling.SOBOL),
        f"{name}_test": case_table(controls, OTHER_TEST_CASES, 5, 1 / 3),
    }


def several_controls() -> dict[str, CaseTable]:
    """Further cases with limits of several controls, which nothing learns from, by their failures."""
    return {
        failure: case_table(controls, FURTHER_TEST_CASES, off_lattice.SEED, 1 / 3)
        for failure, controls in OTHER_FAILURES.items()
        if len(controls) > 1
    }


def solved(folder: Path, tables: Mapping[str, CaseTable], advance: Advance) -> dict[str, OffLattice]:
    """Exact envelopes of some tables, continued where a stopped run left them."""
    total = sum(map(len, tables.values()))
    found: dict[str, OffLattice] = {}

    def count(already: int, done: int, _: int) -> None:
        advance(already + done, total)

    for name, table in tables.items():
        already = sum(len(data.X) for data in found.values())
        found[name] = off_lattice.solve(folder / f"{name}.zarr", table, partial(count, already))
    return found
