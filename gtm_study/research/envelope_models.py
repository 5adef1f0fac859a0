"""Models that learn the envelope from exact cases or thrusts, with any estimator of scikit-learn's convention.

`CaseModel` learns V_min, V_max and t_min over all inputs of a case, as the paper does. `JamModel` learns them over the
jams of one control, and takes the least and the greatest over the jams inside the limits. `surface_map` learns the
surface of a thrust map from some of its exact solutions. Wherever t_min is at most full throttle there is an envelope.
"""

import warnings
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from sklearn.base import BaseEstimator, RegressorMixin, clone
from sklearn.compose import TransformedTargetRegressor
from sklearn.ensemble import HistGradientBoostingRegressor
from sklearn.exceptions import ConvergenceWarning
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import ConstantKernel, Matern, WhiteKernel
from sklearn.linear_model import RidgeCV
from sklearn.model_selection import GridSearchCV
from sklearn.multioutput import MultiOutputRegressor
from sklearn.pipeline import Pipeline, make_pipeline
from sklearn.preprocessing import MinMaxScaler, PolynomialFeatures, StandardScaler
from sklearn.svm import SVR

from gtm_fmu.aircraft.ranges import WIDEST
from gtm_fmu.datasets.off_lattice import OffLattice
from gtm_fmu.envelopes.feasibility import has_envelope
from gtm_fmu.envelopes.thrust_map import ThrustMap

_NODE_STEP_DEG = 2.0  # between jams inside the limits
_KERNEL_SAMPLES = 300


class GaussianProcess(RegressorMixin, BaseEstimator):
    """A Gaussian process whose kernel (ARD Matern 5/2 and noise) is chosen on some hundred samples, for one output.

    Attributes:
        kernel: a chosen one, kept as it is; None to choose it.
    """

    def __init__(self, kernel: Any = None, samples: int = _KERNEL_SAMPLES):
        self.kernel = kernel
        self.samples = samples

    def fit(self, X: np.ndarray, y: np.ndarray) -> "GaussianProcess":
        """Choose the kernel, and condition on all samples."""
        self.kernel_ = self.kernel
        if self.kernel is None:
            length = Matern(np.ones(X.shape[1]), (0.05, 100.0), nu=2.5)
            kernel = ConstantKernel(1.0, (1e-2, 1e4)) * length + WhiteKernel(1e-5, (1e-9, 1e-1))
            some = np.random.default_rng(0).permutation(len(X))[: self.samples]
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", ConvergenceWarning)  # a bound that is reached is a fine choice
                self.kernel_ = GaussianProcessRegressor(kernel, normalize_y=True).fit(X[some], y[some]).kernel_
        self.process_ = GaussianProcessRegressor(self.kernel_, optimizer=None, normalize_y=True).fit(X, y)
        return self

    def predict(self, X: np.ndarray, return_std: bool = False) -> Any:
        """Mean (n), with ``return_std`` also the standard deviation (n)."""
        return self.process_.predict(X, return_std=return_std)


def _scaled(estimator: Any) -> Pipeline:
    """An estimator on inputs in -1 .. 1 and targets of zero mean and unit variance, output by output."""
    each = MultiOutputRegressor(TransformedTargetRegressor(estimator, transformer=StandardScaler()))
    return make_pipeline(MinMaxScaler((-1.0, 1.0)), each)


def gaussian_process() -> Pipeline:
    """See `GaussianProcess`."""
    return make_pipeline(MinMaxScaler((-1.0, 1.0)), MultiOutputRegressor(GaussianProcess()))


def support_vectors() -> Pipeline:
    """Support vector regression, its width and cost by cross-validation (the paper's outlook)."""
    grid = {"gamma": (0.3, 1.0), "C": (10.0, 100.0)}
    return _scaled(GridSearchCV(SVR(epsilon=0.002, cache_size=500, max_iter=100_000), grid, cv=3))


def boosted_trees() -> Pipeline:
    """Gradient boosting on histograms."""
    return _scaled(HistGradientBoostingRegressor(max_iter=600, learning_rate=0.08, random_state=0))


def polynomial() -> Pipeline:
    """A polynomial of degree 7, its ridge by cross-validation."""
    ridge = RidgeCV(np.logspace(-8, 0, 9))
    return _scaled(make_pipeline(PolynomialFeatures(7), ridge))


Estimator = Callable[[], Any]


def _column(values: np.ndarray) -> np.ndarray:
    return np.asarray(values).reshape(len(values), -1)


@dataclass
class CaseModel:
    """V_min, V_max and t_min over the inputs of a case."""

    make: Estimator
    speeds: Any = field(default=None, repr=False)
    throttle: Any = field(default=None, repr=False)

    def fit(self, data: OffLattice) -> "CaseModel":
        """Learn the speeds where there is an envelope, and t_min where there is one."""
        known = np.isfinite(data.t_min_pct)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ConvergenceWarning)  # support vectors stop at a bound that we set
            self.throttle = self.make().fit(data.X[known], data.t_min_pct[known, None])
            self.speeds = self.make().fit(data.X[data.feasible], data.speeds_kt[data.feasible])
        return self

    def predict(self, X: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """V_min and V_max (n, 2) in kn, and whether there is an envelope (n)."""
        return _column(self.speeds.predict(X)), has_envelope(_column(self.throttle.predict(X))[:, 0])


@dataclass
class JamModel:
    """The same over altitude, flight path and jam, with the extremes over the jams inside the limits on top."""

    make: Estimator
    model: CaseModel | None = field(default=None, repr=False)

    def fit(self, data: OffLattice) -> "JamModel":
        """Learn from jams."""
        self.model = CaseModel(self.make).fit(replace(data, X=data.X[:, :3]))
        return self

    def predict(self, X: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """V_min and V_max (n, 2) in kn, NaN without an envelope, and whether there is one (n)."""
        assert self.model is not None
        least, most = WIDEST["rudder_deg"]
        nodes = np.arange(least, most + _NODE_STEP_DEG / 2, _NODE_STEP_DEG)
        inside = [np.unique([lower, *nodes[(lower < nodes) & (nodes < upper)], upper]) for *_, lower, upper in X]
        start = np.cumsum([0, *map(len, inside)])[:-1]
        jams = np.column_stack([np.repeat(X[:, :2], [len(d) for d in inside], axis=0), np.concatenate(inside)])
        feasible = has_envelope(_column(self.model.throttle.predict(jams))[:, 0])
        v_min, v_max = _column(self.model.speeds.predict(jams)).T
        lowest = np.minimum.reduceat(np.where(feasible, v_min, np.inf), start)
        highest = np.maximum.reduceat(np.where(feasible, v_max, -np.inf), start)
        found = np.isfinite(lowest)
        return np.where(found[:, None], np.column_stack([lowest, highest]), np.nan), found


def surface_map(exact: ThrustMap, make: Estimator, solves: int, seed: int = 0) -> ThrustMap:
    """A thrust map whose surface an estimator learnt from some of the exact solutions of another, chosen by chance.

    A twentieth of the solutions are slowest speeds; the others thrusts. The estimator sees deflection, flight path,
    density ratio and the place of the speed between the slowest and the fastest.
    """
    rng = np.random.default_rng(seed)
    k, l, m, n = exact.table.shape  # noqa: E741
    n -= 2
    grid = np.meshgrid(exact.density_ratio, exact.gamma_deg, exact.deflection_deg, indexing="ij")
    curves = np.column_stack([axis.ravel() for axis in grid])
    slowest, thrusts = exact.table[..., 0].reshape(-1), exact.table[..., 2:].reshape(-1)
    points = np.column_stack([np.repeat(curves, n, axis=0), np.tile(np.linspace(0.0, 1.0, n), k * l * m)])
    table = np.array(exact.table)
    for values, X, count, part in (
        (slowest, curves, max(solves // 20, 30), (..., 0)),
        (thrusts, points, solves - max(solves // 20, 30), (..., slice(2, None))),
    ):
        some = rng.permutation(len(X))[:count]
        learnt = clone(make()).fit(X[some], values[some, None])
        table[part] = _column(learnt.predict(X)).reshape(table[part].shape)
    return replace(exact, table=table, provenance={})
