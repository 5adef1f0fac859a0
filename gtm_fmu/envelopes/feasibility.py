"""When an envelope exists: the rule of feasibility by t_min, for exact numbers and for what a model says."""

import numpy as np
from numpy.typing import ArrayLike

from gtm_fmu.aircraft.ranges import WIDEST

FULL_THROTTLE_PCT = WIDEST["throttle_pct"][1]
OPTIMUM_PCT = 1e-6
"""As near to its limit as an optimum of the throttle is."""


def has_envelope(t_min_pct: ArrayLike, most_pct: float = FULL_THROTTLE_PCT, tolerance_pct: float = 0.0) -> np.ndarray:
    """Whether a steady manoeuvre exists: its least throttle t_min is no more than the throttle that is left.

    Args:
        t_min_pct: in % (n); NaN where no throttle at all would do.
        most_pct: the throttle that is left.
        tolerance_pct: `OPTIMUM_PCT` for a t_min of the solver.
    """
    return np.asarray(t_min_pct) <= most_pct + tolerance_pct
