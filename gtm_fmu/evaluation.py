"""The airframe seen through an FMU: derivatives and their first-order differences in the specification's units."""

from typing import Protocol

import casadi as ca
import numpy as np

from fmu_src.dynamics_variables import dynamics_description
from gtm_fmu.airframe.names import CONTROLS, LINEAR_STATES, STATES

LINEAR_ROWS = np.array([STATES.index(name) for name in LINEAR_STATES])
ALTITUDE = STATES.index("altitude")
ACCELERATIONS = 6
"""The first six derivatives, which a trim makes zero."""

EPSILON = 1e-6
"""Step of the first-order differences, in ft/s, rad/s, rad, deg and % alike (paper eqs 33-34)."""


class DerivativeEvaluator(Protocol):
    """What evaluates derivatives: an `FmuClient` of GtmDynamics, or anything else that can."""

    def evaluate(self, x, u) -> np.ndarray:
        """State derivatives (12) at states x (12) and controls u (4), all in SI as in the FMU."""


class FmuAirframe:
    """State derivatives of an evaluator in the specification's units."""

    def __init__(self, evaluator: DerivativeEvaluator):
        """Take units and ranges from the FMU's table of variables."""
        variables = dynamics_description().groups
        self._evaluator = evaluator
        self._x_scale, self._u_scale = (
            np.array([variable.scale for variable in variables[group]]) for group in ("states", "controls")
        )
        self._least_u = np.array([variable.minimum for variable in variables["controls"]]) / self._u_scale
        self._most_u = np.array([variable.maximum for variable in variables["controls"]]) / self._u_scale

    def derivatives(self, x, u) -> np.ndarray:
        """State derivatives (12) at x (12) and u (4)."""
        return self._evaluator.evaluate(x * self._x_scale, u * self._u_scale) / self._x_scale

    def differences(self, x, u, epsilon: float = EPSILON) -> tuple[np.ndarray, np.ndarray]:
        """State derivatives (12) and their first-order differences (12, 8 + 4) in `LINEAR_STATES` and the controls.

        A control whose step would leave its full range, where the FMU holds it, is stepped the other way. With a
        negative epsilon the differences are backward ones.
        """
        evaluate, n = self._evaluator.evaluate, len(LINEAR_STATES)
        at, u_at = x * self._x_scale, u * self._u_scale
        dx = evaluate(at, u_at)
        steps = np.full(n + len(CONTROLS), epsilon)
        leaves_range = (u + epsilon > self._most_u) | (u + epsilon < self._least_u)
        steps[n:][leaves_range] *= -1
        slopes = np.empty((len(steps), len(dx)))
        entries = [(at, row) for row in LINEAR_ROWS] + [(u_at, row) for row in range(len(CONTROLS))]
        step_sizes = steps * np.append(self._x_scale[LINEAR_ROWS], self._u_scale)
        for slope, (vector, row), step in zip(slopes, entries, step_sizes, strict=True):
            kept = vector[row]
            vector[row] += step
            slope[:] = evaluate(at, u_at) - dx
            vector[row] = kept
        return dx / self._x_scale, (slopes / self._x_scale / steps[:, None]).T


class _OverFmu(ca.Callback):
    """CasADi function of one vector (13): linear states, controls and altitude. Buffers spare conversions."""

    SIZE = len(LINEAR_STATES) + len(CONTROLS) + 1

    def __init__(self, name: str, airframe: FmuAirframe):
        super().__init__()
        self._airframe, self._x = airframe, np.zeros(len(STATES))
        self.construct(name, {})

    def has_eval_buffer(self):
        return True

    def _state_and_controls(self, arguments) -> tuple[np.ndarray, np.ndarray]:
        values = np.frombuffer(arguments[0])
        self._x[LINEAR_ROWS], self._x[ALTITUDE] = values[: len(LINEAR_STATES)], values[-1]
        return self._x, values[len(LINEAR_STATES) : -1]


class Accelerations(_OverFmu):
    """The accelerations (6) of linear states, controls and altitude (13), by FMU evaluations inside CasADi."""

    def __init__(self, airframe: FmuAirframe):
        """Stand for the FMU behind ``airframe``."""
        super().__init__("accelerations", airframe)

    def get_sparsity_in(self, _):
        """One column."""
        return ca.Sparsity.dense(self.SIZE, 1)

    def get_sparsity_out(self, _):
        """One column."""
        return ca.Sparsity.dense(ACCELERATIONS, 1)

    def eval_buffer(self, arguments, results):
        """One FMU evaluation."""
        np.frombuffer(results[0])[:] = self._airframe.derivatives(*self._state_and_controls(arguments))[:ACCELERATIONS]
        return 0

    def has_jacobian(self):
        """By first-order differences."""
        return True

    def get_jacobian(self, name, *_):
        """The Jacobian's function; kept here, since CasADi does not own it."""
        self._slopes = _AccelerationSlopes(name, self._airframe)
        return self._slopes


class _AccelerationSlopes(_OverFmu):
    """Jacobian (6, 13) of `Accelerations`; the altitude, a constant of a trim, gets no column."""

    def get_n_in(self):
        return 2

    def get_sparsity_in(self, i):
        return (ca.Sparsity.dense(self.SIZE, 1), ca.Sparsity(ACCELERATIONS, 1))[i]

    def get_sparsity_out(self, _):
        return ca.horzcat(ca.Sparsity.dense(ACCELERATIONS, self.SIZE - 1), ca.Sparsity(ACCELERATIONS, 1))

    def eval_buffer(self, arguments, results):
        _, slopes = self._airframe.differences(*self._state_and_controls(arguments))
        np.frombuffer(results[0])[:] = slopes[:ACCELERATIONS].ravel(order="F")
        return 0
