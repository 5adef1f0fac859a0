"""Split-conformal margins: their rank by hand, their promise by draws, and what a small sample cannot promise."""

import math

import numpy as np
import pytest

from gtm_fmu.conformal import EPSILON, least_cases, margin
from gtm_fmu.errors import InputError


@pytest.mark.parametrize(
    ("n", "epsilon", "rank"),
    [(999, 0.001, 1), (1998, 0.001, 1), (1999, 0.001, 2), (9, 0.1, 1), (99, 0.07, 7), (19, 0.5, 10)],
)
def test_the_rank_by_hand(n, epsilon, rank):
    """The k-th largest of n scores, k the largest whole number with k / (n + 1) <= epsilon."""
    scores = np.random.default_rng(0).permutation(n)
    assert margin(scores, epsilon) == n - rank


@pytest.mark.parametrize(("epsilon", "cases"), [(0.001, 999), (0.0001, 9999), (0.05, 19), (0.3, 3), (0.5, 1)])
def test_a_small_sample_is_refused(epsilon, cases):
    assert least_cases(epsilon) == cases
    margin(np.zeros(cases), epsilon)
    with pytest.raises(InputError, match=rf"^{cases - 1} calibration cases cannot carry .* needs {cases}:"):
        margin(np.zeros(cases - 1), epsilon)


def test_infinite_scores_count():
    """A promise of what does not exist is broken at any margin, unless that is rarer than epsilon."""
    scores = np.zeros(1999)
    scores[:1] = math.inf
    assert margin(scores, EPSILON) == 0
    scores[:2] = math.inf
    assert margin(scores, EPSILON) == math.inf


def test_what_is_no_score():
    with pytest.raises(InputError, match="no number"):
        margin([0.0, math.nan], 0.5)
    for epsilon in (0.0, 1.0, -0.1, math.nan):
        with pytest.raises(InputError, match="between 0 and 1"):
            margin([0.0], epsilon)


def test_the_promise_over_many_draws():
    """10 000 calibrations of 39 scores and a new one each: epsilon = 0.05 is k / (n + 1) = 2 / 40 exactly.

    The count of broken promises is binomial: its standard deviation is sqrt(10 000 x 0.05 x 0.95) = 22.
    """
    draws = np.random.default_rng(1).standard_cauchy((10000, 40))
    broken = sum(new > margin(scores, 0.05) for *scores, new in draws.tolist())
    assert abs(broken - 500) < 4 * 22
