"""Inputs with a Gaussian dependence: jointly normal, or of any marginals joined by a Gaussian copula."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import stats
from scipy.special import ndtr, ndtri

from .distributions import Array, Density
from .marginals import Marginal, inner


@dataclass(frozen=True, eq=False)
class GaussianCopula:
    """Inputs of any continuous marginals whose normal scores z = Phi^-1(F(x)) are jointly normal.

    Args:
        marginals: one for each input, each `Marginal` of a continuous law.
        correlation: of the normal scores (M, M); for normal marginals it is that of the inputs.
        rank_correlation: Spearman's, in its place; the scores then have the correlation 2 sin(pi rho / 6).

    Raises:
        ValueError: a discrete marginal, none or both matrices, or a matrix that is no correlation.
    """

    marginals: tuple[Marginal, ...]
    correlation: Array

    def __init__(
        self,
        marginals: Sequence[Marginal],
        correlation: ArrayLike | None = None,
        *,
        rank_correlation: ArrayLike | None = None,
    ) -> None:
        if (correlation is None) == (rank_correlation is None):
            raise ValueError("A copula needs either correlation or rank_correlation: give one of them.")
        for marginal in marginals:
            if hasattr(marginal.law, "pmf"):
                raise ValueError(f"The law of {marginal.name} is discrete, and has no normal scores: give another.")
        names = tuple(marginal.name for marginal in marginals)
        if rank_correlation is not None:
            correlation = 2.0 * np.sin(np.pi / 6.0 * correlation_matrix(rank_correlation, names))
        scores = correlation_matrix(np.asarray(correlation), names)
        object.__setattr__(self, "marginals", tuple(marginals))
        object.__setattr__(self, "correlation", scores)

    @property
    def names(self) -> tuple[str, ...]:
        """Name of each input."""
        return tuple(marginal.name for marginal in self.marginals)

    @property
    def units(self) -> tuple[str, ...]:
        """Unit of each input."""
        return tuple(marginal.unit for marginal in self.marginals)

    @property
    def bounds(self) -> tuple[tuple[float, float], ...]:
        """Ends of each input's support."""
        return tuple(marginal.bounds[0] for marginal in self.marginals)

    def sample(self, u: Array) -> Array:
        """Draws (n, M) from u (n, M) in [0, 1)."""
        return self._values(ndtri(inner(u)) @ np.linalg.cholesky(self.correlation).T)

    def conditional(self, x: Array, redrawn: Sequence[bool], u: Array) -> Array:
        """Redraw some columns of x (n, M) from the conditional normal law of their scores."""
        drawn = conditional_scores(self._scores(x), redrawn, u, self.correlation)
        return np.where(redrawn, self._values(drawn), x)

    def contains(self, x: Array) -> NDArray[np.bool_]:
        """Whether each row of x (n, M) lies between the ends of all supports, shape (n,)."""
        return np.logical_and.reduce([m.contains(x[:, [k]]) for k, m in enumerate(self.marginals)])

    def density(self, x: Array, kept: Sequence[bool]) -> Density:
        """Density of the kept columns of x (n, M)."""
        columns = np.flatnonzero(kept)
        if not columns.size:
            return Density.of_nothing(len(x))
        z = self._scores(x)[:, columns]
        matrix = self.correlation[np.ix_(columns, columns)]
        ratio = stats.multivariate_normal(cov=matrix).logpdf(z) - stats.norm.logpdf(z).sum(axis=1)
        marginals = [self.marginals[k].law.pdf(x[:, k]) for k in columns]
        return Density(np.exp(ratio) * np.prod(marginals, axis=0), len(columns))

    def _scores(self, x: Array) -> Array:
        return ndtri(inner(np.column_stack([m.law.cdf(x[:, k]) for k, m in enumerate(self.marginals)])))

    def _values(self, z: Array) -> Array:
        return np.column_stack([m.law.ppf(inner(ndtr(z[:, k]))) for k, m in enumerate(self.marginals)])


@dataclass(frozen=True, eq=False)
class Gaussian:
    """Jointly normal inputs of a mean (M) and a covariance (M, M).

    Raises:
        ValueError: shapes that do not fit, or a covariance that is not symmetric and positive definite.
    """

    names: tuple[str, ...]
    mean: Array
    covariance: Array
    units: tuple[str, ...] = ()
    _deviation: Array = field(init=False, repr=False)
    _correlation: Array = field(init=False, repr=False)

    def __post_init__(self) -> None:
        """Check the shapes, and split the covariance into deviations and correlation."""
        mean, covariance = np.asarray(self.mean, dtype=float), np.asarray(self.covariance, dtype=float)
        m = len(self.names)
        if isinstance(self.names, str) or mean.shape != (m,) or covariance.shape != (m, m):
            raise ValueError(
                f"{m} names have a mean of shape {mean.shape} and a covariance of shape {covariance.shape}: "
                "give one mean and one row for each name."
            )
        variance = np.diag(covariance)
        if not (np.isfinite(mean).all() and np.isfinite(covariance).all() and (variance > 0.0).all()):
            raise ValueError(f"Mean and covariance of {', '.join(self.names)} must be finite with variances above 0.")
        deviation = np.sqrt(variance)
        settings = {
            "names": tuple(self.names),
            "mean": mean,
            "covariance": covariance,
            "units": tuple(self.units) or ("",) * m,
            "_deviation": deviation,
            "_correlation": correlation_matrix(covariance / np.outer(deviation, deviation), self.names),
        }
        for name, value in settings.items():
            object.__setattr__(self, name, value)

    @property
    def bounds(self) -> tuple[tuple[float, float], ...]:
        """No input has any."""
        return ((-np.inf, np.inf),) * len(self.names)

    def sample(self, u: Array) -> Array:
        """Draws (n, M) from u (n, M) in [0, 1)."""
        return self._values(ndtri(inner(u)) @ np.linalg.cholesky(self._correlation).T)

    def conditional(self, x: Array, redrawn: Sequence[bool], u: Array) -> Array:
        """Redraw some columns of x (n, M) given the others."""
        scores = (x - self.mean) / self._deviation
        return np.where(redrawn, self._values(conditional_scores(scores, redrawn, u, self._correlation)), x)

    def contains(self, x: Array) -> NDArray[np.bool_]:
        """Whether each row of x (n, M) is finite, shape (n,)."""
        return np.logical_and.reduce(np.isfinite(x), axis=1)

    def density(self, x: Array, kept: Sequence[bool]) -> Density:
        """Density of the kept columns of x (n, M)."""
        columns = np.flatnonzero(kept)
        if not columns.size:
            return Density.of_nothing(len(x))
        law = stats.multivariate_normal(self.mean[columns], self.covariance[np.ix_(columns, columns)])
        return Density(np.atleast_1d(law.pdf(x[:, columns])), len(columns))

    def _values(self, scores: Array) -> Array:
        return self.mean + self._deviation * scores


def conditional_scores(z: Array, redrawn: Sequence[bool], u: Array, correlation: Array) -> Array:
    """Normal scores z (n, M) with the redrawn columns y drawn from p(y | the others).

    With R the correlation, y | z ~ N(R_yz R_zz^-1 z, R_yy - R_yz R_zz^-1 R_zy).
    """
    y, z_kept = np.flatnonzero(redrawn), np.flatnonzero(~np.asarray(redrawn))
    gain = np.linalg.solve(correlation[np.ix_(z_kept, z_kept)], correlation[np.ix_(z_kept, y)])
    spread = correlation[np.ix_(y, y)] - correlation[np.ix_(y, z_kept)] @ gain
    drawn = z.copy()
    drawn[:, y] = z[:, z_kept] @ gain + ndtri(inner(u[:, y])) @ np.linalg.cholesky(spread).T
    return drawn


def correlation_matrix(given: ArrayLike, names: Sequence[str]) -> Array:
    """A correlation matrix (M, M), checked.

    Raises:
        ValueError: another shape, not symmetric, a diagonal other than 1, or not positive definite.
    """
    matrix, m = np.asarray(given, dtype=float), len(names)
    if matrix.shape != (m, m) or not np.isfinite(matrix).all():
        raise ValueError(f"The correlation has shape {matrix.shape}: give {m} x {m} finite numbers for {m} inputs.")
    if not (np.allclose(matrix, matrix.T) and np.allclose(np.diag(matrix), 1.0)):
        raise ValueError("The correlation is not symmetric with ones on its diagonal: give such a matrix.")
    least = float(np.linalg.eigvalsh(matrix)[0])
    if least < 1e-10:
        raise ValueError(
            f"The correlation of {', '.join(names)} has the eigenvalue {least:.3g}: it must be positive definite; "
            "use weaker correlations, or leave an input out that follows from the others."
        )
    return (matrix + matrix.T) / 2.0
