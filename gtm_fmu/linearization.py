"""Linear models at a trim: exact, or over an FMU; stability and controllability.

States u v w p q r phi theta in ft/s, rad/s, rad; inputs elevator, aileron, rudder in deg, throttle in %, without the
jammed ones. The exact slopes at a breakpoint of the aerodynamic tables are those of the interval above it.

A trim is stable if no eigenvalue of A has a positive real part (paper, section III-B). An unstable one is controllable
if every unstable mode is (Popov, Belevitch, Hautus): the smallest singular value of [lambda I - A, B], with states and
inputs in units of `STATE_SCALE` and `INPUT_SCALE`, is at least `PBH_THRESHOLD`. The rank of the paper's matrix
[B AB .. A^7 B] (eq. 35) is given beside it; powers of A spread its columns over many orders of magnitude, so that its
condition is 1e9 to 5e11 and its numerical rank depends on the tolerance more than on the aircraft.
"""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from gtm_fmu.airframe.names import CONTROLS, LINEAR_STATES, STATES
from gtm_fmu.core import configuration as configured
from gtm_fmu.core import motion
from gtm_fmu.core.configuration import Configuration
from gtm_fmu.failures import ControlLimits, Failure
from gtm_fmu.manoeuvre import Trim

STATE_SCALE = np.array([10.0, 10.0, 10.0, 0.2, 0.2, 0.2, 0.2, 0.2])  # ft/s, rad/s, rad
INPUT_SCALE = np.array([10.0, 10.0, 10.0, 30.0])  # deg, %
PBH_THRESHOLD = 1e-3
LONGITUDINAL = ("u", "w", "q", "theta")

_ROWS = np.array([STATES.index(name) for name in LINEAR_STATES])


class Mode(NamedTuple):
    """An oscillation or, with zero frequency, an exponential: undamped frequency in Hz and damping ratio."""

    frequency_hz: float
    damping: float


@dataclass(frozen=True)
class LinearModel:
    """Linear model x' = A x + B u about a trim.

    Attributes:
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
    smallest_singular_value: float | None
    kalman_rank: int
    kalman_condition: float | None

    @classmethod
    def of_matrices(cls, A, B, inputs: tuple[str, ...]) -> "LinearModel":
        """The model of A (8, 8) and B (8, m) with the named inputs."""
        eigenvalues = np.linalg.eigvals(A)
        margin = float(controllability_margin(A, B, eigenvalues, input_scale(inputs)))
        kalman = np.hstack([np.linalg.matrix_power(A, k) @ B for k in range(len(A))])
        return cls(
            states=LINEAR_STATES,
            inputs=inputs,
            A=A,
            B=B,
            eigenvalues=eigenvalues,
            stable=bool(is_stable(eigenvalues)),
            controllable=margin >= PBH_THRESHOLD,
            smallest_singular_value=margin if np.isfinite(margin) else None,
            kalman_rank=int(np.linalg.matrix_rank(kalman)) if inputs else 0,
            kalman_condition=float(np.linalg.cond(kalman)) if inputs else None,
        )

    def state_space(self):
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

    def to_dict(self) -> dict[str, Any]:
        """All values, ready for JSON; eigenvalues as [real, imaginary]."""
        return {
            "states": list(self.states),
            "inputs": list(self.inputs),
            "A": self.A.tolist(),
            "B": self.B.tolist(),
            "eigenvalues": [[root.real, root.imag] for root in self.eigenvalues.tolist()],
            "stable": self.stable,
            "controllable": self.controllable,
            "smallest_singular_value": self.smallest_singular_value,
            "kalman_rank": self.kalman_rank,
            "kalman_condition": self.kalman_condition,
        }


def linearize(trim: Trim, limits: ControlLimits | Failure | None = None) -> LinearModel:
    """Exact linear model at a trim; controls that ``limits`` jam, or that nothing follows, are no inputs.

    Give the limits or the failure that the trim was found with.
    """
    failure = Failure.of(limits)
    return _without_jammed(*slopes(*trim.state_and_controls, trim.configuration, failure.controls), failure)


def linearize_fmu(airframe, trim: Trim, limits: ControlLimits | Failure | None = None, **step: float) -> LinearModel:
    """Linear model at a trim over an `evaluation.FmuAirframe`.

    By the FMU's directional derivatives if it has any, else, or where a step ``epsilon`` is given, by the paper's
    first-order differences (eqs 33-34).
    """
    differentiate = airframe.differences if step else airframe.slopes
    A, B = np.hsplit(differentiate(*trim.state_and_controls, **step)[1][_ROWS], [len(_ROWS)])
    return _without_jammed(A, B, Failure.of(limits))


def slopes(
    x, u, configuration: Configuration | None = None, controls: tuple[str, ...] = CONTROLS
) -> tuple[np.ndarray, np.ndarray]:
    """Exact A (.., 8, 8) and B (.., 8, m) at states x (.., 12) and controls u (.., 4; with a configuration 5).

    B has a column for each of ``controls``: `names.CONTROLS`, one throttle for both engines, or `names.FULL_CONTROLS`.
    """
    if configuration is None:
        jacobian = motion.jacobian(x, u)[1]
    else:
        jacobian = configured.jacobian(x, u, configuration)[1]
        if len(controls) == len(CONTROLS):
            jacobian = np.concatenate([jacobian[..., :-2], jacobian[..., -2:].sum(axis=-1, keepdims=True)], axis=-1)
    rows = jacobian[..., _ROWS, :]
    return rows[..., _ROWS], rows[..., len(STATES) :]


def is_stable(eigenvalues) -> np.ndarray:
    """Whether none of the eigenvalues (.., 8) has a positive real part (..)."""
    return np.all(np.asarray(eigenvalues).real <= 0, axis=-1)


def controllability_margin(A, B, eigenvalues, input_scale=INPUT_SCALE) -> np.ndarray:
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


def _without_jammed(A, B, failure: Failure) -> LinearModel:
    kept = [k for k, jammed in enumerate(failure.jammed) if not jammed]
    return LinearModel.of_matrices(A, B[:, kept], tuple(failure.controls[k] for k in kept))
