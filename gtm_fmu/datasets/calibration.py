"""Safe speeds of a thrust map: exact random cases that set its margins, and others that check them.

The cases are drawn at random from all that a map holds: altitude, flight path and limits of its control, half of them
jams. Some groups are rare, as those at folds, so the first cases of each group are taken from many draws: they are as
random as their group. Where the map promises nothing, nothing has to be solved.
"""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from gtm_fmu.aircraft.inputs import CONDITION, limit_columns
from gtm_fmu.aircraft.ranges import WIDEST
from gtm_fmu.conformal import EPSILON
from gtm_fmu.core.map_layout import GROUPS, SAFE_ENDS
from gtm_fmu.datasets.axes import limits_span, span
from gtm_fmu.datasets.cases import CaseTable, GivenCases, Sampling
from gtm_fmu.envelopes.safe_margins import SafeMargins
from gtm_fmu.envelopes.thrust_map import ThrustMap

SEED, TEST_SEED = 11, 13
"""Of the cases that set the margins, and of those that check them."""
JAM_SHARE = 0.5
SAFE = "safe"
"""Key of a map's provenance: what it was calibrated on, and what the check gave."""
_BLOCK = 50_000


def draw(thrust_map: ThrustMap, cases: int, draws: int, seed: int) -> np.ndarray:
    """Random cases (n, 4) of a map: of each group the first ``cases`` among so many draws."""
    control = thrust_map.control
    lowest, highest = thrust_map.gamma_deg[[0, -1]].tolist()
    axes = (
        span("altitude", *thrust_map.altitude_ft),
        span("gamma", lowest, highest),
        limits_span(control, *WIDEST[f"{control}_deg"], JAM_SHARE),
    )
    table = CaseTable.sampled(axes, Sampling.RANDOM, draws, seed)
    varying = [axis.dimensions > 0 for axis in table.axes for _ in axis.columns]
    kept, left = [np.empty((0, sum(varying)))], np.full(len(GROUPS), cases)
    for start in range(0, draws, _BLOCK):
        rows = table.rows(start, start + _BLOCK)[:, varying]
        group = thrust_map.groups(rows)
        taken = np.zeros(len(rows), dtype=bool)
        for number in range(len(GROUPS)):
            taken[np.flatnonzero(group == number)[: left[number]]] = True
        left -= np.bincount(group[taken], minlength=len(GROUPS))
        kept.append(rows[taken])
        if not left.any():
            break
    return np.concatenate(kept)


def solve(
    store: Path,
    control: str,
    X: np.ndarray,
    progress: Callable[[int, int], None] | None = None,
    workers: int | None = None,
) -> np.ndarray:
    """Exact V_min and V_max (n, 2) in kn of cases X (n, 4), NaN without an envelope; an unfinished store is continued.

    Raises:
        InputError: as `distribution.compute`.
    """
    import xarray as xr

    from gtm_fmu.datasets.distribution import compute

    compute(store, GivenCases((*CONDITION, *limit_columns(control)), X), workers=workers, progress=progress)
    with xr.open_zarr(store, consolidated=False) as data:
        return np.column_stack([data[name].values for name in SAFE_ENDS])


def scores(thrust_map: ThrustMap, X: np.ndarray, exact_kt: np.ndarray) -> np.ndarray:
    """How far V_min and V_max of cases X (n, 4) err on the unsafe side, in standard deviations (n, 2).

    Infinite where there is no envelope; NaN where the map finds none and so claims nothing.
    """
    found = thrust_map.predict(X)
    std = np.column_stack([found.v_min_std_kt, found.v_max_std_kt])
    error = np.column_stack([exact_kt[:, 0] - found.v_min_kt, found.v_max_kt - exact_kt[:, 1]])
    unsafe = np.where(np.isfinite(exact_kt), error / std, np.inf)
    return np.where(found.feasible[:, None], unsafe, np.nan)


def calibrated(thrust_map: ThrustMap, X: np.ndarray, exact_kt: np.ndarray, **facts: Any) -> ThrustMap:
    """A map with the margins of exact cases: X (n, 4) of `draw`, their V_min and V_max (n, 2); facts on them."""
    group = thrust_map.groups(X)
    promised = group >= 0
    safe = SafeMargins.of_scores(scores(thrust_map, X, exact_kt)[promised], group[promised])
    known = {
        "altitude_ft": list(thrust_map.altitude_ft),
        "gamma_deg": thrust_map.gamma_deg[[0, -1]].tolist(),
        "jam_share": JAM_SHARE,
        "cases": dict(zip(GROUPS, safe.cases.tolist(), strict=True)),
    }
    return replace(thrust_map, safe=safe, provenance=thrust_map.provenance | {SAFE: known | facts})


def check(
    thrust_map: ThrustMap, X: np.ndarray, exact_kt: np.ndarray, epsilon: float = EPSILON
) -> dict[str, dict[str, Any]]:
    """What came of the promises in other exact cases X (n, 4) with V_min and V_max (n, 2), by group of `GROUPS`.

    Of each group: cases with safe speeds, how many of these broke the promise of V_min or of V_max (as none has an
    envelope that breaks both), and by how much the safe speeds lie inside the exact ones in the mean, in kn.
    """
    found, group = thrust_map.predict(X, epsilon), thrust_map.groups(X)
    safe = np.column_stack([found.v_min_safe_kt, found.v_max_safe_kt])
    inside = (safe - exact_kt) * (1, -1)
    results = {}
    for number, name in enumerate(GROUPS):
        mine = (group == number) & found.feasible_safe
        exists = mine & np.isfinite(exact_kt).all(axis=1)
        broken = ~(inside[mine] >= 0)
        results[name] = {
            "cases": int((group == number).sum()),
            "safe": int(mine.sum()),
            "no_envelope": int(mine.sum() - exists.sum()),
            **{f"broken_{end}": int(count) for end, count in zip(SAFE_ENDS, broken.sum(axis=0), strict=True)},
            **{
                f"price_{end}_kt": float(price) if exists.any() else None
                for end, price in zip(SAFE_ENDS, inside[exists].mean(axis=0) if exists.any() else (0, 0), strict=True)
            },
        }
    return results
