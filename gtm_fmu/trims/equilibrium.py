"""An equilibrium of any FMU that shows its states and derivatives: the trim of a system that need not be an aircraft.

Of the states and inputs some are free inside bounds; the others are held. Of all points where the chosen derivatives F
vanish, the one nearest to the start is taken:

    min 1/2 |z - z_start|^2   subject to   F(z) = 0,  lower <= z <= upper,

with z in units of the variables' nominal values. Slopes are the FMU's directional derivatives, or differences.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np
from scipy.optimize import least_squares

from gtm_fmu.aircraft.client import FmuClient
from gtm_fmu.aircraft.evaluation import FmuFunction, FmuSystem
from gtm_fmu.errors import InputError

Range = tuple[float, float]
FOUND_RESIDUAL = 1e-9
"""Largest chosen derivative of an equilibrium, in units of its nominal value a second."""

_IPOPT = {"print_level": 0, "sb": "yes", "tol": 1e-11, "max_iter": 200, "bound_relax_factor": 0.0}


@dataclass(frozen=True)
class Equilibrium:
    """An equilibrium, or the nearest to one that was found.

    Attributes:
        found: every chosen derivative is zero (``residual`` <= `FOUND_RESIDUAL`).
        residual: the largest of them, in units of its nominal value.
        values: of all states and inputs, by name, in the FMU's units.
        derivatives: of all states, by name, in the FMU's units.
    """

    found: bool
    residual: float
    values: dict[str, float]
    derivatives: dict[str, float]


def equilibrium(
    fmu: FmuClient,
    free: Mapping[str, Range],
    held: Mapping[str, float] | None = None,
    steady: Sequence[str] | None = None,
) -> Equilibrium:
    """The equilibrium of an FMU nearest to its present values, in Initialization Mode; the FMU is left there.

    Args:
        fmu: its ``states``, ``derivatives`` and ``controls`` say which variables are which.
        free: lower and upper bound of each state or input that may move, in the units of the FMU; infinite ends are
            allowed.
        held: values of others, in the units of the FMU; those not named stay at their present ones.
        steady: names of the derivatives that vanish; default: all.

    Raises:
        InputError: a name that is no state, input or derivative; reversed bounds, or not two; a variable both free and
            held; nothing free; nothing steady.
        FmuError: the FMU refuses an evaluation.
    """
    names = fmu.states + fmu.controls
    rows = _places("derivative", fmu.derivatives if steady is None else steady, fmu.derivatives)
    columns = _places("state or input", free, names)
    values = fmu.get(names)
    values[_places("state or input", held or {}, names)] = list((held or {}).values())
    for name, ends in free.items():
        if np.shape(ends) != (2,) or name in (held or {}):
            raise InputError(f"'{name}' is free: give it a lower and an upper bound, and do not hold it too.")
    lower, upper = np.array(list(free.values()), dtype=float).reshape(-1, 2).T
    if not (len(rows) and len(columns)) or not np.all(lower <= upper):
        raise InputError("An equilibrium needs a free variable and a steady derivative, and each lower bound first.")

    scale, rate_scale = fmu.nominal(names), fmu.nominal(fmu.derivatives)
    held_at = lower == upper
    values[columns[held_at]] = lower[held_at]
    columns, lower, upper = columns[~held_at], lower[~held_at], upper[~held_at]
    n = len(fmu.states)
    system = FmuSystem(fmu, scale[:n], scale[n:], rate_scale)

    def split(z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        full = values / scale
        full[columns] = z
        return full[:n], full[n:]

    def rates(z: np.ndarray) -> np.ndarray:
        return system.derivatives(*split(z))[rows]

    def slopes(z: np.ndarray) -> np.ndarray:
        return system.slopes(*split(z))[1][np.ix_(rows, columns)]

    bounds = lower / scale[columns], upper / scale[columns]
    z = _nearest(rates, slopes, np.clip(values[columns] / scale[columns], *bounds), bounds)
    residual = float(np.abs(rates(z)).max())
    x, u = split(z)
    dx = system.derivatives(x, u) * rate_scale
    return Equilibrium(
        found=residual <= FOUND_RESIDUAL,
        residual=residual,
        values=dict(zip(names, (np.append(x, u) * scale).tolist(), strict=True)),
        derivatives=dict(zip(fmu.derivatives, dx.tolist(), strict=True)),
    )


def _nearest(
    rates: Callable[[np.ndarray], np.ndarray],
    slopes: Callable[[np.ndarray], np.ndarray],
    start: np.ndarray,
    bounds: tuple[np.ndarray, np.ndarray],
) -> np.ndarray:
    """Point nearest to the start where the rates vanish; where none is found, or too few are free, least squares."""
    n, m = len(start), len(rates(start))
    best = start
    if n >= m:  # IPOPT takes no more equations than unknowns
        function = FmuFunction("rates", (n, m), rates, slopes)
        z = ca.MX.sym("z", n)
        problem = {"x": z, "f": ca.sumsqr(z - start) / 2, "g": function(z)}
        hessian = ca.Function("hessian", *_own_curvature(n, m))
        options: dict[str, Any] = {
            "ipopt": _IPOPT,
            "print_time": False,
            "show_eval_warnings": False,
            "hess_lag": hessian,
        }
        solver = ca.nlpsol("equilibrium", "ipopt", problem, options)
        best = solver(x0=start, lbx=bounds[0], ubx=bounds[1], lbg=0, ubg=0)["x"].full()[:, 0]
        best = np.clip(best, *bounds)
    if n and np.abs(rates(best)).max() > FOUND_RESIDUAL:
        tight = {"xtol": 1e-15, "ftol": 1e-15, "gtol": 1e-15}
        again = least_squares(rates, best, jac=slopes, bounds=bounds, **tight).x
        best = min(best, again, key=lambda z: np.abs(rates(z)).max())
    return best


def _own_curvature(n: int, m: int) -> tuple[list, list, list[str], list[str]]:
    """Arguments of the Lagrangian's Hessian as a function, without the curvature of the rates."""
    z, none, weight, multipliers = ca.SX.sym("z", n), ca.SX.sym("p", 0), ca.SX.sym("w"), ca.SX.sym("lambda", m)
    hessian = ca.diag(ca.repmat(weight, n))
    return [z, none, weight, multipliers], [hessian], ["x", "p", "lam_f", "lam_g"], ["triu_hess_gamma_x_x"]


def _places(kind: str, given: Iterable[str], known: Sequence[str]) -> np.ndarray:
    """Where the names are.

    Raises:
        InputError: a name that is not known.
    """
    for name in given:
        if name not in known:
            raise InputError(f"'{name}' is no {kind} of this FMU: it has {', '.join(known)}.")
    return np.array([known.index(name) for name in given], dtype=int)
