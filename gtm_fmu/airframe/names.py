"""Names and order of states, controls and outputs; every array, FMU variable and matrix follows them."""

STATES = ("u", "v", "w", "p", "q", "r", "latitude", "longitude", "altitude", "phi", "theta", "psi")
"""ft/s, rad/s, rad, rad, ft, rad (SPEC 1)."""

LINEAR_STATES = ("u", "v", "w", "p", "q", "r", "phi", "theta")
"""The states that a steady manoeuvre keeps constant: those of a linear model (paper eq. 7)."""

ACCELERATED = STATES[:6]
"""Those whose rates, the six accelerations, a trim makes zero (paper eq. 6)."""

CONTROLS = ("elevator", "aileron", "rudder", "throttle")
"""deg, deg, deg, % (SPEC 4)."""


def state_variable(name: str) -> str:
    """Name of a state in an FMU."""
    return f"state.{name}"


def control_variable(name: str) -> str:
    """Name of a control in an FMU."""
    return f"control.{name}"


TWO_THROTTLE_CONTROLS = ("elevator", "aileron", "rudder", "throttle_left", "throttle_right")
"""With a throttle for each engine."""

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
"""kn, kn, deg, deg, -, lbf/ft^2, deg, deg, g, g, g, lbf, lbf, %, % (SPEC 8)."""

LOOKUPS = ("alpha", "beta", "p_hat", "q_hat", "r_hat", "omega_hat", "elevator", "aileron", "rudder")
"""Arguments of the aerodynamic tables: deg, deg, four normalised rates, three deflections in deg (SPEC 5)."""

COEFFICIENTS = ("CX", "CY", "CZ", "Cl", "Cm", "Cn")
"""Body axes, x forward, y right, z down (SPEC 1)."""

TRIM_UNKNOWNS = ("V", "alpha", "beta", "psi_dot", "phi", "elevator", "aileron", "rudder", "throttle")
"""A steady manoeuvre at given altitude and flight-path angle: ft/s, rad, rad, rad/s, rad, deg, deg, deg, %."""

V, ALPHA, BETA, PSI_DOT, PHI, ELEVATOR, AILERON, RUDDER, THROTTLE = range(len(TRIM_UNKNOWNS))
"""Their places."""

TWO_THROTTLE_UNKNOWNS = (*TRIM_UNKNOWNS[: -len(CONTROLS)], *TWO_THROTTLE_CONTROLS)
"""With a throttle for each engine, the left one in the place of the throttle."""

SERVO_GROUPS = ("elevator", "aileron", "rudder", "flaps", "spoilers_inboard", "spoilers_outboard")
"""Groups of surfaces with the same command, and so always the same position (SPEC 10.1)."""

SIMULATION_STATES = (*STATES, "fuel_used")
"""Of a flight as time goes on; lb."""

SIMULATION_INPUTS = (
    *CONTROLS,
    *("flaps", "spoilers", "gear"),
    *("wind_north", "wind_east", "wind_down", "gust_x", "gust_y", "gust_z"),
)
"""Commands in deg, gear 0 up .. 1 down; wind and gust in ft/s (SPEC 10.1, 10.6)."""

SIMULATION_SETTINGS = (
    *(f"{control}_{end}" for control in CONTROLS for end in ("lower", "upper")),
    *("elevator_rate", "aileron_rate", "rudder_rate"),
    *("failure_time", "damage_case", "engine_left_running", "engine_right_running"),
    *("stabilizer", "has_shear", "runway_altitude", "has_stall_asymmetry"),
    *("has_servos", "has_dead_band", "has_throttle_lag", "command_delay", "surface_delay", "has_fuel_burn"),
)
"""Limits as the controls, deg/s, s, deg, ft; what does not belong to a failure holds all the time (SPEC 10)."""

SIMULATION_OUTPUTS = (
    *OUTPUTS,
    *(f"surface_{name}" for name in SERVO_GROUPS),
    *("throttle_position", "fuel_flow_left", "fuel_flow_right"),
    *(f"{control}_{end}" for control in CONTROLS for end in ("least", "greatest")),
)
"""After `OUTPUTS`: deg, %, lb/min, and what is left of each control."""

FAILURE = (
    *(f"{control}_{end}" for control in (*CONTROLS, "throttle_left", "throttle_right") for end in ("lower", "upper")),
    *("alpha_lower", "alpha_upper", "bank_lower", "bank_upper"),
    *("has_two_throttles", "damage_case", "engine_left_running", "engine_right_running"),
    *("stabilizer", "flaps", "spoilers", "gear", "fuel_used"),
)
"""What a failure leaves for steady manoeuvres, as plain numbers: limits as the controls, rad; deg, lb
(``gtm_failure`` of gtm_failure.h)."""

LIMITED = ("alpha", "beta", "bank", "elevator", "aileron", "rudder", "throttle.left", "throttle.right")
"""What a manoeuvre's margins are told of (``GTM_LIMITED`` of gtm_failure.h)."""

BINDING = ("none", *(f"{name}.{end}" for name in (*LIMITED, "throttle") for end in ("lower", "upper")))
"""Limits that bind a manoeuvre, by their numbers from 1 on; those of one throttle for both engines come last."""
