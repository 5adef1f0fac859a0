"""Distributions from SALib's problem dictionaries, where those suffice: independent inputs."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from scipy import stats

from .distributions import Distribution, Uniform
from .marginals import Marginal

LAWS: dict[str, tuple[tuple[int, ...], Callable[..., Any]]] = {
    "logunif": ((2,), lambda lower, upper: stats.loguniform(lower, upper)),
    "triang": ((3,), lambda lower, upper, peak: stats.triang(peak, lower, upper - lower)),
    "norm": ((2,), lambda mean, deviation: stats.norm(mean, deviation)),
    "truncnorm": (
        (4,),
        lambda lower, upper, mean, deviation: stats.truncnorm(
            (lower - mean) / deviation, (upper - mean) / deviation, mean, deviation
        ),
    ),
    "lognorm": ((2,), lambda mean, deviation: stats.lognorm(deviation, scale=np.exp(mean))),
    "weibull": ((2, 3), lambda shape, scale, start=0.0: stats.weibull_min(shape, start, scale)),
}
"""How many numbers SALib 1.6 takes as the bounds of a law, and what they mean; "unif" beside them."""


def from_salib(problem: Mapping[str, Any]) -> tuple[Distribution, tuple[tuple[str, ...], ...]]:
    """The distribution of a problem, and its groups of several inputs.

    Args:
        problem: ``names``, ``bounds`` and, where given, ``dists`` and ``groups``, as SALib defines them.

    Raises:
        ValueError: a missing entry, lengths that differ, a law that is not known, or numbers that it does not take.
    """
    try:
        names, bounds = list(problem["names"]), [tuple(map(float, pair)) for pair in problem["bounds"]]
    except (KeyError, TypeError):
        raise ValueError("A SALib problem needs 'names' and 'bounds': give a dictionary with both.") from None
    dists = list(problem.get("dists") or ["unif"] * len(names))
    groups = list(problem.get("groups") or names)
    if not len(names) == len(bounds) == len(dists) == len(groups):
        raise ValueError(
            f"The problem has {len(names)} names, {len(bounds)} bounds, {len(dists)} dists and {len(groups)} groups: "
            "give as many of each."
        )
    blocks = [_input(name, kind, numbers) for name, kind, numbers in zip(names, dists, bounds, strict=True)]
    members = {group: tuple(n for n, g in zip(names, groups, strict=True) if g == group) for group in groups}
    return Distribution(blocks), tuple(group for group in members.values() if 1 < len(group) < len(names))


def _input(name: str, kind: str, numbers: tuple[float, ...]) -> Uniform | Marginal:
    counts, law = LAWS.get(kind, ((2,), None))
    if law is None and kind != "unif":
        raise ValueError(f"The law of {name} is {kind!r}: choose one of unif, {', '.join(LAWS)}.")
    if len(numbers) not in counts:
        raise ValueError(f"{name} ({kind}) has {len(numbers)} bounds: give {' or '.join(map(str, counts))}.")
    return Uniform(name, numbers[0], numbers[1]) if law is None else Marginal(name, law(*numbers))
