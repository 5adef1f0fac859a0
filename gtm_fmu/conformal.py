"""Bounds with a promise for a finite sample: one-sided split-conformal prediction.

Let s_1 .. s_n be the scores of n calibration cases and s that of one new case, all drawn independently from one
distribution. The new score is as likely to have any rank as any other, so it exceeds the k-th largest of the n with a
probability of at most k / (n + 1). With k = floor(epsilon (n + 1)) that is at most epsilon, whatever the distribution
and whatever the model. The probability is over the draw of the calibration and of the new case together; with the
calibration held, the share of new cases that exceed is Beta(k, n + 1 - k) distributed, around epsilon.

A score is how far a prediction errs on the unsafe side, infinite where it promises what does not exist. Cases whose
errors differ are grouped, and each group has a quantile of its own: the promise then holds in each of them.
"""

from fractions import Fraction
from math import ceil, floor

import numpy as np
from numpy.typing import ArrayLike

from gtm_fmu.errors import InputError

EPSILON = 0.001
"""Probability of a broken promise, where none is given."""


def least_cases(epsilon: float) -> int:
    """Number of calibration cases from which on a promise may be broken with a probability of epsilon only.

    Raises:
        InputError: epsilon is no probability between 0 and 1.
    """
    return ceil(1 / _exactly(epsilon)) - 1


def margin(scores: ArrayLike, epsilon: float = EPSILON) -> float:
    """What one new score exceeds with a probability of at most epsilon.

    Args:
        scores: of the calibration cases (n); infinite ones count.
        epsilon: the probability.

    Raises:
        InputError: fewer scores than `least_cases`, one that is no number, or epsilon outside 0 .. 1.
    """
    values = np.asarray(scores, dtype=float).ravel()
    if np.isnan(values).any():
        raise InputError("A score of the calibration is no number; leave that case out, or count it as infinite.")
    needed = least_cases(epsilon)
    if len(values) < needed:
        raise InputError(
            f"{len(values)} calibration cases cannot carry epsilon = {epsilon:g}, which needs {needed}: give more, or "
            f"an epsilon of at least {1 / (len(values) + 1):.3g}."
        )
    rank = floor(_exactly(epsilon) * (len(values) + 1))
    return float(np.partition(values, len(values) - rank)[len(values) - rank])


def _exactly(epsilon: float) -> Fraction:
    """The decimal number that was written, without its rounding: 0.001 of 999 + 1 cases is one."""
    if not 0 < epsilon < 1:
        raise InputError(f"epsilon was given as {epsilon:g}; it is a probability: give a number between 0 and 1.")
    return Fraction(repr(float(epsilon)))
