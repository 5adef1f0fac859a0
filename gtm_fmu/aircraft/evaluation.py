"""An airframe, or any system, seen through an FMU: derivatives and their slopes in units of one's own."""

from collections.abc import Callable, Sequence
from typing import Protocol

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike

from gtm_fmu.aircraft.ranges import CONTROL_SI, STATE_SI, WIDEST
from gtm_fmu.airframe.names import LINEAR_STATES, STATES

LINEAR_ROWS = np.array([STATES.index(name) for name in LINEAR_STATES])
ALTITUDE = STATES.index("altitude")
ACCELERATIONS = 6
"""The first six derivatives, which a trim makes zero."""

EPSILON = 1e-6
"""Step of the first-order differences, in ft/s, rad/s, rad, deg and % alike (paper eqs 33-34)."""


class DerivativeEvaluator(Protocol):
    """What evaluates derivatives: an `FmuClient`, or anything else that can.

    One with an attribute ``jacobian`` that is not None also gives their exact slopes, as the client's does; one with a
    method ``si_factors`` says what its units are in SI. Otherwise slopes are differences, and units SI.
    """

    def evaluate(self, x: np.ndarray, u: np.ndarray) -> np.ndarray:
        """State derivatives (n) at states x (n) and controls u (m)."""


class FmuSystem:
    """State derivatives of an evaluator, and their slopes, in units of one's own."""

    def __init__(
        self,
        evaluator: DerivativeEvaluator,
        x_scale: ArrayLike,
        u_scale: ArrayLike,
        dx_scale: ArrayLike | None = None,
        rows: np.ndarray | None = None,
        u_range: np.ndarray | None = None,
    ) -> None:
        """Say what the own units are in those of the evaluator.

        Args:
            x_scale, u_scale, dx_scale: of states (n), controls (m) and derivatives (n; default: of the states).
            rows: the states with slopes (k); default: all.
            u_range: lower and upper ends (m each) of the controls, in own units, that no difference leaves.
        """
        self._evaluator = evaluator
        self._x_scale, self._u_scale = np.asarray(x_scale, dtype=float), np.asarray(u_scale, dtype=float)
        self._dx_scale = self._x_scale if dx_scale is None else np.asarray(dx_scale, dtype=float)
        self._rows = np.arange(len(self._x_scale)) if rows is None else rows
        self._u_range = (-np.inf, np.inf) if u_range is None else u_range
        self._columns = np.append(self._rows, len(self._x_scale) + np.arange(len(self._u_scale)))
        self._column_scale = np.append(self._x_scale, self._u_scale)[self._columns]

    def derivatives(self, x: np.ndarray, u: np.ndarray) -> np.ndarray:
        """State derivatives (n) at x (n) and u (m)."""
        return self._evaluator.evaluate(x * self._x_scale, u * self._u_scale) / self._dx_scale

    @property
    def has_slopes(self) -> bool:
        """Whether the evaluator has exact ones."""
        return getattr(self._evaluator, "jacobian", None) is not None

    def slopes(self, x: np.ndarray, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """State derivatives (n) and their slopes (n, k + m): exact if the evaluator has them, else `differences`."""
        if not self.has_slopes:
            return self.differences(x, u)
        exact = self._evaluator.jacobian  # type: ignore[attr-defined]
        dx, jacobian = exact(x * self._x_scale, u * self._u_scale, self._columns)
        return dx / self._dx_scale, jacobian * self._column_scale / self._dx_scale[:, None]

    def differences(self, x: np.ndarray, u: np.ndarray, epsilon: float = EPSILON) -> tuple[np.ndarray, np.ndarray]:
        """State derivatives (n) and their first-order differences (n, k + m).

        A control whose step would leave its full range, where the FMU holds it, is stepped the other way. With a
        negative epsilon the differences are backward ones.
        """
        evaluate, n = self._evaluator.evaluate, len(self._rows)
        at, u_at = x * self._x_scale, u * self._u_scale
        dx = evaluate(at, u_at)
        steps = np.full(len(self._columns), epsilon)
        leaves_range = (u + epsilon < self._u_range[0]) | (u + epsilon > self._u_range[1])
        steps[n:][leaves_range] *= -1
        slopes = np.empty((len(steps), len(dx)))
        entries = [(at, row) for row in self._rows] + [(u_at, row) for row in range(len(u_at))]
        for slope, (vector, row), step in zip(slopes, entries, steps * self._column_scale, strict=True):
            kept = vector[row]
            vector[row] += step
            slope[:] = evaluate(at, u_at) - dx
            vector[row] = kept
        return dx / self._dx_scale, (slopes / self._dx_scale / steps[:, None]).T


class FmuAirframe(FmuSystem):
    """An aircraft in the specification's units, with slopes in `LINEAR_STATES` and the controls.

    Any aircraft will do whose FMU has our states and controls, under whatever names: give them to the `FmuClient` in
    the order of `names.STATES` and `names.CONTROLS`. Units are those that the FMU declares.
    """

    def __init__(self, evaluator: DerivativeEvaluator):
        """Take the FMU's own units if it declares any, SI otherwise."""
        scales = STATE_SI, CONTROL_SI, STATE_SI
        factors = getattr(evaluator, "si_factors", None)
        if factors is not None:
            scales = tuple(scale / factor for scale, factor in zip(scales, factors(), strict=True))
        super().__init__(evaluator, *scales, rows=LINEAR_ROWS, u_range=np.array([*WIDEST.values()]).T)


class FmuFunction(ca.Callback):
    """A function of one vector by FMU evaluations, with its Jacobian, inside CasADi; buffers spare conversions.

    Keep it as long as what is made of it: CasADi does not own it.
    """

    def __init__(self, name: str, sizes: tuple[int, int], value: Callable, slopes: Callable):
        """Stand for ``value``, of z (n) an array (m), and its ``slopes`` (m, n), where (n, m) are the sizes."""
        super().__init__()
        self._sizes, self._value, self._slopes = sizes, value, slopes
        self.construct(name, {})

    def get_sparsity_in(self, _: object) -> ca.Sparsity:
        """One column."""
        return ca.Sparsity.dense(self._sizes[0], 1)

    def get_sparsity_out(self, _: object) -> ca.Sparsity:
        """One column."""
        return ca.Sparsity.dense(self._sizes[1], 1)

    def has_eval_buffer(self) -> bool:
        """Always."""
        return True

    def eval_buffer(self, arguments: Sequence[memoryview], results: Sequence[memoryview]) -> int:
        """One evaluation."""
        np.frombuffer(results[0])[:] = self._value(np.frombuffer(arguments[0]))
        return 0

    def has_jacobian(self) -> bool:
        """By the slopes."""
        return True

    def get_jacobian(self, name: str, *_: object) -> ca.Function:
        """The Jacobian's function; kept here, since CasADi does not own it."""
        self._jacobian = _Jacobian(name, self._sizes, self._slopes)
        return self._jacobian


class _Jacobian(ca.Callback):
    """Jacobian (m, n) of an `FmuFunction`, of its argument and its value, which is not used."""

    def __init__(self, name: str, sizes: tuple[int, int], slopes: Callable):
        super().__init__()
        self._sizes, self._slopes = sizes, slopes
        self.construct(name, {})

    def get_n_in(self) -> int:
        return 2

    def get_sparsity_in(self, i: int) -> ca.Sparsity:
        return (ca.Sparsity.dense(self._sizes[0], 1), ca.Sparsity(self._sizes[1], 1))[i]

    def get_sparsity_out(self, _: object) -> ca.Sparsity:
        return ca.Sparsity.dense(self._sizes[1], self._sizes[0])

    def has_eval_buffer(self) -> bool:
        return True

    def eval_buffer(self, arguments: Sequence[memoryview], results: Sequence[memoryview]) -> int:
        np.frombuffer(results[0])[:] = self._slopes(np.frombuffer(arguments[0])).ravel(order="F")
        return 0
