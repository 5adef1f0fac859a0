"""Sensitivity analysis of any model whose inputs may depend on each other.

distribution = Distribution([Uniform("x", 0, 1), OrderedUniform(("low", "high"), -1, 1)])
evaluated = variance_design(distribution, 2**14).evaluate(model, output_names=["y"])
indices = variance_indices(evaluated)
figure = plot_indices(indices)

It needs NumPy and SciPy; figures need matplotlib, which is imported when one is drawn.
"""

from typing import Any

from .correlated import Gaussian, GaussianCopula
from .design import Design, EvaluatedDesign, variance_design
from .distributions import Block, Density, Distribution, OrderedUniform, Uniform
from .elementary_effects import EffectsDesign, ElementaryEffects, effects_design
from .empirical import Empirical
from .given_data import GivenDataIndices, given_data_indices
from .indices import Estimate, Identity, VarianceIndices, variance_indices
from .marginals import Marginal, PointMass
from .mixtures import Equal, Mixture, ordered_with_jams
from .moment_free import PawnIndices, pawn_indices
from .rejection import Conditioned, conditioned
from .salib_problem import from_salib
from .simplex import Simplex

__all__ = [
    "Block",
    "Conditioned",
    "Density",
    "Design",
    "Distribution",
    "EffectsDesign",
    "ElementaryEffects",
    "Empirical",
    "Equal",
    "Estimate",
    "EvaluatedDesign",
    "Gaussian",
    "GaussianCopula",
    "GivenDataIndices",
    "Identity",
    "Marginal",
    "Mixture",
    "OrderedUniform",
    "PawnIndices",
    "PointMass",
    "Simplex",
    "Uniform",
    "VarianceIndices",
    "conditioned",
    "effects_design",
    "from_salib",
    "given_data_indices",
    "ordered_with_jams",
    "pawn_indices",
    "plot_indices",
    "variance_design",
    "variance_indices",
]


def __getattr__(name: str) -> Any:
    """Figures bring matplotlib, so they are imported when one is asked for."""
    if name == "plot_indices":
        from .plots import plot_indices

        return plot_indices
    raise AttributeError(f"module 'sensitivity' has no attribute '{name}'")
