"""Margins that make the speeds of a map safe to use: V_min never too low, V_max never too high.

Each case of the map belongs to a group: whether it is flagged as a fold, and whether the control is jammed or holds a
range. The score of an end is how far it errs on the unsafe side, in standard deviations that the map tells; it is
infinite where the map finds an envelope and there is none. The margin of a group is a split-conformal quantile of these
scores (`gtm_fmu.conformal`), never below zero, so that the safe envelope lies inside the predicted one:

    P(V_min_safe >= V_min and V_min exists) >= 1 - epsilon,    P(V_max_safe <= V_max and V_max exists) >= 1 - epsilon,

each over the draw of the calibration cases and of one new case of the same group and distribution. Nothing is promised
of a case with less thrust to spare than the map's tolerance, as whether it has an envelope is in doubt, nor outside the
map.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from gtm_fmu import conformal
from gtm_fmu.core.map_layout import GROUPS, SAFE_ENDS
from gtm_fmu.errors import InputError

EPSILONS = (0.1, 0.05, 0.02, 0.01, 0.005, 0.002, 0.001, 0.0005, 0.0002, 0.0001)
"""Levels at which margins are kept."""


@dataclass(frozen=True, eq=False)
class SafeMargins:
    """Margins of a map at the levels of `EPSILONS`.

    Attributes:
        margins: (levels, groups, 2) of V_min and V_max in standard deviations, from the group and level on infinite
            where nothing can be promised. Groups follow `map_layout.GROUPS`.
        cases: (groups) calibration cases of each.

    Raises:
        InputError: arrays of other shapes, or margins that are negative or no numbers.
    """

    margins: np.ndarray
    cases: np.ndarray

    def __post_init__(self) -> None:
        """Hold the arrays unchangeable."""
        for name, dtype, shape in (
            ("margins", np.float64, (len(EPSILONS), len(GROUPS), len(SAFE_ENDS))),
            ("cases", np.int64, (len(GROUPS),)),
        ):
            array = np.array(getattr(self, name), dtype=dtype, order="C")
            if array.shape != shape or not (array >= 0).all():
                raise InputError(f"Safe margins have {name} of the shape {shape}, none negative; these do not.")
            array.setflags(write=False)
            object.__setattr__(self, name, array)

    @classmethod
    def of_scores(cls, scores: ArrayLike, group: ArrayLike) -> "SafeMargins":
        """Margins by the scores (n, 2) of calibration cases and their groups (n)."""
        scores, group = np.asarray(scores, dtype=float), np.asarray(group)
        margins = np.full((len(EPSILONS), len(GROUPS), len(SAFE_ENDS)), np.inf)
        for g in range(len(GROUPS)):
            mine = scores[group == g]
            for level, epsilon in enumerate(EPSILONS):
                if len(mine) >= conformal.least_cases(epsilon):
                    margins[level, g] = [max(conformal.margin(end, epsilon), 0.0) for end in mine.T]
        return cls(margins, np.bincount(group, minlength=len(GROUPS)))

    def at(self, epsilon: float = conformal.EPSILON) -> np.ndarray:
        """Margins (groups, 2) that are exceeded with a probability of at most epsilon, at the next stricter level.

        Raises:
            InputError: epsilon is stricter than any level that is kept, or than what the calibration can carry.
        """
        needed = conformal.least_cases(epsilon)
        level = next((k for k, kept in enumerate(EPSILONS) if kept <= epsilon), None)
        if level is None or self.cases.max() < needed:
            raise InputError(
                f"epsilon was given as {epsilon:g}, which needs {needed} calibration cases a group; the largest group "
                f"of this map has {self.cases.max()}, and margins are kept down to {EPSILONS[-1]:g}: give a larger one."
            )
        return self.margins[level]
