"""Names and order of states, controls and outputs; every array, FMU variable and matrix follows them."""

STATES = ("u", "v", "w", "p", "q", "r", "latitude", "longitude", "altitude", "phi", "theta", "psi")
"""ft/s, rad/s, rad, rad, ft, rad (SPEC 1)."""

LINEAR_STATES = ("u", "v", "w", "p", "q", "r", "phi", "theta")
"""The states that a steady manoeuvre keeps constant: those of a linear model (paper eq. 7)."""

CONTROLS = ("elevator", "aileron", "rudder", "throttle")
"""deg, deg, deg, % (SPEC 4)."""

FULL_CONTROLS = ("elevator", "aileron", "rudder", "throttle_left", "throttle_right")
"""Those of any configuration: the engines have a throttle each."""

OUTPUTS = (
    "tas",
    "eas",
    "alpha",
    "beta",
    "mach",
    "dynamic_pressure",
    "gamma",
    "track",
    "load_x",
    "load_y",
    "load_z",
    "thrust_left",
    "thrust_right",
    "rotor_speed_left",
    "rotor_speed_right",
)
"""kt, kt, deg, deg, -, lbf/ft^2, deg, deg, g, g, g, lbf, lbf, %, % (SPEC 8)."""

LOOKUPS = ("alpha", "beta", "p_hat", "q_hat", "r_hat", "omega_hat", "elevator", "aileron", "rudder")
"""Arguments of the aerodynamic tables: deg, deg, four normalised rates, three deflections in deg (SPEC 5)."""

COEFFICIENTS = ("CX", "CY", "CZ", "Cl", "Cm", "Cn")
"""Body axes, x forward, y right, z down (SPEC 1)."""

TRIM_UNKNOWNS = ("V", "alpha", "beta", "psi_dot", "phi", "elevator", "aileron", "rudder", "throttle")
"""A steady manoeuvre at given altitude and flight-path angle: ft/s, rad, rad, rad/s, rad, deg, deg, deg, %."""

FULL_TRIM_UNKNOWNS = (*TRIM_UNKNOWNS[: -len(CONTROLS)], *FULL_CONTROLS)
"""Those of any configuration."""
