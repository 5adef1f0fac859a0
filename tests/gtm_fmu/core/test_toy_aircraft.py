"""The toy that the solver is tested with is its closed form."""

import numpy as np

from tests.gtm_fmu.core.toy_aircraft import NT, SCALE, accelerations, manoeuvres


def test_the_toy_is_its_closed_form(toy):
    """And its slopes are those of differences."""
    for y in manoeuvres(20):
        F, J = accelerations(toy, y)
        np.testing.assert_allclose(F, 0, atol=1e-11)
        for k in range(NT):
            step = 1e-6 * SCALE * (np.arange(NT) == k)
            difference = (accelerations(toy, y + step)[0] - accelerations(toy, y - step)[0]) / (2 * step[k])
            np.testing.assert_allclose(J[:, k], difference, rtol=1e-6, atol=1e-6 * np.abs(J).max())
