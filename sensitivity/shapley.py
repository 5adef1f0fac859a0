"""Shapley effects (Owen 2014; Song, Nelson, Staum 2016): the variance shared out among inputs that may depend.

An input's effect is what it adds to the variance, in the mean over all orders in which the inputs could become unknown:

    Sh_i = mean over orders of [ST_(i and those before it) - ST_(those before it)],    ST_u = E[V(f | all but u)] / V(f)

The effects are never negative and sum to one, whatever the dependence. All subsets are evaluated for up to 8 inputs,
random orders beyond; the interval then holds the chance of the orders too.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import combinations
from math import comb
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from .design import Design, EvaluatedDesign, Factor, Sampling, redrawn_design
from .distributions import Array, Distribution
from .redraw_ratios import Combination, Estimate, RedrawRatios
from .result import Result

MOST_INPUTS_OF_ALL_SUBSETS = 8


@dataclass(frozen=True, eq=False)
class ShapleyDesign:
    """A design that redraws the subsets of inputs that the effects need, and the orders they come from.

    Attributes:
        orders: (k, M) numbers of the inputs; None: all subsets.
    """

    design: Design
    orders: np.ndarray | None

    @property
    def points(self) -> np.ndarray:
        """Where the model is to be evaluated (n_evaluations, M)."""
        return self.design.points

    def evaluate(
        self, model: Callable[[Array], ArrayLike], output_names: Sequence[str] | None = None, **options: Any
    ) -> "ShapleyEffects":
        """Evaluate a model with outputs `output_names`, (n,) or (n, outputs); options as `shapley_effects`."""
        return shapley_effects(self, self.design.evaluate(model, output_names), **options)


@dataclass(frozen=True, eq=False)
class ShapleyEffects(Result):
    """Shapley effects (inputs, outputs)."""

    design: Design
    orders: np.ndarray | None
    output_names: tuple[str, ...]
    effects: Estimate
    confidence: float

    kinds = ("effects",)

    @property
    def row_names(self) -> tuple[str, ...]:
        """The inputs."""
        return self.names

    @property
    def names(self) -> tuple[str, ...]:
        """The inputs."""
        return self.design.distribution.names

    def to_dict(self) -> dict[str, Any]:
        """Plain dictionaries and numbers, ready for JSON."""
        return {
            "definition": "Shapley effect: mean over orders of what an input adds to E[V(f | all but a subset)] / V(f)",
            "orders": "all" if self.orders is None else len(self.orders),
            "n_base": self.design.n_base,
            "n_evaluations": self.design.n_evaluations,
            "confidence": self.confidence,
            "outputs": {
                output: {name: self.effects.to_dict(i, j) for i, name in enumerate(self.names)}
                for j, output in enumerate(self.output_names)
            },
        }


def shapley_design(
    distribution: Distribution,
    n: int,
    *,
    orders: int | None = None,
    sampling: Sampling = "sobol",
    replicates: int = 8,
    seed: int = 0,
) -> ShapleyDesign:
    """Design for Shapley effects with N = n base rows: N 2^M evaluations, or about N M k with k random orders.

    Args:
        distribution: of the inputs.
        n: base rows.
        orders: number k, made even: every order comes with its reverse. Default: all subsets up to 8 inputs, else 4 M.
        sampling: "sobol", "latin" or "random", as of `variance_design`.
        replicates: independent samples that the rows are divided into, for the intervals.
        seed: of the random numbers.

    Raises:
        ValueError: fewer than 2 orders, or as `variance_design`.
    """
    names, m = distribution.names, len(distribution.names)
    if m < 2:
        raise ValueError(f"Effects share the variance out among at least two inputs, got {names}: add an input.")
    if orders is None and m <= MOST_INPUTS_OF_ALL_SUBSETS:
        chosen = None
        subsets = [subset for size in range(1, m) for subset in combinations(names, size)]
    else:
        count = 4 * m if orders is None else orders
        if count < 2:
            raise ValueError(f"{count} orders have no spread: give at least 2.")
        half = np.random.default_rng((seed, m)).permuted(np.tile(np.arange(m), ((count + 1) // 2, 1)), axis=1)
        chosen = np.concatenate([half, half[:, ::-1]])
        subsets = [_subset(names, order[:size]) for order in chosen for size in range(1, m)]
    singles = [(name,) for name in names]
    return ShapleyDesign(redrawn_design(distribution, singles, subsets, n, sampling, replicates, seed), chosen)


def shapley_effects(
    shapley: ShapleyDesign,
    evaluated: EvaluatedDesign,
    *,
    confidence: float = 0.95,
    n_bootstrap: int = 1000,
    seed: int = 0,
) -> ShapleyEffects:
    """The effects from an evaluated design; intervals as `variance_indices`, widened by the chance of the orders.

    Args:
        shapley: the design.
        evaluated: the same with its outputs.
        confidence: of the intervals.
        n_bootstrap: resamples of the rows, for the intervals.
        seed: of the random numbers.
    """
    ratios = RedrawRatios(evaluated, confidence, n_bootstrap, seed)
    names = evaluated.design.distribution.names
    if shapley.orders is None:
        effects = ratios.estimate([_over_all_subsets(ratios, names, name) for name in names])
    else:
        effects = _over_orders(ratios, names, shapley.orders, confidence)
    return ShapleyEffects(evaluated.design, shapley.orders, evaluated.output_names, effects, confidence)


def _over_all_subsets(ratios: RedrawRatios, names: Factor, name: str) -> Combination:
    """sum over u without i of |u|! (M - |u| - 1)! / M! [ST_(u and i) - ST_u]."""
    others, m = [other for other in names if other != name], len(names)
    found = Combination(0.0, {})
    for size in range(m):
        for subset in combinations(others, size):
            with_it = tuple(each for each in names if each in subset or each == name)
            found += 1.0 / (m * comb(m - 1, size)) * (ratios.total(with_it) - ratios.total(subset))
    return found


def _over_orders(ratios: RedrawRatios, names: Factor, orders: np.ndarray, confidence: float) -> Estimate:
    """Means over the orders; the error also holds that of a mean over pairs of an order and its reverse."""
    m, k = len(names), len(orders)
    steps: list[list[Combination]] = [[] for _ in names]
    for order in orders:
        before: Factor = ()
        for place, i in enumerate(order):
            now = _subset(names, order[: place + 1])
            steps[i].append(ratios.total(now) - ratios.total(before))
            before = now
    means = []
    for each in steps:
        total = Combination(0.0, {})
        for step in each:
            total += step
        means.append(1.0 / k * total)
    effects = ratios.estimate(means)
    every = ratios.estimate([step for one in steps for step in one]).value.reshape(m, 2, k // 2, -1)
    by_chance = every.mean(axis=1).std(axis=1, ddof=1) / np.sqrt(k // 2) if k > 2 else np.zeros_like(effects.value)
    error = np.hypot(effects.standard_error, by_chance)
    wider = error / np.where(effects.standard_error > 0.0, effects.standard_error, 1.0)
    return Estimate(
        effects.value,
        effects.value - wider * (effects.value - effects.lower),
        effects.value + wider * (effects.upper - effects.value),
        error,
        effects.change_on_doubling,
    )


def _subset(names: Factor, chosen: Sequence[int]) -> Factor:
    return tuple(names[i] for i in sorted(chosen))
