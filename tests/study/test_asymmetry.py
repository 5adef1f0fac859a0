"""Mirrored failures have other envelopes, because the centre of gravity lies beside the plane of symmetry."""

import ctypes
from collections.abc import Iterator

import numpy as np
import pytest

from gtm_fmu.core import configuration as core
from gtm_fmu.core.configuration import Configuration
from gtm_fmu.core.library import library
from gtm_fmu.envelope import envelope
from gtm_fmu.failures import ControlLimits, Failure
from study.asymmetry import differences

CASES = 40


@pytest.fixture(scope="module")
def centred() -> Iterator[Configuration]:
    """The study's airframe with its centre of gravity on the plane of symmetry, which no setting of ours moves."""
    moved = Configuration(runway_altitude_ft=0.0)  # of no account without wind; the core's struct is its own
    struct = core._struct(moved)
    doubles = library().gtm_configuration_size() // ctypes.sizeof(ctypes.c_double)
    numbers = np.ctypeslib.as_array((ctypes.c_double * doubles).from_address(ctypes.addressof(struct)))
    to_the_left = -0.1416 / 12  # ft (SPEC 3)
    places = numbers == to_the_left
    assert struct.cg[1] == to_the_left
    numbers[places] = 0.0
    yield moved
    numbers[places] = to_the_left


def test_with_a_centred_cg_mirrored_failures_nearly_agree(centred):
    """methods/ENVELOPE.md: V_min differs by 0.18 kn in the median; what is left of it is the engines' toe."""
    as_it_is, with_it_centred = differences(CASES), differences(CASES, centred)
    assert len(as_it_is) == len(with_it_centred) > 25
    assert np.median(as_it_is[:, 0]) == pytest.approx(0.18, abs=0.06)
    assert np.median(with_it_centred[:, 0]) < 0.04
    assert with_it_centred[:, 0].max() < 0.3 < as_it_is[:, 0].max()
    assert with_it_centred[:, 1].max() < 0.8


def test_one_failure_differs_by_over_thirteen_knots(centred):
    """methods/ENVELOPE.md: up to 13.6 kn, where the aileron at its limit ends slow flight."""

    def apart(configuration: Configuration) -> float:
        jams = (ControlLimits(rudder_deg=(jam, jam)) for jam in (-22.390974, 22.390974))
        left, right = (envelope(25943.349, -4.40535848, Failure(limits, configuration)).v_min_kt for limits in jams)
        return abs(left - right)

    assert apart(Configuration()) == pytest.approx(13.67, abs=0.05)
    assert apart(centred) < 0.3
