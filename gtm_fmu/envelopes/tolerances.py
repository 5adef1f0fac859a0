"""What is not known for sure about the aircraft and the air: gusts, mass, centre of gravity and coefficients.

Mass, centre of gravity and coefficients lie somewhere in a box about their nominal values. A place in it is ten numbers
from -1 to 1, in the order of `core.slopes.TOLERANCES`; the corners of the box are those of -1 and 1. A gust is a speed
of the air that may come at any time, from ahead or from behind and from below or from above, both at once.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, fields, replace
from itertools import product

import numpy as np

from gtm_fmu.aircraft.failures import Failure
from gtm_fmu.aircraft.ranges import Range, check_range
from gtm_fmu.airframe.mass import MEAN_CHORD
from gtm_fmu.airframe.names import COEFFICIENTS, OUTPUTS, STATES
from gtm_fmu.core import motion
from gtm_fmu.core.configuration import outputs_jacobian
from gtm_fmu.core.slopes import TOLERANCES
from gtm_fmu.trims.manoeuvre import Trim
from gtm_fmu.units import DEG_PER_RAD, FT_S_PER_KT, RAD_PER_DEG

ALLOWED: dict[str, Range] = {
    "gust_kt": (0.0, 50.0),
    "mass_tolerance": (0.0, 0.3),
    "cg_tolerance": (0.0, 0.3),
    "aero_tolerance": (0.0, 0.3),
}
"""Of each field of `Tolerances`."""

Place = tuple[float, ...]
NOMINAL: Place = (0.0,) * len(TOLERANCES)
CG_AXES = (1, 2, 3)
"""Of a place: where the numbers of the centre of gravity are."""


@dataclass(frozen=True)
class Tolerances:
    """How far things may be from what they should be.

    Attributes:
        gust_kt: speed of a gust in kn along the flight path, and of one across the wings.
        mass_tolerance: of mass and inertia, as a fraction: 0.05 is 5 % more or less.
        cg_tolerance: of the centre of gravity along each body axis, as a fraction of the mean chord (0.9153 ft).
        aero_tolerance: of each of the six total coefficients (CX CY CZ Cl Cm Cn), as a fraction.

    Raises:
        InputError: a value outside `ALLOWED`.
    """

    gust_kt: float = 0.0
    mass_tolerance: float = 0.0
    cg_tolerance: float = 0.0
    aero_tolerance: float = 0.0

    def __post_init__(self) -> None:
        """Check the values."""
        for field in fields(self):
            name = field.name.replace("_kt", " in kn").replace("_", " ")
            object.__setattr__(self, field.name, check_range(name, getattr(self, field.name), ALLOWED[field.name]))

    def __bool__(self) -> bool:
        """Whether anything is not known for sure."""
        return any(asdict(self).values())

    @property
    def has_box(self) -> bool:
        """Whether the aircraft is not known for sure."""
        return bool(self.axes)

    @property
    def sizes(self) -> np.ndarray:
        """Half the sides (10) of the box: 1, ft, 1 as in `core.slopes.TOLERANCES`."""
        cg_ft = self.cg_tolerance * MEAN_CHORD
        return np.array([self.mass_tolerance, *(cg_ft,) * 3, *(self.aero_tolerance,) * len(COEFFICIENTS)])

    @property
    def axes(self) -> tuple[int, ...]:
        """Which of the ten numbers of a place count."""
        return tuple(np.flatnonzero(self.sizes).tolist())

    def corners(self) -> Iterator[Place]:
        """Every corner of the box: 2 for the mass, 8 for the centre of gravity, 64 for the coefficients, all together.

        What has no tolerance stays at 0. Without any the only corner is the nominal place.
        """
        yield from product(*((-1.0, 1.0) if size else (0.0,) for size in self.sizes))

    def moved(self, failure: Failure, place: Sequence[float]) -> Failure:
        """The ``failure`` with the aircraft at a ``place`` of the box, -1 to 1 of its `sizes` (1, ft)."""
        if not any(place):
            return failure
        mass, x, y, z, *factors = (self.sizes * place).tolist()
        given = failure.configuration
        configuration = replace(
            given,
            mass_factor=given.mass_factor * (1.0 + mass),
            cg_offset_ft=tuple(a + b for a, b in zip(given.cg_offset_ft, (x, y, z), strict=True)),
            coefficient_factor=tuple(a * (1.0 + b) for a, b in zip(given.coefficient_factor, factors, strict=True)),
        )
        return replace(failure, configuration=configuration)

    def told(self, place: Sequence[float]) -> dict[str, float]:
        """A ``place`` by name, from the nominal values: mass and coefficients as fractions, cg in ft."""
        values = zip(TOLERANCES, (self.sizes * place).tolist(), self.sizes.tolist(), strict=True)
        return {f"{name}_ft" if name.startswith("cg") else name: value for name, value, size in values if size}

    # Gusts: the vertical one changes alpha by atan(w / V).

    def gust_alpha_deg(self, tas_kt: float) -> float:
        """Change of alpha in deg by the gust across the wings at an airspeed ``tas_kt``."""
        return math.atan2(self.gust_kt, tas_kt) * DEG_PER_RAD

    def alpha_kept(self, alpha_deg: Range, tas_kt: float) -> Range | None:
        """What the gust leaves of the bounds ``alpha_deg`` for a steady manoeuvre at ``tas_kt``; None for nothing."""
        margin = self.gust_alpha_deg(tas_kt)
        low, high = alpha_deg[0] + margin, alpha_deg[1] - margin
        return (low, high) if low <= high else None

    def gust_load_factor(self, trim: Trim) -> float:
        """Change of the load factor in g by the gust across the wings, by the slope of the lift at a ``trim``.

        About rho V w S CL_alpha / 2 W.
        """
        x, u = trim.state_and_controls
        configuration = trim.configuration
        at = motion.outputs_jacobian(x, u) if configuration is None else outputs_jacobian(x, u, configuration)
        along_x, along_z = at[1][OUTPUTS.index("load_z"), [STATES.index("u"), STATES.index("w")]].tolist()
        alpha = trim.alpha_deg * RAD_PER_DEG
        slope = math.sin(alpha) * along_x - math.cos(alpha) * along_z  # load_z points down, the gust up
        return slope * self.gust_kt * FT_S_PER_KT
