"""Variance-based sensitivity analysis of any model, with independent or dependent inputs.

distribution = Distribution([Uniform("x", 0, 1), OrderedUniform(("low", "high"), -1, 1)])
evaluated = variance_design(distribution, 2**14).evaluate(model, output_names=["y"])
indices = variance_indices(evaluated)
figure = plot_indices(indices)
"""

from .design import Design, EvaluatedDesign, variance_design
from .distributions import Block, Distribution, OrderedUniform, Uniform
from .indices import Estimate, Identity, VarianceIndices, variance_indices
from .plots import plot_indices

__all__ = [
    "Block",
    "Design",
    "Distribution",
    "Estimate",
    "EvaluatedDesign",
    "Identity",
    "OrderedUniform",
    "Uniform",
    "VarianceIndices",
    "plot_indices",
    "variance_design",
    "variance_indices",
]
