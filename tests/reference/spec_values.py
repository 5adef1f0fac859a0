"""Reference values of SPEC 13 and 3 (docs/airframe.md), as printed there.

Units are the specification's own: ft, ft/s, rad, rad/s, slug, lbf; surfaces in deg, throttle in %; trims are printed in
deg and deg/s. Where the printed digits give the tolerance, a value stays text: see `half_unit`.
"""

from typing import NamedTuple

import numpy as np


def half_unit(printed: str) -> float:
    """Half a unit in the last printed place: the error that rounding may have left in a printed number."""
    digits, _, exponent = printed.partition("e")
    decimals = len(digits.partition(".")[2])
    return 0.5 * 10.0 ** (int(exponent or 0) - decimals)


def assert_as_printed(value: float, printed: str, half_units: float = 1) -> None:
    """`value` rounds to `printed`, with room for the rounding of the printed decimal itself."""
    assert abs(value - float(printed)) <= half_units * half_unit(printed) * (1 + 1e-6), f"{value} is not {printed}"


def numbers(text: str) -> np.ndarray:
    """The numbers of a printed line."""
    return np.array([float(word) for word in text.split()])


class Point(NamedTuple):
    """A state, its controls and the state derivatives."""

    x: np.ndarray
    u: np.ndarray
    xdot: np.ndarray


# SPEC 13, test point A
POINT_A = Point(
    x=np.array([150, 8, 12, 0.1, -0.05, 0.2, 0.66, -1.3176, 5000, 0.2, 0.08, 1.0]),
    u=np.array([-2, 3, 5, 50]),
    xdot=numbers(
        "3.689609767479 -24.07200626921 -8.942610467163 -7.948727049401 2.647342217367 -1.280045528264 "
        "3.672314341666e-06 7.851180084422e-06 -1.320251773024 0.1149182270605 -0.08873719505107 0.1866768965702"
    ),
)
POINT_A_COEFFICIENTS = "-0.005733918492 -0.022029018614 -0.417454793956 -0.009355961694 0.087809389757 -0.00535379921"
POINT_A_OUTPUTS = {
    "tas": "89.28289596612",
    "eas": "82.87941756245",
    "alpha": "4.573921259901",
    "beta": "3.043178238316",
    "dynamic_pressure": "23.25501608632",
    "thrust_left": "4.042207033",
    "thrust_right": "4.042207033",
    "rotor_speed_left": "74.3187752867",
    "rotor_speed_right": "74.3187752867",
}
POINT_A_DENSITY = "0.00204817827077"
POINT_A_PRESSURE_RATIO = "0.832085078123"
POINT_A_ANGULAR_MOMENTUM = "0.113525807"

# SPEC 13, test point B: negative alpha, elevator beyond its last breakpoint
POINT_B = Point(
    x=np.array([160, -6, -4, -0.3, 0.1, -0.25, 0.66, -1.3176, 20000, -0.3, -0.1, 2.0]),
    u=np.array([25, -15, -22, 90]),
    xdot=numbers(
        "7.728494926263 28.36067320779 38.13139189888 9.759814102647 -10.34855252420 6.051512581460 "
        "-2.870359262543e-06 8.944430736816e-06 -13.93535453912 -0.2730715643551 0.02165359724723 -0.2697336878711"
    ),
)

# SPEC 13, the six accelerations at test point A in damage cases 1 to 6
POINT_A_DAMAGED = {
    1: "3.332759968 -26.21142243 -8.408226439 -8.918849789 2.592724249 1.039212778",
    2: "3.873063347 -24.07965023 -8.487781801 -7.577914544 4.036933899 -1.178660407",
    3: "3.263820851 -24.30199839 -4.573879543 -17.39223748 3.936714131 -2.089156544",
    4: "3.383658606 -24.37699843 -6.635476914 -16.60828751 4.147801114 -1.806225008",
    5: "3.477677744 -23.90040053 -9.52446399 -7.797041342 1.111328053 -1.629695421",
    6: "3.577966423 -24.25709944 -10.20198057 -7.824794031 0.3300564904 -1.22102422",
}


class ConfiguredPoint(NamedTuple):
    """A state, its 22 surface signals, fuel used in lb and wind in ft/s (north, east, down, three gusts)."""

    x: np.ndarray
    bus: dict[str, float]
    fuel_used: float
    wind: np.ndarray


# SPEC 13, test point C (state of point A), with shear; the accelerations in damage cases 0 and 6
POINT_C = ConfiguredPoint(
    x=POINT_A.x,
    bus={
        **{"ELLOB": -4, "ELLIB": -2, "ELROB": 6, "ELRIB": 3, "AILL": -5, "AILR": 8, "RUDU": 12, "RUDL": -7},
        **{"SPLLIB": 5, "SPLLOB": 20, "SPLRIB": 10, "SPLROB": 35},
        **{"FLAPLIB": 10, "FLAPLOB": 12, "FLAPRIB": 14, "FLAPROB": 16},
        **{"STAB": -3, "GEAR": 1, "BRAKE": 0, "THROTL": 30, "THROTR": 70, "STEER": 0},
    },
    fuel_used=7,
    wind=np.array([10, -6, 2, 1, -2, 3]),
)
POINT_C_ACCELERATIONS = {
    0: "-1.012824782 -33.66146905 7.45315677 -15.04915433 5.86834368 2.285824779",
    6: "-1.353763299 -34.06893793 0.6539371134 -14.07071294 -2.029276841 2.499461778",
}
POINT_C_SHEAR_GAIN = "0.9997435259521"
POINT_C_WIND_BODY = "1.193185375638 -13.01965099437 7.296296992581"
# in damage case 6: slug, ft, slug ft^2 (Ixx, Iyy, Izz, Ixz, Iyz, Ixy)
POINT_C_MASS = "1.559020390656"
POINT_C_CG = "-4.716311682 -0.006252193 -0.944948465"
POINT_C_INERTIAS = "1.256983561 4.383458737 5.315316771 0.25841 -0.00265 -0.0377"


class Trim(NamedTuple):
    """A printed trim: ft, ft/s (or eas in kn), deg, deg/s, %; None where the table prints nothing."""

    name: str
    h: float
    gamma: float
    free: tuple[str, ...]
    alpha: str
    beta: str
    phi: str
    elevator: str
    aileron: str
    rudder: str
    throttle: str
    V: str
    eas: float | None = None
    psi_dot: float | None = 0.0


BETA_HELD = ("phi", "elevator", "aileron", "rudder", "throttle")
RUDDER_HELD = ("alpha", "beta", "phi", "elevator", "aileron", "throttle")

# SPEC 13, trims at 800 ft (beta = 0) and straight flight at 10000 ft with the rudder held
TRIMS = (
    Trim(
        "alpha 3, level", 800, 0, ("V", *BETA_HELD),
        "3", "0", "-0.01616", "2.414942", "-0.394239", "0.004192", "39.839881", "164.14225",
    ),
    Trim(
        "eas 75, level", 800, 0, ("alpha", *BETA_HELD),
        "5.558324", "0", "-0.01820", "0.095301", "-0.719120", "-0.004484", "33.638686", "128.07948", eas=75,
    ),
    Trim(
        "eas 95, climbing turn 10 deg/s", 800, 3, ("alpha", *BETA_HELD),
        "4.322698", "0", "41.52995", "0.987739", "-0.339573", "-0.371198", "53.853448", "162.23401", eas=95, psi_dot=10,
    ),
    Trim(
        "eas 95, climbing turn banked 45 deg", 800, 3, ("alpha", "psi_dot", *BETA_HELD[1:]),
        "4.620696", "0", "45", "0.634587", "-0.346630", "-0.396514", "55.452146", "162.23401", eas=95, psi_dot=None,
    ),
    Trim(
        "rudder held at 10 deg", 10000, 0, RUDDER_HELD,
        "2.315597", "7.717613", "15.739215", "1.285077", "-9.195683", "10", "64.927000", "200",
    ),
    Trim(
        "rudder held at 20 deg", 10000, 0, RUDDER_HELD,
        "2.148419", "13.219372", "28.831237", "0.977089", "-15.596765", "20", "86.511081", "200",
    ),
)  # fmt: skip


class AtmosphereRow(NamedTuple):
    """Altitude in ft, density in slug/ft^3, pressure ratio, static thrust of one engine in lbf at 0, 50 and 100 %."""

    h: float
    density: str
    pressure_ratio: str
    thrust: tuple[str, str, str]


# SPEC 13, atmosphere and static thrust per engine
ATMOSPHERE = (
    AtmosphereRow(0, "0.0023769", "1", ("0.8776", "6.5074", "15.3153")),
    AtmosphereRow(10000, "0.00175555424", "0.68783182", ("0.6036", "4.4760", "10.5343")),
    AtmosphereRow(20000, "0.00126726089", "0.45991192", ("0.4036", "2.9928", "7.0437")),
    AtmosphereRow(30000, "0.00089068675", "0.29754338", ("0.2611", "1.9362", "4.5570")),
)

# SPEC 3, at zero fuel burn and gear up
MASS = "1.794925"
INERTIA = {"Ixx": "1.222076938", "Iyy": "4.657102173", "Izz": "5.588301532"}


class Spin(NamedTuple):
    """The spin trim: controls in deg and %, air data in kn and deg, rates in deg/s, attitude in deg."""

    h: float
    u: tuple[str, str, str, str]
    eas: str
    alpha: str
    beta: str
    gamma: str
    rates: tuple[str, str, str]
    phi: str
    theta: str


# SPEC 13: visits the rotary table and the rate split
SPIN = Spin(
    h=4000,
    u=("-1.819737", "7.754142", "30", "0"),
    eas="72.090312",
    alpha="22.770312",
    beta="0.100312",
    gamma="-72.049516",
    rates=("-355.493122", "32.229932", "-152.260104"),
    phi="-43.725186",
    theta="-64.187333",
)
