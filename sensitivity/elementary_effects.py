"""Elementary effects (Morris 1991; Campolongo, Cariboni, Saltelli 2007): many one-at-a-time steps, a cheap first look.

From each of r starting points every input is moved once, the others staying where they are, and the effect is

    EE_i = [f(x + step_i) - f(x)] / step_i      mu_i = mean EE_i,  mu*_i = mean |EE_i|,  sigma_i = their deviation

With dependent inputs a step must not leave the domain: its sign is chosen so that it does not, and it is halved where
neither sign serves. An effect is no conditional expectation: it asks what happens if one input alone could be moved.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike
from scipy.stats import qmc

from .distributions import Array, Distribution
from .outputs import checked_outputs, evaluate_in_chunks
from .redraw_ratios import Estimate, check_interval
from .result import Result

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Scaling = Literal["range", "paper", "none"]
_HALVINGS = 40


@dataclass(frozen=True, eq=False)
class EffectsDesign:
    """Points (r (M + 1), M) at which a model is to be evaluated: r groups of a start and one point an input.

    In a radial design every step is taken from the start, in a trajectory from the point before it. `moved[k]` tells
    in which order the inputs of group k are moved.
    """

    distribution: Distribution
    points: Array
    moved: np.ndarray
    radial: bool
    seed: int

    @property
    def repetitions(self) -> int:
        """Number r of groups."""
        return len(self.moved)

    def evaluate(
        self, model: Callable[[Array], ArrayLike], output_names: Sequence[str] | None = None, **options: Any
    ) -> "ElementaryEffects":
        """Evaluate a model of points (n, M) with outputs `output_names`, (n,) or (n, outputs); options as `effects`."""
        return self.effects(evaluate_in_chunks(model, self.points), output_names, **options)

    def effects(
        self,
        outputs: ArrayLike,
        output_names: Sequence[str] | None = None,
        *,
        scaling: Scaling = "range",
        confidence: float = 0.95,
        n_bootstrap: int = 1000,
        seed: int = 0,
    ) -> "ElementaryEffects":
        """The effects from outputs (n,) or (n, outputs) at the design's points, in their order.

        Args:
            outputs: one row for each point.
            output_names: default y0, y1, ...
            scaling: "range": times the input's range, so that effects of different inputs compare. "paper": times
                I0 / f(I0) at the start of the step (paper eq. 47), which vanishes where the input is 0 and is infinite
                where the output is. "none": in units of output over input.
            confidence: of the intervals.
            n_bootstrap: resamples of the groups, for the intervals.
            seed: of the resamples.

        Raises:
            ValueError: outputs of another shape or not finite, or a scaling that is not known.
        """
        check_interval(confidence, n_bootstrap)
        names, values = checked_outputs(outputs, self.points, output_names)
        r, m = self.moved.shape
        y, x = values.reshape(r, m + 1, -1), self.points.reshape(r, m + 1, m)
        before = np.zeros((r, m), dtype=int) if self.radial else np.tile(np.arange(m), (r, 1))
        rows = np.arange(r)[:, np.newaxis]
        steps = (x[:, 1:] - x[rows, before])[rows, np.arange(m), self.moved]
        ratios = (y[:, 1:] - y[rows, before]) / steps[..., np.newaxis]
        effects = np.empty_like(ratios)
        effects[rows, self.moved] = ratios
        if scaling == "range":
            effects = effects * np.ptp(self.distribution.bounds, axis=1)[:, np.newaxis]
        elif scaling == "paper":
            factor = np.empty_like(ratios)
            base_x = x[rows, before][rows, np.arange(m), self.moved]
            with np.errstate(divide="ignore", invalid="ignore"):
                factor[rows, self.moved] = base_x[..., np.newaxis] / y[rows, before]
                effects = effects * factor
            if not np.isfinite(effects).all():
                raise ValueError(
                    "An output is 0 at a start, where the paper's scaling I0 / f(I0) is infinite: use 'range'."
                )
        elif scaling != "none":
            raise ValueError(f"Scaling is {scaling!r}: choose 'range', 'paper' or 'none'.")
        return _summary(self, names, effects, scaling, confidence, n_bootstrap, seed)


@dataclass(frozen=True, eq=False)
class ElementaryEffects(Result):
    """Mean, mean absolute and deviation of the effects (inputs, outputs), and the effects (r, inputs, outputs).

    Attributes:
        mu: cancels where effects have both signs.
        mu_star: the strength of an input.
        sigma: its interactions and nonlinearity.
        effects: what they are made of.
    """

    design: EffectsDesign
    output_names: tuple[str, ...]
    effects: Array
    scaling: Scaling
    mu: Estimate
    mu_star: Estimate
    sigma: Estimate
    confidence: float

    kinds = ("mu", "mu_star", "sigma")

    @property
    def row_names(self) -> tuple[str, ...]:
        """The inputs."""
        return self.names

    @property
    def names(self) -> tuple[str, ...]:
        """The inputs of the design."""
        return self.design.distribution.names

    def plot(self, **options: Any) -> "Figure":
        """The plane of mean and deviation (needs matplotlib); options as `plots.plot_effects`."""
        from .plots import plot_effects

        return plot_effects(self, **options)

    def to_dict(self) -> dict[str, Any]:
        """Plain dictionaries and numbers, ready for JSON."""
        return {
            "definition": "EE = step of the output / step of the input; mu, mu_star, sigma over the repetitions",
            "scaling": self.scaling,
            "design": "radial" if self.design.radial else "trajectory",
            "repetitions": self.design.repetitions,
            "evaluations": len(self.design.points),
            "seed": self.design.seed,
            "confidence": self.confidence,
            "outputs": self.by_output(),
        }


def effects_design(
    distribution: Distribution,
    repetitions: int,
    *,
    radial: bool = False,
    step: float = 0.25,
    seed: int = 0,
) -> EffectsDesign:
    """Starts by a Latin hypercube, and from each a step of every input.

    Args:
        distribution: bounded inputs.
        repetitions: number r of starts; r (M + 1) evaluations.
        radial: every step from the start; else a trajectory, each step from the point before.
        step: part of an input's range that it is moved by.
        seed: of starts, orders and signs.

    Raises:
        ValueError: an unbounded input, fewer than 2 repetitions, a step outside 0 .. 1, or an input that cannot move
            alone.
    """
    bounds = np.array(distribution.bounds)
    for name, (lower, upper) in zip(distribution.names, bounds, strict=True):
        if not np.isfinite([lower, upper]).all():
            raise ValueError(f"{name} is unbounded, and a step needs a range: give a truncated law.")
    if repetitions < 2:
        raise ValueError(f"{repetitions} repetitions have no deviation: give at least 2, and 50 for narrow intervals.")
    if not 0.0 < step < 1.0:
        raise ValueError(f"The step is {step:g} of the range: give a part between 0 and 1.")
    rng = np.random.default_rng(seed)
    m = len(distribution.names)
    start = distribution.sample(qmc.LatinHypercube(m, rng=rng).random(repetitions).clip(0.0, 1.0 - 2.0**-53))
    moved = rng.permuted(np.tile(np.arange(m), (repetitions, 1)), axis=1)
    signs = rng.choice((-1.0, 1.0), size=moved.shape)
    points = [start]
    for k in range(m):
        origin = start if radial else points[-1]
        points.append(_stepped(distribution, origin, moved[:, k], signs[:, k], step * np.ptp(bounds, axis=1)))
    stacked = np.stack(points, axis=1).reshape(-1, m)
    stacked.flags.writeable = False
    return EffectsDesign(distribution, stacked, moved, radial, seed)


def _stepped(distribution: Distribution, origin: Array, moved: np.ndarray, sign: Array, step: Array) -> Array:
    """Points (r, M) with one input of each moved, inside the domain."""
    rows = np.arange(len(origin))
    found, open_rows = origin.copy(), rows
    for halving in range(_HALVINGS):
        for direction in (1.0, -1.0):
            tried = origin[open_rows]
            column = moved[open_rows]
            tried[np.arange(len(tried)), column] += direction * sign[open_rows] * step[column] / 2**halving
            inside = distribution.contains(tried)
            found[open_rows[inside]] = tried[inside]
            open_rows = open_rows[~inside]
            if not open_rows.size:
                return found
    name = distribution.names[moved[open_rows[0]]]
    raise ValueError(
        f"{name} cannot be moved alone at {origin[open_rows[0]].tolist()}: the others fix it; use variance indices."
    )


def _summary(
    design: EffectsDesign,
    names: tuple[str, ...],
    effects: Array,
    scaling: Scaling,
    confidence: float,
    n_bootstrap: int,
    seed: int,
) -> ElementaryEffects:
    r = len(effects)
    half = effects[: max(r // 2, 2)]
    choice = np.random.default_rng(seed).integers(r, size=(n_bootstrap, r))
    statistics: dict[str, Callable[[Array], Array]] = {
        "mu": lambda ee: ee.mean(axis=0),
        "mu_star": lambda ee: np.abs(ee).mean(axis=0),
        "sigma": lambda ee: ee.std(axis=0, ddof=1),
    }
    tails = (0.5 - confidence / 2.0, 0.5 + confidence / 2.0)
    estimates = {}
    for name, statistic in statistics.items():
        spread = np.array([statistic(effects[rows]) for rows in choice])
        lower, upper = np.quantile(spread, tails, axis=0)
        value = statistic(effects)
        estimates[name] = Estimate(value, lower, upper, spread.std(axis=0, ddof=1), value - statistic(half))
    return ElementaryEffects(design, names, effects, scaling, **estimates, confidence=confidence)
