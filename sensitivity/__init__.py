"""Sensitivity analysis of any model whose inputs may depend on each other.

distribution = Distribution([Uniform("x", 0, 1), OrderedUniform(("low", "high"), -1, 1)])
evaluated = variance_design(distribution, 2**14).evaluate(model, output_names=["y"])
indices = variance_indices(evaluated)
print(indices.to_df())
figure = indices.plot()

It needs NumPy and SciPy; figures need matplotlib, which is imported when one is drawn.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from . import test_functions
from .convergence import Convergence, convergence, variance_indices_until
from .correlated import Gaussian, GaussianCopula
from .description import described_distribution, read_distribution
from .design import Design, EvaluatedDesign, variance_design
from .distributions import Block, Density, Distribution, OrderedUniform, Uniform
from .elementary_effects import EffectsDesign, ElementaryEffects, effects_design
from .empirical import Empirical
from .full_independent import FullIndependentIndices, full_independent_indices
from .given_data import GivenDataIndices, given_data_indices
from .indices import Identity, VarianceIndices, variance_indices
from .interactions import Interactions, interaction_design, interactions
from .marginals import Marginal, PointMass
from .mixtures import Equal, Mixture, ordered_with_jams
from .moment_free import PawnIndices, pawn_indices
from .redraw_ratios import Estimate
from .rejection import Conditioned, conditioned
from .salib_problem import from_salib
from .shapley import ShapleyDesign, ShapleyEffects, shapley_design, shapley_effects
from .simplex import Simplex
from .tabulated import TabulatedIndices, tabulated_indices

if TYPE_CHECKING:
    from .plots import plot_bars, plot_convergence, plot_effects, plot_pairs

_PLOTS = ("plot_bars", "plot_convergence", "plot_effects", "plot_pairs")

__all__ = [
    "Block",
    "Conditioned",
    "Convergence",
    "Density",
    "Design",
    "Distribution",
    "EffectsDesign",
    "ElementaryEffects",
    "Empirical",
    "Equal",
    "Estimate",
    "EvaluatedDesign",
    "FullIndependentIndices",
    "Gaussian",
    "GaussianCopula",
    "GivenDataIndices",
    "Identity",
    "Interactions",
    "Marginal",
    "Mixture",
    "OrderedUniform",
    "PawnIndices",
    "PointMass",
    "ShapleyDesign",
    "ShapleyEffects",
    "Simplex",
    "TabulatedIndices",
    "Uniform",
    "VarianceIndices",
    "conditioned",
    "convergence",
    "described_distribution",
    "effects_design",
    "from_salib",
    "full_independent_indices",
    "given_data_indices",
    "interaction_design",
    "interactions",
    "ordered_with_jams",
    "pawn_indices",
    "plot_bars",
    "plot_convergence",
    "plot_effects",
    "plot_pairs",
    "read_distribution",
    "shapley_design",
    "shapley_effects",
    "tabulated_indices",
    "test_functions",
    "variance_design",
    "variance_indices",
    "variance_indices_until",
]


def __getattr__(name: str) -> Any:
    """Figures bring matplotlib, so they are imported when one is asked for."""
    if name in _PLOTS:
        return getattr(import_module(".plots", __name__), name)
    raise AttributeError(f"module 'sensitivity' has no attribute '{name}'")
