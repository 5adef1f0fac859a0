"""Envelopes of one question after another, each followed from the one before as long as they differ little."""

import ctypes

import numpy as np
from numpy.typing import ArrayLike

from gtm_fmu.airframe.names import FAILURE, TRIM_UNKNOWNS, TWO_THROTTLE_UNKNOWNS
from gtm_fmu.core.library import address, library, rows


def memory_size() -> int:
    """Length of a ``gtm_envelope_memory`` in numbers."""
    size = library().gtm_envelope_memory_size
    size.restype = ctypes.c_long
    return int(size())


class FollowedEnvelope:
    """V_min and V_max after a failure, as FMUs are told it.

    Args:
        lower, upper: bounds (9 each) of the undamaged aircraft's unknowns; those of V, beta and psi_dot are used.
    """

    def __init__(self, lower: ArrayLike, upper: ArrayLike):
        self._bounds = rows(lower, len(TRIM_UNKNOWNS), "lower"), rows(upper, len(TRIM_UNKNOWNS), "upper")
        self._memory = np.zeros(memory_size())

    def ends(self, case: ArrayLike, failure: ArrayLike, is_followed: bool = True) -> np.ndarray:
        """The trims at V_min and V_max (2, 10), all zero where there is no envelope.

        Args:
            case: altitude in ft, gamma in rad, lower and upper limit of the rudder in deg.
            failure: numbers in the order of `names.FAILURE`.
            is_followed: False seeks the ends anew, and remembers nothing.

        Raises:
            ValueError: the failure is none that the core takes.
        """
        case, failure = rows(case, 4, "case"), rows(failure, len(FAILURE), "failure")
        ends = np.zeros((2, len(TWO_THROTTLE_UNKNOWNS)))
        memory = address(self._memory) if is_followed else None
        given = (address(case), address(failure), *map(address, self._bounds))
        if fault := library().gtm_failure_envelope(*given, memory, address(ends)):
            raise ValueError(f"Fault {fault} of gtm_failure.h.")
        return ends
