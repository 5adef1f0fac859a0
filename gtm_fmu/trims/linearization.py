"""Linear models at a trim: exact, or over an FMU; stability and controllability.

States u v w p q r phi theta in ft/s, rad/s, rad; inputs elevator, aileron, rudder in deg, throttle in %, without the
jammed ones. At a breakpoint of the aerodynamic tables slopes have two sides: A and B are those above it, the verdicts
those of all sides together, with each side's own beside them (`breakpoints`).

A trim is stable if no eigenvalue of A has a positive real part (paper, section III-B). An unstable one is controllable
if every unstable mode is (Popov, Belevitch, Hautus): the smallest singular value of [lambda I - A, B], with states and
inputs in units of `STATE_SCALE` and `INPUT_SCALE`, is at least `PBH_THRESHOLD`. The rank of the paper's matrix
[B AB .. A^7 B] (eq. 35) is given beside it; powers of A spread its columns over many orders of magnitude, so that its
condition reaches 3e10 and its numerical rank depends on the tolerance more than on the aircraft.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from gtm_fmu.aircraft.failures import Failure
from gtm_fmu.aircraft.limits import ControlLimits
from gtm_fmu.airframe import linear_scales
from gtm_fmu.airframe.names import CONTROLS, LINEAR_STATES, STATES
from gtm_fmu.core import configuration as configured
from gtm_fmu.core import motion
from gtm_fmu.core.configuration import Configuration
from gtm_fmu.errors import InputError
from gtm_fmu.trims.breakpoints import ABOVE, BELOW, DIFFERENCES, EXACT, Breakpoint, Reach, breakpoints, on_each_side
from gtm_fmu.trims.manoeuvre import Trim
from gtm_fmu.units import RAD_PER_DEG

if TYPE_CHECKING:
    import control

    from gtm_fmu.aircraft.evaluation import FmuAirframe

STATE_SCALE, INPUT_SCALE = np.array(linear_scales.STATE_SCALE), np.array(linear_scales.INPUT_SCALE)
PBH_THRESHOLD = linear_scales.PBH_THRESHOLD
LONGITUDINAL = ("u", "w", "q", "theta")

Slopes = Callable[[np.ndarray, np.ndarray], np.ndarray]

_ROWS = np.array([STATES.index(name) for name in LINEAR_STATES])


class Mode(NamedTuple):
    """An oscillation or, with zero frequency, an exponential: undamped frequency in Hz and damping ratio."""

    frequency_hz: float
    damping: float


class Sides(NamedTuple):
    """What a trim is below and above a breakpoint that it lies on, and above all others as A is.

    Attributes:
        name: the breakpoint, as ``beta_deg = 0``.
        stable: below and above.
        growth_per_s: the largest real part of an eigenvalue, below and above.
    """

    name: str
    stable: tuple[bool, bool]
    growth_per_s: tuple[float, float]


@dataclass(frozen=True)
class LinearModel:
    """Linear model x' = A x + B u about a trim.

    Attributes:
        A, B, eigenvalues: above the breakpoints that the trim lies on.
        stable, controllable: on every combination of sides of these breakpoints.
        sides: the verdicts on the two sides of each breakpoint; empty if the trim lies on none.
        smallest_singular_value: of the scaled PBH matrices of the unstable modes; None if the trim is stable.
        kalman_rank, kalman_condition: of the paper's controllability matrix (eq. 35), unscaled, for comparison only;
            without inputs 0 and None.
    """

    states: tuple[str, ...]
    inputs: tuple[str, ...]
    A: np.ndarray
    B: np.ndarray
    eigenvalues: np.ndarray
    stable: bool
    controllable: bool
    sides: tuple[Sides, ...]
    smallest_singular_value: float | None
    kalman_rank: int
    kalman_condition: float | None

    @classmethod
    def of_slopes(cls, slopes: np.ndarray, inputs: tuple[str, ...], found: Sequence[Breakpoint] = ()) -> "LinearModel":
        """The model of ``slopes`` [A B] (8, 8 + m) with these ``inputs``, at a trim on the breakpoints ``found``."""
        margin, stable, growths = np.inf, True, np.empty((len(found), 2))
        for _, sides, there in on_each_side(np.asarray(slopes)[None], found):
            of_sides = verdict(there, inputs)
            margin, stable = min(margin, float(of_sides.margin[0])), stable and bool(of_sides.stable[0])
            below = [number for number, side in sides.items() if side == BELOW]
            if len(below) <= 1:
                growths[below or slice(None), ABOVE - len(below)] = of_sides.eigenvalues.real.max()
        A, B = np.hsplit(there[0], [len(LINEAR_STATES)])
        kalman = np.hstack([np.linalg.matrix_power(A, k) @ B for k in range(len(A))])
        return cls(
            states=LINEAR_STATES,
            inputs=inputs,
            A=A,
            B=B,
            eigenvalues=of_sides.eigenvalues[0],
            stable=stable,
            controllable=margin >= PBH_THRESHOLD,
            sides=tuple(
                Sides(str(breakpoint), (below <= 0, above <= 0), (below, above))
                for breakpoint, (below, above) in zip(found, growths.tolist(), strict=True)
            ),
            smallest_singular_value=margin if np.isfinite(margin) else None,
            kalman_rank=int(np.linalg.matrix_rank(kalman)) if inputs else 0,
            kalman_condition=float(np.linalg.cond(kalman)) if inputs else None,
        )

    def state_space(self) -> "control.StateSpace":
        """The model as a python-control StateSpace whose outputs are the states."""
        import control

        C, D = np.eye(len(self.states)), np.zeros((len(self.states), len(self.inputs)))
        names = {"states": list(self.states), "inputs": list(self.inputs), "outputs": list(self.states)}
        return control.ss(self.A, self.B, C, D, name="gtm_t2", **names)

    def longitudinal_modes(self) -> list[Mode]:
        """Modes of the (u, w, q, theta) part, slowest first: phugoid and short period where they oscillate."""
        rows = [self.states.index(name) for name in LONGITUDINAL]
        roots = np.linalg.eigvals(self.A[np.ix_(rows, rows)])
        roots = roots[roots.imag >= 0]
        roots = roots[np.argsort(np.abs(roots))]
        return [Mode(float(abs(root)) / (2 * np.pi), float(-root.real / abs(root))) for root in roots]

    @property
    def verdicts(self) -> dict[str, Any]:
        """Stability and controllability, ready for JSON.

        ``at_breakpoint`` names the breakpoints. In the same order ``stable_sides`` says whether the trim is stable
        below and above each of them, the others from above, and ``growth_sides_per_s`` gives the largest real part of
        an eigenvalue there. ``stable`` means on every combination of sides.
        """
        return {
            "stable": self.stable,
            "controllable": self.controllable,
            "at_breakpoint": [sides.name for sides in self.sides],
            "stable_sides": [list(sides.stable) for sides in self.sides],
            "growth_sides_per_s": [list(sides.growth_per_s) for sides in self.sides],
        }

    def to_dict(self) -> dict[str, Any]:
        """All values, ready for JSON; eigenvalues as [real, imaginary], and the `verdicts`."""
        return {
            "states": list(self.states),
            "inputs": list(self.inputs),
            "A": self.A.tolist(),
            "B": self.B.tolist(),
            "eigenvalues": [[root.real, root.imag] for root in self.eigenvalues.tolist()],
            **self.verdicts,
            "smallest_singular_value": self.smallest_singular_value,
            "kalman_rank": self.kalman_rank,
            "kalman_condition": self.kalman_condition,
        }


def linearize(trim: Trim, limits: ControlLimits | Failure | None = None) -> LinearModel:
    """Exact linear model at a trim; controls that are jammed, or that move no surface and no engine, are no inputs.

    Args:
        trim: a feasible trim, of `steady.trim` or of an FMU.
        limits: those of the trim, which it carries itself; none need be given.

    Raises:
        InputError: no trim inside its limits, or other limits than those it was found with.
    """
    return _model(*exact_slopes(_failure_of(trim, limits)), trim, EXACT)


def linearize_fmu(
    airframe: "FmuAirframe", trim: Trim, limits: ControlLimits | Failure | None = None, epsilon: float | None = None
) -> LinearModel:
    """Linear model at a trim over an `evaluation.FmuAirframe`.

    By the FMU's directional derivatives if it has any, else, or where a step ``epsilon`` is given, by the paper's
    first-order differences (eqs 33-34). These see only the clearer breakpoints (`breakpoints.DIFFERENCES`).

    Raises:
        InputError: as `linearize`.
    """
    failure = _failure_of(trim, limits)
    kept, inputs = _inputs(failure)
    columns = [*range(len(_ROWS)), *(len(_ROWS) + k for k in kept)]
    is_exact = airframe.has_slopes and epsilon is None
    differentiate = airframe.slopes if epsilon is None else partial(airframe.differences, epsilon=epsilon)

    def evaluated(x: np.ndarray, u: np.ndarray) -> np.ndarray:
        return np.array([differentiate(*row)[1][np.ix_(_ROWS, columns)] for row in zip(x, u, strict=True)])

    return _model(evaluated, inputs, trim, EXACT if is_exact else DIFFERENCES)


def exact_slopes(failure: Failure) -> tuple[Slopes, tuple[str, ...]]:
    """What gives [A B] (.., 8, 8 + m) at states x (.., 12) and controls u (.., 4 or 5), and the m inputs."""
    kept, inputs = _inputs(failure)

    def exact(x: np.ndarray, u: np.ndarray) -> np.ndarray:
        A, B = slopes(x, u, failure.airframe.configuration, failure.controls)
        return np.concatenate([A, B[..., kept]], axis=-1)

    return exact, inputs


def slopes(
    x: ArrayLike, u: ArrayLike, configuration: Configuration | None = None, controls: tuple[str, ...] = CONTROLS
) -> tuple[np.ndarray, np.ndarray]:
    """Exact A (.., 8, 8) and B (.., 8, m) at states x (.., 12) and controls u (.., 4; with a configuration 5).

    B has a column for each of ``controls``: `names.CONTROLS`, one throttle for both engines, or
    `names.TWO_THROTTLE_CONTROLS`.
    """
    if configuration is None:
        jacobian = motion.jacobian(x, u)[1]
    else:
        jacobian = configured.jacobian(x, u, configuration)[1]
        if controls == CONTROLS:
            jacobian = np.concatenate([jacobian[..., :-2], jacobian[..., -2:].sum(axis=-1, keepdims=True)], axis=-1)
    rows = jacobian[..., _ROWS, :]
    return rows[..., _ROWS], rows[..., len(STATES) :]


class Verdict(NamedTuple):
    """Eigenvalues (n, 8) of A, stability (n) and the margin (n) of `controllability_margin`."""

    eigenvalues: np.ndarray
    stable: np.ndarray
    margin: np.ndarray


def verdict(slopes: np.ndarray, inputs: tuple[str, ...]) -> Verdict:
    """Of [A B] (n, 8, 8 + m) with the named inputs."""
    A, B = np.split(slopes, [len(LINEAR_STATES)], axis=-1)
    eigenvalues = np.linalg.eigvals(A)
    margin = controllability_margin(A, B, eigenvalues, input_scale(inputs))
    return Verdict(eigenvalues, is_stable(eigenvalues), margin)


def is_stable(eigenvalues: ArrayLike) -> np.ndarray:
    """Whether none of the eigenvalues (.., 8) has a positive real part (..)."""
    return np.all(np.asarray(eigenvalues).real <= 0, axis=-1)


def controllability_margin(
    A: np.ndarray, B: np.ndarray, eigenvalues: np.ndarray, input_scale: np.ndarray = INPUT_SCALE
) -> np.ndarray:
    """Smallest singular value (..) of the scaled PBH matrices of the unstable modes; infinite where all are stable.

    A (.., n, n), B (.., n, m), eigenvalues (.., n) of A.
    """
    n = A.shape[-1]
    A = A * STATE_SCALE / STATE_SCALE[:, None]
    B = B * input_scale / STATE_SCALE[:, None]
    eigenvalues = np.asarray(eigenvalues, dtype=complex)
    margin = np.full(eigenvalues.shape, np.inf)
    unstable = (eigenvalues.real > 0) & (eigenvalues.imag >= 0)  # a conjugate has the same singular values
    place = np.nonzero(unstable)[:-1]  # of the matrices, once for each unstable mode
    pencil = np.empty((np.count_nonzero(unstable), n, n + B.shape[-1]), dtype=complex)
    pencil[..., :n] = eigenvalues[unstable][:, None, None] * np.eye(n) - A[place]
    pencil[..., n:] = B[place]
    margin[unstable] = np.linalg.svd(pencil, compute_uv=False)[..., -1]
    return margin.min(axis=-1)


def input_scale(inputs: tuple[str, ...]) -> np.ndarray:
    """Scale of each of the named inputs; that of either engine's throttle is that of both."""
    return INPUT_SCALE[[CONTROLS.index(name.removesuffix("_left").removesuffix("_right")) for name in inputs]]


def weights(inputs: tuple[str, ...]) -> np.ndarray:
    """What brings [A B] (8, 8 + m) to the units of `STATE_SCALE` and `INPUT_SCALE`."""
    return np.append(STATE_SCALE, input_scale(inputs)) / STATE_SCALE[:, None]


def _inputs(failure: Failure) -> tuple[list[int], tuple[str, ...]]:
    """Places and names of the controls that move."""
    kept = [k for k, jammed in enumerate(failure.jammed) if not jammed]
    return kept, tuple(failure.controls[k] for k in kept)


def _failure_of(trim: Trim, limits: ControlLimits | Failure | None) -> Failure:
    if limits is not None and Failure.of(limits) != trim.failure:
        raise InputError("These are not the limits that the trim was found with; leave them out, it carries its own.")
    if not trim.feasible:
        raise InputError(
            f"This is no trim inside its limits ({trim.shortfall}); there is no linear model of it, "
            "so ask for another manoeuvre."
        )
    return trim.failure


def _model(slopes: Slopes, inputs: tuple[str, ...], trim: Trim, reach: Reach) -> LinearModel:
    at, airframe = (trim.altitude_ft, trim.gamma_deg * RAD_PER_DEG), trim.failure.airframe
    found = breakpoints(slopes, at, trim.unknowns[None], airframe, inputs, weights(inputs), reach)
    x, u = trim.state_and_controls
    return LinearModel.of_slopes(slopes(x[None], u[None])[0], inputs, found)
