"""The off-lattice test set: random cases between and beyond the lattice's nodes, with exact envelopes, and its scores.

The cases follow from a seed. Their envelopes come with the package, so that any model is measured at once; `solve`
computes them anew.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike

from gtm_fmu.aircraft.ranges import WIDEST
from gtm_fmu.datasets import paper
from gtm_fmu.datasets.axes import limits_span, span
from gtm_fmu.datasets.cases import CaseTable, Sampling
from gtm_fmu.errors import InputError

CASES, SEED = 4096, 2026
CALIBRATION_CASES, CALIBRATION_SEED = 1536, 7
"""Further cases, to choose the tolerances of a model by."""
FURTHER_CASES, FURTHER_SEED = 4000, 2027
"""Further cases, which no model was fitted, chosen or calibrated by."""
PARTS = ("restrictions", "jams", "all")
PERCENTILES = (50, 95, 99, 99.9, 100)
"""Of errors with and without a warning of a fold."""
LEVEL, DEVIATIONS = 0.95, 1.96
"""Share of the errors inside an interval of so many standard deviations to both sides."""
FILE = Path(str(files("gtm_fmu.datasets") / "data" / "off_lattice.npz"))


def case_table(
    controls: Sequence[str] = ("rudder",),
    cases: int = CASES,
    seed: int = SEED,
    jam_share: float = 0.5,
    sampling: Sampling = Sampling.RANDOM,
) -> CaseTable:
    """Altitudes, flight paths and limits of some controls by a seed; of each control a share are jams."""
    axes = (
        span("altitude", *paper.ALTITUDE_FT),
        span("gamma", *paper.GAMMA_DEG),
        *(limits_span(control, *WIDEST[f"{control}_deg"], jam_share) for control in controls),
    )
    return CaseTable.sampled(axes, sampling, cases, seed)


class Surrogate(Protocol):
    """What gives V_min and V_max of a failed control without solving: a thrust map, or networks."""

    def predict(self, cases: ArrayLike) -> Any:
        """Envelopes of cases (n, 4): named arrays (n), as `thrust_map.MapEnvelopes` with or without ``fold``."""

    def predict_one(self, altitude_ft: float, gamma_deg: float, limits_deg: tuple[float, float]) -> dict[str, Any]:
        """The same for one case, None where there is no number."""


@dataclass(frozen=True)
class OffLattice:
    """Cases X (n, 2 + 2 k): altitude ft, gamma deg, lower and upper limit in deg of each of k controls; exact speeds
    (n, 2) in kn and t_min (n) in %.

    NaN where there is no envelope, or no manoeuvre at any throttle.
    """

    X: np.ndarray
    speeds_kt: np.ndarray
    t_min_pct: np.ndarray

    @property
    def feasible(self) -> np.ndarray:
        """Whether each case has an envelope (n)."""
        return np.isfinite(self.speeds_kt).all(axis=1)

    @property
    def jammed(self) -> np.ndarray:
        """Whether every control of each case is jammed (n)."""
        return (self.X[:, 2::2] == self.X[:, 3::2]).all(axis=1)

    def take(self, rows: np.ndarray | slice) -> "OffLattice":
        """Some of the cases, by number or mask."""
        return OffLattice(self.X[rows], self.speeds_kt[rows], self.t_min_pct[rows])


def inputs(table: CaseTable) -> np.ndarray:
    """Altitude, gamma and the limits (n, 2 + 2 k) of the controls that vary in a table."""
    varying = [axis.dimensions > 0 for axis in table.axes for _ in axis.columns]
    return table.rows(0, len(table))[:, varying]


def load() -> OffLattice:
    """The test set that comes with the package."""
    with np.load(FILE) as content:
        return OffLattice(inputs(case_table()), content["speeds_kt"].astype(float), content["t_min_pct"].astype(float))


def solve(
    store: Path,
    table: CaseTable,
    progress: Callable[[int, int], None] | None = None,
    workers: int | None = None,
) -> OffLattice:
    """Exact envelopes of a table's cases; a store that was left unfinished is continued.

    Raises:
        InputError: as `distribution.compute`.
    """
    import xarray as xr

    from gtm_fmu.datasets.distribution import compute

    compute(store, table, workers=workers, progress=progress)
    with xr.open_zarr(store, consolidated=False) as data:
        speeds = np.column_stack([data[name].values for name in ("v_min", "v_max")])
        return OffLattice(inputs(table), speeds, data["t_min"].values)


def scores(truth: OffLattice, speeds_kt: np.ndarray, feasible: np.ndarray) -> dict[str, dict[str, Any]]:
    """Errors of predicted speeds (n, 2) kn and verdicts (n), of restrictions, jams and both.

    Speeds are compared where both find an envelope; parts in which that never happens are left out. The mean square is
    of speeds scaled to 0..1 by the range of the exact ones; the percentiles are of V_min and V_max together.

    Raises:
        InputError: predictions of another number of cases, or none with an envelope where there is one.
    """
    if speeds_kt.shape != truth.speeds_kt.shape or feasible.shape != truth.feasible.shape:
        raise InputError(f"{len(speeds_kt)} predictions were given for {len(truth.X)} cases; give one for each.")
    compared = truth.feasible & feasible & np.isfinite(speeds_kt).all(axis=1)
    if not compared.any():
        raise InputError("No prediction finds an envelope where there is one; there is nothing to compare.")
    masks = (~truth.jammed, truth.jammed, np.ones(len(truth.X), dtype=bool))
    return {
        name: _scores(truth, part, compared & part, speeds_kt, feasible)
        for name, part in zip(PARTS, masks, strict=True)
        if (compared & part).any()
    }


def measured(surrogate: Surrogate, truth: OffLattice) -> dict[str, Any]:
    """Scores of a surrogate, how many errors lie inside 95 % intervals, and what its warnings of folds are worth.

    The percentiles of ``errors_kt`` are of V_min and V_max together, of cases with and without such a warning.
    """
    found = surrogate.predict(truth.X)
    speeds = np.column_stack([found.v_min_kt, found.v_max_kt])
    known = truth.feasible & found.feasible
    fold = getattr(found, "fold", np.zeros(len(known), dtype=bool))
    error = np.abs(speeds - truth.speeds_kt)[known]
    inside = error < DEVIATIONS * np.column_stack([found.v_min_std_kt, found.v_max_std_kt])[known]
    largest = error.max(axis=1)
    worst = np.argsort(-largest)[:20]
    flagged = fold[known]
    by_fold = {"without_fold": error[~flagged], "with_fold": error[flagged]}
    return scores(truth, speeds, found.feasible) | {
        "errors_kt": {part: _percentiles(errors) for part, errors in by_fold.items() if errors.size},
        "inside_95": float(inside.mean()),
        "folds": int(fold.sum()),
        "largest_without_fold_kt": float(largest[~fold[known]].max()),
        "wrong_verdicts_flagged": int((fold & (found.feasible != truth.feasible)).sum()),
        "worst_20_inside_95_or_fold": int((fold[known] | inside.all(axis=1))[worst].sum()),
    }


def _percentiles(errors: np.ndarray) -> dict[str, float]:
    return dict(zip(map(str, PERCENTILES), np.percentile(errors, PERCENTILES).tolist(), strict=True))


def _scores(
    truth: OffLattice, part: np.ndarray, compared: np.ndarray, speeds_kt: np.ndarray, feasible: np.ndarray
) -> dict[str, Any]:
    scale = np.ptp(truth.speeds_kt[truth.feasible], axis=0)
    error = np.abs(speeds_kt - truth.speeds_kt)[compared]
    median, high, very_high = np.percentile(error, (50, 95, 99)).tolist()
    return {
        "cases": int(part.sum()),
        "compared": int(compared.sum()),
        "mse": float(np.mean((error / scale) ** 2)),
        "median_kt": median,
        "percentile_95_kt": high,
        "percentile_99_kt": very_high,
        "largest_kt": float(error.max()),
        "wrong_verdicts": int((feasible != truth.feasible)[part].sum()),
        "same_verdict": float((feasible == truth.feasible)[part].mean()),
    }
