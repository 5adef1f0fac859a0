"""The trim map: envelopes with any limits of all controls at once, by interpolation in one table of trims.

A failure changes nothing of how the aircraft flies; it only forbids some of its steady manoeuvres. At a given altitude
and flight path these form one manifold of three dimensions, with angle of attack, bank and rudder as coordinates: each
point of them has one trim. So the envelopes of all jams and ranges of all controls are those of one table, cut by
different limits. What is tabulated, 1 / EAS^2 (lift over weight), thrust / EAS^2 (drag) and the other deflections,
hardly bends, and at a given EAS hardly depends on the altitude. The core finds the extremes over what the limits leave
of the interpolated manifold exactly: wider limits never shrink an envelope.

`TrimMap.solve` makes a map in a second or two; nothing has to be learnt or kept.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from gtm_fmu.aircraft import ranges
from gtm_fmu.aircraft.limits import ControlLimits
from gtm_fmu.aircraft.ranges import ALPHA_DEG, ALTITUDE_FT, PHI_DEG, WIDEST, Range
from gtm_fmu.airframe.atmosphere import DENSITY_0, atmosphere
from gtm_fmu.airframe.names import AILERON, ALPHA, CONTROLS, ELEVATOR, PHI, PSI_DOT, RUDDER, THROTTLE, V
from gtm_fmu.core import solver, trim_map
from gtm_fmu.core.library import rows
from gtm_fmu.envelopes.envelope import THROTTLE_WITHOUT_LIMIT
from gtm_fmu.envelopes.thrust_survey import gross_thrusts_lbf
from gtm_fmu.errors import InputError
from gtm_fmu.trims import manoeuvre
from gtm_fmu.trims.manoeuvre import CONVERGED_RESIDUAL
from gtm_fmu.units import KT_PER_FT_S, RAD_PER_DEG

SURFACES = CONTROLS[:-1]
_CONTINUED_DEG = 5.0
"""So far beyond what the aileron can hold are the values there continued, for the boxes across its limit."""


class TrimNodes(NamedTuple):
    """Where a map is solved. Breakpoints of the aerodynamic tables in alpha and rudder lie on nodes."""

    altitudes_ft: Sequence[float] = ALTITUDE_FT
    gammas_deg: Sequence[float] = (-5.0, 0.0, 5.0)
    alphas_deg: Sequence[float] = (-1.0, -0.5, 0.0, 0.25, 0.5, 0.75, *np.arange(1.0, ALPHA_DEG[1] + 0.1, 0.5).tolist())
    banks_deg: Sequence[float] = tuple(np.linspace(*PHI_DEG, 7).tolist())
    rudders_deg: Sequence[float] = tuple(np.linspace(*WIDEST["rudder_deg"], 25).tolist())

    @property
    def trims(self) -> int:
        """Number of trims."""
        return int(np.prod([len(axis) for axis in self]))


class TrimMapEnvelopes(NamedTuple):
    """Envelopes (n) by a trim map; without one the speeds are NaN.

    Attributes:
        in_domain: altitude and flight path lie inside the map. Outside it goes on by polynomials.
    """

    v_min_kt: np.ndarray
    v_max_kt: np.ndarray
    feasible: np.ndarray
    in_domain: np.ndarray


@dataclass(frozen=True, eq=False)
class TrimMap:
    """Trims over density ratio, flight path, angle of attack, bank and rudder.

    Attributes:
        nodes: where it was solved.
        axes: density ratios, then gamma, alpha, bank and rudder in deg.
        table: (density, gamma, alpha, bank, rudder, 4) of `trim_map.VALUES`; NaN where there is no trim.
    """

    nodes: TrimNodes
    axes: tuple[np.ndarray, ...]
    table: np.ndarray

    @classmethod
    def solve(cls, nodes: TrimNodes | None = None, progress: Callable[[int, int], None] | None = None) -> "TrimMap":
        """A map of the study's airframe.

        Args:
            nodes: default `TrimNodes`.
            progress: called with the number of finished flight conditions and of all.

        Raises:
            InputError: fewer than two nodes of alpha, bank or rudder, or nodes that do not rise.
        """
        nodes = nodes or TrimNodes()
        grid = [np.ascontiguousarray(axis, dtype=float) for axis in nodes[1:]]
        if min(map(len, grid[1:])) < 2 or any((np.diff(axis) <= 0).any() for axis in grid):
            raise InputError("The nodes of a trim map must rise, and be two or more of alpha, bank and rudder.")
        density = np.array([float(atmosphere(altitude).density) / DENSITY_0 for altitude in nodes.altitudes_ft])
        conditions = [(altitude, gamma) for altitude in nodes.altitudes_ft for gamma in nodes.gammas_deg]
        planes = []
        for altitude, gamma in conditions:
            planes.append(_continued(_trims(altitude, gamma, *grid[1:]), grid[1:]))
            if progress:
                progress(len(planes), len(conditions))
        shape = len(density), len(grid[0]), *planes[0].shape
        return cls(nodes, (density, *grid), np.reshape(planes, shape).astype(np.float32))

    def predict(
        self, cases: ArrayLike, controls: Sequence[str], alpha_deg: Range = ALPHA_DEG, phi_deg: Range = PHI_DEG
    ) -> TrimMapEnvelopes:
        """Envelopes of cases (n, 2 + 2 k): altitude in ft, gamma in deg, lower and upper limit of each of k controls.

        Args:
            cases: elevator, aileron and rudder in deg, throttle in %; equal limits are a jam.
            controls: their names, in the order of the columns; the others are free.
            alpha_deg: bounds of the angle of attack.
            phi_deg: bounds of the bank angle.

        Raises:
            InputError: unknown controls, or cases outside what is allowed or mapped.
        """
        cases = _checked(cases, controls)
        for name, bounds, axis in (("alpha", alpha_deg, self.axes[2]), ("phi", phi_deg, self.axes[3])):
            ranges.check_pair(f"{name} in deg", bounds, (min(bounds[0], axis[0]), axis[-1]))
        given = {name: cases[:, 2 + 2 * k : 4 + 2 * k] for k, name in enumerate(controls)}
        limits = {name: given.get(name, np.array(WIDEST[f"{name}_{_UNIT[name]}"])) for name in CONTROLS}
        thrust = gross_thrusts_lbf(limits.pop("throttle"), 0.0)
        columns = cases[:, :2], np.array(alpha_deg), np.array(phi_deg), *limits.values(), thrust
        asked = [np.broadcast_to(column, (len(cases), 2)) for column in columns]
        speeds = trim_map.envelopes(self.axes, self.table, np.hstack(asked))
        feasible = speeds[:, 0] > 0
        altitude, gamma = cases[:, 0], cases[:, 1]
        inside = (min(self.nodes.altitudes_ft) <= altitude) & (altitude <= max(self.nodes.altitudes_ft))
        inside &= (self.axes[1].min() <= gamma) & (gamma <= self.axes[1].max())
        v_min, v_max = np.where(feasible[:, None], speeds, np.nan).T
        return TrimMapEnvelopes(v_min, v_max, feasible, inside)

    def predict_one(self, altitude_ft: float, gamma_deg: float, limits: ControlLimits) -> dict[str, Any]:
        """The same for one case, by the names of `TrimMapEnvelopes` and ready for JSON: None where there is no speed.

        Args:
            altitude_ft: geometric altitude in ft.
            gamma_deg: flight-path angle in deg, positive in a climb.
            limits: what the failure leaves of the controls.

        Raises:
            InputError: as `predict`.
        """
        ends = [getattr(limits, f"{name}_{_UNIT[name]}") for name in CONTROLS]
        found = self.predict([[altitude_ft, gamma_deg, *(end for pair in ends for end in pair)]], CONTROLS)
        values = {name: column[0].item() for name, column in found._asdict().items()}
        return {name: None if value != value else value for name, value in values.items()}


_UNIT = {name.rsplit("_", 1)[0]: name.rsplit("_", 1)[1] for name in WIDEST}


def _checked(cases: ArrayLike, controls: Sequence[str]) -> np.ndarray:
    unknown = [name for name in controls if name not in CONTROLS]
    if unknown or len(set(controls)) < len(controls):
        raise InputError(f"Controls {', '.join(controls)} were given; give some of {', '.join(CONTROLS)}, each once.")
    try:
        cases = rows(cases, 2 + 2 * len(controls), "cases")
    except ValueError:
        raise InputError("Give cases as rows of altitude, gamma, and lower and upper limit of each control.") from None
    ranges.check_values("altitude in ft", cases[:, 0], ranges.ALTITUDE_FT)
    ranges.check_values("gamma in deg", cases[:, 1], ranges.GAMMA_DEG)
    for k, name in enumerate(controls):
        lower, upper = cases[:, 2 + 2 * k], cases[:, 3 + 2 * k]
        for limits in (lower, upper):
            ranges.check_values(f"{name} in {_UNIT[name]}", limits, WIDEST[f"{name}_{_UNIT[name]}"])
        if (lower > upper).any():
            raise InputError(f"{name}: limits are reversed; give the lower one first.")
    return cases


def _trims(altitude_ft: float, gamma_deg: float, alpha: np.ndarray, bank: np.ndarray, rudder: np.ndarray) -> np.ndarray:
    """`trim_map.VALUES` (alpha, bank, rudder, 4) at a flight condition, NaN where the aileron cannot hold the trim."""
    grid = np.meshgrid(alpha * RAD_PER_DEG, bank * RAD_PER_DEG, rudder, indexing="ij")
    lower, upper = (np.tile(bound, (grid[0].size, 1)) for bound in manoeuvre.bounds(ControlLimits()))
    widest = {V: np.inf, PSI_DOT: np.inf, ELEVATOR: np.inf, AILERON: np.inf, THROTTLE: THROTTLE_WITHOUT_LIMIT}
    ailerons = lower[0, AILERON], upper[0, AILERON]
    for unknown, widened in widest.items():
        lower[:, unknown], upper[:, unknown] = -widened, widened
    for unknown, held in zip((ALPHA, PHI, RUDDER), grid, strict=True):
        lower[:, unknown] = upper[:, unknown] = held.ravel()
    at = np.full(len(lower), altitude_ft), np.full(len(lower), gamma_deg * RAD_PER_DEG)
    found = solver.trims(*at, lower, upper)
    y = found.y
    eas = y[:, V] * KT_PER_FT_S * float(atmosphere(altitude_ft).sqrt_density_ratio)
    gross = gross_thrusts_lbf(y[:, THROTTLE], altitude_ft)
    with np.errstate(all="ignore"):
        values = np.column_stack([1 / eas**2, gross / eas**2, y[:, ELEVATOR], y[:, AILERON]])
    is_held = (ailerons[0] <= y[:, AILERON]) & (y[:, AILERON] <= ailerons[1])
    values[~is_held | (found.residual > CONVERGED_RESIDUAL)] = np.nan
    return values.reshape(*grid[0].shape, len(trim_map.VALUES))


def _continued(values: np.ndarray, axes: Sequence[np.ndarray]) -> np.ndarray:
    """Values (alpha, bank, rudder, 4) with some of the missing ones continued straight from neighbours.

    The aileron runs away where it cannot hold a trim, so its limit would be found wrong in a box that has such a node.
    Towards small alpha nothing is continued: there the speed runs away.
    """
    rudder = axes[-1]
    for _ in range(math.ceil(_CONTINUED_DEG / np.diff(rudder).max())):
        estimates = []
        for axis, nodes in enumerate(axes):
            along = np.moveaxis(values, axis, 0)
            for way in (1,) if axis == 0 else (1, -1):
                v, x = along[::way], nodes[::way].reshape(-1, 1, 1, 1)
                share = (x[2:] - x[1:-1]) / (x[1:-1] - x[:-2])
                estimate = np.full_like(v, np.nan)
                estimate[2:] = v[1:-1] + share * (v[1:-1] - v[:-2])
                estimates.append(np.moveaxis(estimate[::way], 0, axis))
        known = np.isfinite(estimates)
        mean = np.where(known, estimates, 0.0).sum(axis=0) / np.maximum(known.sum(axis=0), 1)
        values = np.where(np.isnan(values) & known.any(axis=0), mean, values)
    return values
