"""Damage cases (SPEC 10.5): what each one takes from the mass properties and from the surfaces.

Their aerodynamic increments are tables of the database (`gtm_fmu.airframe.configured_tables`).
"""

from typing import NamedTuple


class Damage(NamedTuple):
    """Changes of weight in lb, of the centre of gravity in inches, of Ixx Iyy Izz Ixz Iyz Ixy in slug ft^2.

    Lost surfaces keep their positions but no longer enter the coefficients.
    """

    name: str
    weight_lb: float = 0.0
    cg_in: tuple[float, ...] = (0.0, 0.0, 0.0)
    inertia: tuple[float, ...] = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    lost: tuple[str, ...] = ()


DAMAGE_CASES = (
    Damage("none"),
    Damage(
        "rudder off",
        -0.13,
        (0.126, 0.0, 0.028),
        (-0.00346, -0.06698, -0.06352, -0.01409, 0.00001, 0.00003),
        lost=("RUDU", "RUDL"),
    ),
    Damage(
        "vertical tail off",
        -1.31,
        (1.166, 0.0, 0.277),
        (-0.03507, -0.57604, -0.54102, -0.13113, 0.00006, 0.00024),
        lost=("RUDU", "RUDL"),
    ),
    Damage(
        "left outboard flap off",
        -0.09,
        (0.014, 0.041, 0.001),
        (-0.01018, -0.00120, -0.01137, -0.00009, -0.00027, -0.00347),
        lost=("FLAPLOB",),
    ),
    Damage(
        "25 % of the left wing off",
        -0.81,
        (0.148, 0.628, 0.032),
        (-0.25821, -0.01727, -0.27400, -0.00295, -0.01346, -0.05998),
        lost=("AILL",),
    ),
    Damage(
        "left elevator off",
        -0.07,
        (0.065, 0.010, 0.004),
        (-0.00097, -0.03391, -0.03467, -0.00188, -0.00029, -0.00510),
        lost=("ELLOB", "ELLIB"),
    ),
    Damage(
        "left stabiliser off",
        -0.59,
        (0.553, 0.088, 0.032),
        (-0.00918, -0.27315, -0.28049, -0.01559, -0.00265, -0.04370),
        lost=("STAB", "ELLOB", "ELLIB"),
    ),
)
"""By number; 0 is the undamaged aircraft."""
