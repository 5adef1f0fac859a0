"""Units in which linear models are judged: typical sizes of states and inputs, and the least that controls them."""

STATE_SCALE = (10.0, 10.0, 10.0, 0.2, 0.2, 0.2, 0.2, 0.2)
"""ft/s, rad/s, rad, in the order of `names.LINEAR_STATES`."""

INPUT_SCALE = (10.0, 10.0, 10.0, 30.0)
"""deg, %, in the order of `names.CONTROLS`; the throttle of one engine has that of both."""

PBH_THRESHOLD = 1e-3
"""Least singular value of a scaled PBH matrix of a mode that is controllable."""
