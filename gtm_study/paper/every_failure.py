"""Everything that may fail at once: what matters for the envelope that is left, and which surface matters least.

Limits of all four controls over their triangles, and beside them damage and an engine that is out, at any altitude and
flight path of the paper. The exact envelopes of two designs come with the package;
``python -m gtm_study.paper.every_failure FOLDER`` computes them anew (half an hour of processor time), and goes on
where it was stopped.
"""

import argparse
import sys
from collections.abc import Callable
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from scipy import stats

import sensitivity
from gtm_fmu.aircraft.inputs import CHOICES, INPUTS, LIMITED, Column, limit_columns
from gtm_fmu.airframe.names import CONTROLS
from gtm_fmu.datasets.cases import GivenCases
from gtm_fmu.datasets.paper import ALTITUDE_FT, GAMMA_DEG
from gtm_fmu.errors import script
from gtm_study.paper.rudder_grid import RESULTS, write_arrays
from gtm_study.progress import stages
from sensitivity.redraw_ratios import RedrawRatios

ROWS, REPLICATES, SEED = 1024, 8, 0
SURFACES = CONTROLS[:3]
CONFIDENCE, BOOTSTRAP = 0.95, 1000
FILE = Path(str(files("gtm_study.paper") / "data" / "every_failure.npz"))
OUTPUTS = ("has_envelope", "width_kt")
"""Whether there is an envelope, and V_max less V_min: 0 without one."""


@dataclass(frozen=True)
class Scenario:
    """Some failures at once.

    Attributes:
        controls: whose limits are uniform over their triangles.
        choices: what of `inputs.CHOICES` is drawn, and from how many of its first values, all alike.
    """

    controls: tuple[str, ...]
    choices: dict[str, int]

    @property
    def columns(self) -> tuple[Column, ...]:
        """Columns of a case, in the order of the distribution's inputs."""
        ends = (end for control in self.controls for end in limit_columns(control))
        return *INPUTS[:2], *(Column(name, "") for name in self.choices), *ends

    @property
    def distribution(self) -> sensitivity.Distribution:
        """Of the inputs, by the labels of the columns."""
        (altitude, gamma), units = INPUTS[:2], {column.label: column.units for column in self.columns}
        blocks: list[sensitivity.Block] = [
            sensitivity.Uniform(altitude.label, *ALTITUDE_FT, units[altitude.label]),
            sensitivity.Uniform(gamma.label, *GAMMA_DEG, units[gamma.label]),
            *(sensitivity.Marginal(name, stats.randint(0, count)) for name, count in self.choices.items()),
        ]
        for control in self.controls:
            low, high = limit_columns(control)
            blocks.append(sensitivity.OrderedUniform((low.label, high.label), *LIMITED[control][1], low.units))
        return sensitivity.Distribution(blocks)

    def design(self, rows: int = ROWS) -> sensitivity.Design:
        """Of altitude, flight path, each choice and each control with both its limits."""
        distribution = self.distribution
        factors = [block.names for block in distribution.blocks]
        return sensitivity.variance_design(distribution, rows, factors=factors, replicates=REPLICATES, seed=SEED)


CONTROLS_ONLY, EVERYTHING = "controls", "everything"
ENGINES = ("none", "left", "right")
"""Engines that may be out; with both there is no level flight."""
SCENARIOS = {
    CONTROLS_ONLY: Scenario(CONTROLS, {}),
    EVERYTHING: Scenario(CONTROLS, {"damage_case": len(CHOICES["damage_case"]), "engine_out": len(ENGINES)}),
}


def solve(
    folder: Path, name: str, rows: int = ROWS, workers: int | None = None, progress: Callable | None = None
) -> np.ndarray:
    """Exact V_min, V_max in kn and t_min in % (n, 3) of a scenario's design, NaN where there is none.

    Raises:
        InputError: as `distribution.compute`.
    """
    from gtm_fmu.datasets.distribution import compute
    from gtm_fmu.datasets.store import open_cases

    scenario, store = SCENARIOS[name], folder / f"{name}.zarr"
    compute(store, GivenCases(scenario.columns, scenario.design(rows).points), workers=workers, progress=progress)
    data = open_cases(store)
    return np.column_stack([data[result].values for result in RESULTS])


def evaluated(name: str) -> sensitivity.EvaluatedDesign:
    """A scenario's design with `OUTPUTS`, from the exact envelopes that come with the package."""
    design = SCENARIOS[name].design()
    with np.load(FILE) as content:
        v_min, v_max, _ = content[name].astype(float).T
    width = v_max - v_min
    return design.attach(design.points, np.column_stack([np.isfinite(width), np.nan_to_num(width)]), OUTPUTS)


def indices(name: str) -> sensitivity.VarianceIndices:
    """Of `OUTPUTS` over a scenario."""
    return sensitivity.variance_indices(evaluated(name))


def least(found: sensitivity.EvaluatedDesign, output: str) -> list[str]:
    """The surface whose limits matter least, by S^T, and those that the sampling does not tell apart from it."""
    j, factors = found.output_names.index(output), found.design.factors
    by_surface = {factor[0].split("_")[0]: factor for factor in factors if len(factor) > 1}
    ratios = RedrawRatios(found, CONFIDENCE, BOOTSTRAP, SEED)
    total = {surface: ratios.total(by_surface[surface]) for surface in SURFACES}
    values = ratios.estimate(list(total.values())).value[:, j]
    first, *others = (SURFACES[k] for k in np.argsort(values))
    further = ratios.estimate([total[other] - total[first] for other in others])
    return [first, *(other for other, lower in zip(others, further.lower[:, j], strict=True) if lower <= 0.0)]


def results() -> dict[str, Any]:
    """Indices of every scenario as plain numbers, with what `least` says for each output."""
    found = {}
    for name in SCENARIOS:
        runs = evaluated(name)
        surfaces = {output: least(runs, output) for output in OUTPUTS}
        found[name] = sensitivity.variance_indices(runs).to_dict() | {"least_surfaces": surfaces}
    return found


@script
def main() -> None:
    """Compute the envelopes of both designs and write the file of the package into a folder."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, help="where the data sets go, and the file made of them")
    parser.add_argument("--workers", type=int, help="processes; default one a core")
    given = parser.parse_args()
    found = {}
    with stages(Console(stderr=True)) as stage:
        for name in SCENARIOS:
            with stage(f"Envelopes of {name}") as advance:
                found[name] = solve(given.folder, name, workers=given.workers, progress=advance)
    write_arrays(given.folder / FILE.name, found)


if __name__ == "__main__":
    sys.exit(main())
