"""One trim over FMU evaluations: the paper's constrained problem (eqs 21-29), solved by IPOPT through CasADi.

The unknowns y and their bounds are those of the batch solver (`names.TRIM_UNKNOWNS`; equal bounds hold an unknown).
Theta and the body rates follow from them in closed form (eqs 22-28), the accelerations F from the FMU:

    min beta^2   subject to   F(y) = 0,  lower <= y <= upper.

Slopes of F are the FMU's own directional derivatives where it has them (the native FMUs do), first-order differences
otherwise.

With a jammed rudder the trim is unique; among the family that a movable one leaves, sideslip chooses, as in
`trims.steady`. If no trim lies inside the bounds, the answer is a point where the paper's cost (Q = 1) is small:

    min J = 1/2 F.F   subject to   lower <= y <= upper,

its local minimum from a first guess, or where IPOPT stops at a kink of the tables on the way (most often in the stall).
There `steady.trim` goes on to the trim that exceeds the bounds least. An FMU cannot be asked for it, because it holds
commands inside the range of its controls.

In a glide without net thrust the throttle has no effect on the forces, and only sideslip makes more drag: the trims
there are not smooth in y, have several local solutions, and the one found need not have the least sideslip of all.
"""

from collections.abc import Sequence
from functools import partial
from typing import Any, TypeVar, Unpack

import casadi as ca
import numpy as np

from gtm_fmu.aircraft import ranges
from gtm_fmu.aircraft.evaluation import (
    ACCELERATIONS,
    ALTITUDE,
    LINEAR_ROWS,
    DerivativeEvaluator,
    FmuAirframe,
    FmuFunction,
)
from gtm_fmu.aircraft.failures import Failure
from gtm_fmu.aircraft.limits import ControlLimits
from gtm_fmu.aircraft.ranges import ALPHA_DEG, PHI_DEG, Range
from gtm_fmu.airframe.atmosphere import GRAVITY, atmosphere
from gtm_fmu.airframe.names import (
    AILERON,
    ALPHA,
    BETA,
    CONTROLS,
    ELEVATOR,
    LINEAR_STATES,
    PHI,
    PSI_DOT,
    RUDDER,
    STATES,
    THROTTLE,
    TRIM_UNKNOWNS,
    V,
)
from gtm_fmu.airframe.steady_manoeuvre import steady_manoeuvre
from gtm_fmu.core import solver
from gtm_fmu.errors import InputError
from gtm_fmu.interrupt import held_interrupt
from gtm_fmu.trims import manoeuvre
from gtm_fmu.trims.conditions import Asked, conditions
from gtm_fmu.trims.manoeuvre import CONVERGED_RESIDUAL, Trim
from gtm_fmu.units import RAD_PER_DEG

NT = len(TRIM_UNKNOWNS)
INSIDE = 1e-9  # in scale units: rounding, not a violation
NEAR = 1e-3  # in scale units: what IPOPT leaves this close to a bound, or to beta = 0, may be held there
CLOSE = 1e-2  # ft/s^2, rad/s^2: residual from which the polish starts
POLISHED = 1e-13  # ft/s^2, rad/s^2: rounding
MOST_NEWTON_STEPS = 8
GLIDE_RUDDERS_DEG = (-10.0, 10.0)
IPOPT = {
    "print_level": 0,
    "sb": "yes",
    "max_iter": 60,
    "tol": 1e-7,
    "bound_relax_factor": 0.0,  # the FMU holds commands at the ends of their ranges
}


class FmuTrimmer:
    """Trims over one evaluator of derivatives; the optimisation problem is built once and used again.

    The FMU's own ``limits.*`` must be as wide as the limits that are asked for.
    """

    def __init__(self, evaluator: DerivativeEvaluator):
        """Build the problem; its parameters are altitude, gamma and the weights of beta^2 and J."""
        self._airframe = FmuAirframe(evaluator)
        self._scale = solver.scale()
        self._known = _known_values()
        sizes = len(LINEAR_STATES) + len(CONTROLS) + 1, ACCELERATIONS
        self._accelerations = FmuFunction("accelerations", sizes, self._known_accelerations, self._known_slopes)
        y, misses, parameters = ca.MX.sym("y", NT), ca.MX.sym("misses", ACCELERATIONS), ca.MX.sym("parameters", 4)
        altitude, gamma = parameters[0], parameters[1]
        F = self._accelerations(ca.vertcat(self._known(y * self._scale, gamma)[0], altitude))
        problem = {
            "x": ca.vertcat(y, misses),
            "p": parameters,
            "f": _objective(y, misses, parameters),
            "g": F - misses,
        }
        options: dict[str, Any] = {
            "ipopt": IPOPT,
            "hess_lag": _curvature(),
            "print_time": False,
            "show_eval_warnings": False,
        }
        self._solver = ca.nlpsol("trim", "ipopt", problem, options | {"calc_lam_p": False})

    def trim(
        self,
        altitude_ft: float,
        tas_kt: float | None = None,
        gamma_deg: float = 0.0,
        turn_rate_deg_s: float | None = None,
        limits: ControlLimits | None = None,
        alpha_deg: Range = ALPHA_DEG,
        phi_deg: Range = PHI_DEG,
        warm_start: Trim | None = None,
        **asked: Unpack[Asked],
    ) -> Trim:
        """The trim that meets what is asked inside the limits, or the least cost J inside them.

        Args:
            altitude_ft: geometric altitude in ft.
            tas_kt: true airspeed in kn; None where another speed or an angle of attack is asked for.
            gamma_deg: flight-path angle in deg, positive in a climb.
            turn_rate_deg_s: turn rate in deg/s, positive to the right; None leaves it to the other conditions, or to
                straight flight.
            limits: what the failure leaves of the controls; None: nothing has failed.
            alpha_deg: least and greatest angle of attack in deg.
            phi_deg: least and greatest bank in deg.
            warm_start: a trim to start from, for instance of a neighbouring condition.
            asked: further conditions by name as of `steady.trim`, but for the load factor.

        Raises:
            InputError: altitude, speed, flight path, bounds or conditions outside what is allowed, or a load factor.
            FmuError: the FMU refuses an evaluation.
        """
        altitude_ft = ranges.check_range("altitude in ft", altitude_ft, ranges.ALTITUDE_FT)
        if asked.get("load_factor") is not None:
            raise InputError("A trim over an FMU takes no load factor; give a bank or a turn rate, or trim the core.")
        failure = Failure.of(limits)
        wanted = conditions(altitude_ft, failure, alpha_deg, phi_deg, tas_kt, turn_rate_deg_s, asked)
        lower, upper = wanted.bounds(failure, alpha_deg, phi_deg)
        return self.trim_within(altitude_ft, gamma_deg, lower, upper, warm_start)

    def trim_within(
        self, altitude_ft: float, gamma_deg: float, lower: np.ndarray, upper: np.ndarray, warm_start: Trim | None = None
    ) -> Trim:
        """The same with bounds (9) of the unknowns in the core's units; they may hold others (alpha, not V, say).

        The limits that the trim carries are the bounds of its controls.

        Args:
            altitude_ft: geometric altitude in ft.
            gamma_deg: flight-path angle in deg, positive in a climb.
            lower: bounds (9), ft/s, rad, rad/s, deg and %.
            upper: the same.
            warm_start: a trim to start from.
        """
        altitude_ft = ranges.check_range("altitude in ft", altitude_ft, ranges.ALTITUDE_FT)
        gamma_deg = ranges.check_range("gamma in deg", gamma_deg, ranges.GAMMA_DEG)
        at = altitude_ft, gamma_deg * RAD_PER_DEG
        starts = [] if warm_start is None else [np.clip(warm_start.unknowns, lower, upper)]
        with held_interrupt():
            y = self._solve(at, lower, upper, starts)
            residual = np.abs(self._residuals(y, at)).max()
        inside = self._is_inside(y, lower, upper)
        hit = manoeuvre.limits_hit(y, lower, upper)
        return Trim.of_unknowns(
            y, altitude_ft, gamma_deg, inside, hit, ControlLimits(*np.column_stack([lower, upper])[ELEVATOR:]), residual
        )

    def _solve(
        self, at: tuple[float, float], lower: np.ndarray, upper: np.ndarray, starts: Sequence[np.ndarray]
    ) -> np.ndarray:
        """Least sideslip if a trim is found from ``starts`` or a first guess, else least cost."""
        is_trim = partial(self._is_trim, at=at, lower=lower, upper=upper)
        for start in [*starts, _first_guess(lower, upper)]:
            y = self._least_sideslip(start, at, lower, upper)
            if is_trim(y):
                if self._is_settled(y, lower, upper):
                    return y
                break
        else:
            y = self._least(start, at, lower, upper, weights=(0.0, 1.0), most_miss=np.inf)
        others: list[np.ndarray] = []
        if is_trim(y):
            others += [self._pinned(BETA, 0.0, y, at, lower, upper), self._least_sideslip(y, at, lower, upper)]
        if y[THROTTLE] < upper[THROTTLE]:
            glides = (_first_guess(lower, upper, rudder_deg) for rudder_deg in GLIDE_RUDDERS_DEG)
            others += [self._pinned(THROTTLE, lower[THROTTLE], start, at, lower, upper) for start in glides]
        return min([y, *filter(is_trim, others)], key=lambda y: (not is_trim(y), abs(y[BETA])))

    def _least_sideslip(
        self, start: np.ndarray, at: tuple[float, float], lower: np.ndarray, upper: np.ndarray
    ) -> np.ndarray:
        if np.sum(lower < upper) < ACCELERATIONS:  # IPOPT takes no more equations than unknowns
            return start
        return self._least(start, at, lower, upper, weights=(1.0, 0.0), most_miss=0.0)

    def _is_settled(self, y: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> bool:
        """Whether the least sideslip just found needs no second look, as one held by stall or idle does."""
        if np.sum(lower < upper) <= ACCELERATIONS or y[BETA] == 0:
            return True
        is_free = y[ALPHA] < upper[ALPHA] and y[THROTTLE] > lower[THROTTLE]
        return is_free and self._solver.stats()["return_status"] == "Solve_Succeeded"

    def _pinned(
        self,
        unknown: int,
        value: float,
        start: np.ndarray,
        at: tuple[float, float],
        lower: np.ndarray,
        upper: np.ndarray,
    ) -> np.ndarray:
        """Least sideslip with one unknown held."""
        is_pinned = np.arange(NT) == unknown
        bounds = np.where(is_pinned, value, lower), np.where(is_pinned, value, upper)
        return self._least_sideslip(np.clip(start, *bounds), at, *bounds)

    def _least(
        self,
        start: np.ndarray,
        at: tuple[float, float],
        lower: np.ndarray,
        upper: np.ndarray,
        weights: tuple[float, float],
        most_miss: float,
    ) -> np.ndarray:
        """Unknowns where the weighted objective is least while no acceleration is above ``most_miss``."""
        misses = np.full(ACCELERATIONS, most_miss)
        found = self._solver(
            x0=np.append(start / self._scale, np.clip(self._residuals(start, at), -misses, misses)),
            p=[*at, *weights],
            lbx=np.append(lower / self._scale, -misses),
            ubx=np.append(upper / self._scale, misses),
            lbg=0,
            ubg=0,
        )
        y, price = (found[name].full()[:NT, 0] for name in ("x", "lam_x"))
        # An interior point stops a little short of the bounds that hold it, which are those with a price.
        below, above = y - lower / self._scale, upper / self._scale - y
        is_lower, is_upper = (-price > below) & (below < NEAR), (price > above) & (above < NEAR)
        y = np.select([is_upper, is_lower], [upper, lower], y * self._scale)
        return self._polished(y, at, lower, upper)

    def _polished(self, y: np.ndarray, at: tuple[float, float], lower: np.ndarray, upper: np.ndarray) -> np.ndarray:
        """Newton from a nearly converged point, with as many unknowns held as the trim has freedoms."""
        y, movable = y.copy(), lower < upper
        freedoms = max(int(np.sum(movable)) - ACCELERATIONS, 0)
        at_bounds = np.flatnonzero(movable & ((y == lower) | (y == upper)))[:freedoms]
        movable[at_bounds] = False
        if len(at_bounds) < freedoms and abs(y[BETA]) < NEAR * self._scale[BETA]:
            y[BETA], movable[BETA] = 0.0, False
        for _ in range(MOST_NEWTON_STEPS):
            F, slopes = self._slopes(y, at)
            if not POLISHED < np.abs(F).max() < CLOSE:
                break
            y[movable] -= self._scale[movable] * np.linalg.lstsq(slopes[:, movable] * self._scale[movable], F)[0]
        return y

    def _known_accelerations(self, known: np.ndarray) -> np.ndarray:
        """Accelerations F (6) of linear states, controls and altitude (13)."""
        return self._airframe.derivatives(*_state_and_controls(known))[:ACCELERATIONS]

    def _known_slopes(self, known: np.ndarray) -> np.ndarray:
        """Their slopes (6, 13); that in the altitude, a constant of a trim, is left at zero."""
        slopes = self._airframe.slopes(*_state_and_controls(known))[1][:ACCELERATIONS]
        return np.column_stack([slopes, np.zeros(ACCELERATIONS)])

    def _residuals(self, y: np.ndarray, at: tuple[float, float]) -> np.ndarray:
        """Accelerations F (6)."""
        altitude, gamma = at
        return self._known_accelerations(np.append(self._known(y, gamma)[0].full()[:, 0], altitude))

    def _slopes(self, y: np.ndarray, at: tuple[float, float]) -> tuple[np.ndarray, np.ndarray]:
        """Accelerations F (6) and their slopes (6, 9)."""
        altitude, gamma = at
        known, known_slopes = (value.full() for value in self._known(y, gamma))
        dx, slopes = self._airframe.slopes(*_state_and_controls(np.append(known[:, 0], altitude)))
        return dx[:ACCELERATIONS], slopes[:ACCELERATIONS] @ known_slopes

    def _is_trim(self, y: np.ndarray, at: tuple[float, float], lower: np.ndarray, upper: np.ndarray) -> bool:
        return self._is_inside(y, lower, upper) and np.abs(self._residuals(y, at)).max() <= CONVERGED_RESIDUAL

    def _is_inside(self, y: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> bool:
        slack = INSIDE * self._scale
        return bool(np.all((lower - slack <= y) & (y <= upper + slack)))


def _state_and_controls(known: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """State x (12) and controls u (4) of linear states, controls and altitude (13)."""
    x = np.zeros(len(STATES))
    x[LINEAR_ROWS], x[ALTITUDE] = known[: len(LINEAR_STATES)], known[-1]
    return x, known[len(LINEAR_STATES) : -1]


def _known_values() -> ca.Function:
    """Linear states and controls (12) of unknowns y (9) at gamma, and their slopes (12, 9) (paper eqs 22-28)."""
    y, gamma = ca.SX.sym("y", NT), ca.SX.sym("gamma")
    steady = steady_manoeuvre(y, gamma, atmosphere(0))  # the air does not enter
    known = ca.vertcat(steady.velocity, steady.rates, y[PHI], steady.theta, y[ELEVATOR:])
    return ca.Function("known_values", [y, gamma], [known, ca.jacobian(known, y)])


Symbols = TypeVar("Symbols", ca.SX, ca.MX)


def _objective(y: Symbols, misses: Symbols, parameters: Symbols) -> Symbols:
    """Weighted sum of beta^2, in scale units, and the cost J."""
    return parameters[2] * y[BETA] ** 2 + parameters[3] * ca.sumsqr(misses) / 2


def _curvature() -> ca.Function:
    """Hessian of the Lagrangian without the curvature of F.

    That does not matter at a trim, where the multipliers of F vanish (beta = 0) or the bounds leave no freedom; for J
    this is the Gauss-Newton method.
    """
    y, misses, parameters = ca.SX.sym("y", NT), ca.SX.sym("misses", ACCELERATIONS), ca.SX.sym("parameters", 4)
    weight, multipliers = ca.SX.sym("weight"), ca.SX.sym("multipliers", ACCELERATIONS)
    x = ca.vertcat(y, misses)
    hessian = ca.hessian(weight * _objective(y, misses, parameters), x)[0]
    names = ["x", "p", "lam_f", "lam_g"], ["triu_hess_gamma_x_x"]
    return ca.Function("curvature", [x, parameters, weight, multipliers], [ca.triu(hessian)], *names)


def _first_guess(lower: np.ndarray, upper: np.ndarray, rudder_deg: float = 0.0) -> np.ndarray:
    """Point inside the bounds to start from, with the rudder as near to ``rudder_deg`` as it gets.

    Sideslip, aileron and bank go with the rudder (SPEC 4, 13). Full throttle, since net thrust sticks at zero at a low
    one and then has no slope.
    """
    y = (lower + upper) / 2
    y[ELEVATOR], y[THROTTLE] = 0.0, upper[THROTTLE]
    y[ALPHA] = 4 * RAD_PER_DEG
    y[RUDDER] = np.clip(rudder_deg, lower[RUDDER], upper[RUDDER])
    y[BETA], y[AILERON] = 0.7 * y[RUDDER] * RAD_PER_DEG, -0.6 * y[RUDDER]
    y[PHI] = np.arctan(y[V] * y[PSI_DOT] / GRAVITY) + y[BETA]
    return np.clip(y, lower, upper)
