"""The thrust map as the core takes it. It also runs inside FMUs: standard library only."""

import ctypes

RESULTS = ("v_min", "v_max", "v_min_std", "v_max_std", "spare_thrust", "is_fold")
"""Numbers of ``gtm_map_envelope``."""
GROUPS = ("jams", "ranges", "jams at folds", "ranges at folds")
"""Cases whose errors differ, in the order of ``gtm_map_groups``."""
SAFE_ENDS = ("v_min", "v_max")
"""Numbers of ``gtm_safe_ends``."""


class CoreMap(ctypes.Structure):
    """``gtm_thrust_map`` of thrust_map.h: numbers of nodes, addresses of the arrays, constants."""

    _fields_ = (
        *((name, ctypes.c_long) for name in ("densities", "paths", "deflections", "speeds")),
        *((name, ctypes.c_void_p) for name in ("density", "gamma", "deflection", "reach", "table")),
        *((name, ctypes.c_double) for name in ("full_thrust", "tolerance", "tolerance_deviations")),
        *((name, ctypes.c_double) for name in ("bend_share", "least_deviation", "reach_tolerance")),
    )
