"""What a stage of the study is, what the stages of a run share, and how large they are."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from fmu_src.fmus import build_fmu
from gtm_fmu.datasets import lattice as lattices
from gtm_fmu.datasets import paper
from gtm_fmu.envelopes import maps
from gtm_fmu.progress import Advance
from gtm_study.files import save_figures
from gtm_study.paper import comparisons, every_failure, published, rudder_grid, rudder_sensitivity
from gtm_study.paper.protocol import Lattice, Protocol
from gtm_study.paper.rudder_grid import Cells
from surrogate import Schedule

LEVELS = ("quick", "paper", "full")
"""From the first minute and a half to everything; each holds the stages of those before it."""
USUAL_LEVEL = "paper"


@dataclass(frozen=True)
class Sizes:
    """How large the stages are: by default as in the paper."""

    altitudes_ft: tuple[float, ...] = paper.ALTITUDES_FT
    gammas_deg: tuple[float, ...] = paper.GAMMAS_DEG
    rudders_deg: tuple[float, ...] = paper.RUDDERS_DEG
    trims: int = 200
    jams_deg: tuple[float, ...] = comparisons.FIG_3_JAMS_DEG
    volume_gammas_deg: tuple[float, ...] = maps.GAMMAS_DEG
    map_altitudes_ft: tuple[float, ...] = maps.ALTITUDES_FT
    map_gammas_deg: tuple[float, ...] = maps.GAMMAS_DEG
    map_jam_step_deg: float = maps.JAM_STEP
    limit_step_deg: float = 1.0
    path_levels: tuple[int, int] = (31, 21)
    """Of altitude and flight path, where V_max is drawn over both."""
    rounds: int = published.TRAINING_ROUNDS
    hidden: int = 10
    epochs: int | None = None
    """Of the networks at most; None: the trainer's own."""
    most_local_models: int | None = None
    """None: the trainer's own."""
    neuron_counts: tuple[int, ...] = tuple(range(1, 21))
    neuron_iterations: int = 10
    """The appendix: 1 to 20 hidden neurons, the process iterated 10 times."""
    splits: int = 5
    data_set_splits: int = 3
    finer_cells: Cells = rudder_sensitivity.FINER_CELLS
    exact_cells: Cells = rudder_grid.EXACT_CELLS
    trajectories: int = published.TRAJECTORIES
    base_rows: int = 2**18
    """Of the variance-based design: 3.1 million evaluations."""
    mirrored_cases: int = 400
    failure_rows: int = every_failure.ROWS
    scanned_cases: int = 200


@dataclass(frozen=True)
class Run:
    """What the stages of a run share."""

    folder: Path
    seed: int
    sizes: Sizes

    def lattice(self, advance: Advance | None = None) -> xr.Dataset:
        """The solved lattice, from its store."""
        sizes = self.sizes
        failures = lattices.rudder_failures(sizes.rudders_deg)
        table = lattices.lattice(sizes.altitudes_ft, sizes.gammas_deg, failures)
        return lattices.solved(self.folder / "envelopes.zarr", table, advance)

    @property
    def schedule(self) -> Schedule | None:
        """Of the networks' training; None: the trainers' own."""
        return None if self.sizes.epochs is None else Schedule(epochs=self.sizes.epochs)

    def protocol(self) -> Protocol:
        """The paper's comparison of networks on the solved lattice, its parts and figures in the run's folder."""
        X, V, _ = lattices.samples(self.lattice())
        feasible = np.isfinite(V).all(axis=1)
        return Protocol(
            Lattice(X[feasible], V[feasible]),
            self.folder,
            rounds=self.sizes.rounds,
            jobs=2,
            schedule=self.schedule,
            hidden=self.sizes.hidden,
            most_local_models=self.sizes.most_local_models,
            neuron_counts=self.sizes.neuron_counts,
            neuron_iterations=self.sizes.neuron_iterations,
            shown=self.seed,
        )


Written = list[Path]
"""Files of a stage, which enters them."""


@dataclass(frozen=True)
class Stage:
    """A part of the study.

    Attributes:
        run: gives values by their names, ready for JSON.
        seconds: that it takes on two cores, roughly; its share of the progress.
        needs: names of stages whose files or parts it goes on with.
        level: from which on it belongs to the study.
    """

    name: str
    title: str
    run: Callable[[Run, Advance, Written], dict[str, Any]]
    seconds: float
    needs: tuple[str, ...] = ()
    level: str = LEVELS[0]


def draw(run: Run, written: Written, **drawn: Figure) -> None:
    """Write figures by their names, as .svg and as .png."""
    for name, figure in drawn.items():
        written += save_figures(figure, run.folder / name)


def build(run: Run, written: Written, name: str) -> Path:
    """Build an FMU into the run's folder."""
    written.append(build_fmu(name, run.folder))
    return written[-1]
