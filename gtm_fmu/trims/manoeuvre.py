"""Steady manoeuvres at the public edge: what may be asked, the bounds it means, and the trim that answers."""

from collections.abc import Iterable
from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from gtm_fmu.aircraft import airspeed
from gtm_fmu.aircraft.failures import Failure
from gtm_fmu.aircraft.limits import ControlLimits
from gtm_fmu.aircraft.ranges import (
    ALPHA_DEG,
    BETA_DEG,
    CONTROL_SI,
    PHI_DEG,
    STATE_SI,
    TAS_KT,
    TURN_RATE_DEG_S,
    WIDEST_ALPHA_DEG,
    WIDEST_PHI_DEG,
    Range,
    check_pair,
)
from gtm_fmu.airframe.names import (
    CONTROLS,
    ELEVATOR,
    OUTPUTS,
    STATES,
    THROTTLE,
    control_variable,
    state_variable,
)
from gtm_fmu.core import configuration as configured
from gtm_fmu.core import motion, solver
from gtm_fmu.core.configuration import Configuration, trim_residual
from gtm_fmu.errors import InputError
from gtm_fmu.units import DEG_PER_RAD, KT_PER_FT_S, RAD_PER_DEG

HELD_TOLERANCE = 1e-6
"""Of an unknown's typical size: closer to a bound than this is held by it."""
_NO_THRUST = 1e-6  # lbf
CONVERGED_RESIDUAL = 1e-9
"""Largest acceleration of a converged trim, ft/s^2 and rad/s^2 alike."""

_UNIT = np.array([KT_PER_FT_S, DEG_PER_RAD, DEG_PER_RAD, DEG_PER_RAD, DEG_PER_RAD])


def bounds(
    limits: ControlLimits | Failure,
    alpha_deg: Range = ALPHA_DEG,
    phi_deg: Range = PHI_DEG,
    tas_kt: Range = TAS_KT,
    turn_rate_deg_s: Range = TURN_RATE_DEG_S,
    beta_deg: Range = BETA_DEG,
) -> tuple[np.ndarray, np.ndarray]:
    """Lower and upper bounds (9 each) of the trim unknowns in the core's units; equal ends hold an unknown.

    There are 10 each where a failure leaves both engines running with a throttle of their own.
    """
    alpha_deg = check_pair("alpha in deg", alpha_deg, WIDEST_ALPHA_DEG)
    phi_deg = check_pair("phi in deg", phi_deg, WIDEST_PHI_DEG)
    tas_kt = check_pair("tas in kn", tas_kt, TAS_KT)
    turn_rate_deg_s = check_pair("turn rate in deg/s", turn_rate_deg_s, TURN_RATE_DEG_S)
    beta_deg = check_pair("beta in deg", beta_deg, BETA_DEG)
    angles = np.array([tas_kt, alpha_deg, beta_deg, turn_rate_deg_s, phi_deg]) / _UNIT[:, None]
    return np.append(angles[:, 0], limits.lower), np.append(angles[:, 1], limits.upper)


def limits_hit(
    y: np.ndarray,
    lower: np.ndarray,
    upper: np.ndarray,
    airframe: solver.Airframe = solver.STUDY,
    tolerance: float = HELD_TOLERANCE,
) -> tuple[str, ...]:
    """Bounds that a point holds or exceeds, as ``alpha.upper``; of jammed and held unknowns only those it exceeds.

    ``tolerance``: of an unknown's typical size; closer to a bound than this is held by it.
    """
    names = []
    scales = solver.scale(airframe)
    for name, value, low, high, scale in zip(airframe.unknowns, y, lower, upper, scales, strict=True):
        slack = tolerance * scale * (-1 if low == high else 1)
        if value <= low + slack:
            names.append(f"{name}.lower")
        if value >= high - slack:
            names.append(f"{name}.upper")
    return tuple(names)


def load_factors(x: ArrayLike, u: ArrayLike, configuration: Configuration | None = None) -> np.ndarray:
    """Load factor (..) of states x (.., 12) and controls u (.., 4 or 5); see `Trim.load_factor`."""
    return -_outputs(x, u, configuration)[..., OUTPUTS.index("load_z")]


def is_idling(x: ArrayLike, u: ArrayLike, configuration: Configuration | None = None) -> np.ndarray:
    """Whether the engines have no net thrust (..): it sticks at zero there whatever a low throttle (SPEC 6)."""
    thrusts = [OUTPUTS.index("thrust_left"), OUTPUTS.index("thrust_right")]
    return np.all(_outputs(x, u, configuration)[..., thrusts] <= _NO_THRUST, axis=-1)


def _outputs(x: ArrayLike, u: ArrayLike, configuration: Configuration | None) -> np.ndarray:
    """`names.OUTPUTS` (.., 15)."""
    return motion.outputs(x, u) if configuration is None else configured.outputs(x, u, configuration)


@dataclass(frozen=True)
class Trim:
    """One steady manoeuvre, or the nearest to it that was found.

    Attributes:
        converged: the six accelerations are zero (``residual`` <= 1e-9 ft/s^2, rad/s^2).
        feasible: converged, and inside every limit.
        throttle_pct: of the engines that run; None where they have a throttle each, ``throttle_left_pct`` and
            ``throttle_right_pct``, which are None otherwise.
        limits_hit: limits that hold the trim, or that it exceeds when it is not feasible, as ``throttle.upper``.
        failure: what was left of the aircraft, with the limits of its controls.
    """

    converged: bool
    feasible: bool
    residual: float
    altitude_ft: float
    tas_kt: float
    gamma_deg: float
    turn_rate_deg_s: float
    alpha_deg: float
    beta_deg: float
    phi_deg: float
    theta_deg: float
    p_deg_s: float
    q_deg_s: float
    r_deg_s: float
    elevator_deg: float
    aileron_deg: float
    rudder_deg: float
    throttle_pct: float | None
    limits_hit: tuple[str, ...]
    unknowns: np.ndarray = field(repr=False, compare=False)
    throttle_left_pct: float | None = None
    throttle_right_pct: float | None = None
    failure: Failure = field(default_factory=Failure, repr=False)

    @classmethod
    def of_unknowns(
        cls,
        y: np.ndarray,
        altitude_ft: float,
        gamma_deg: float,
        inside: bool,
        hit: Iterable[str],
        failure: ControlLimits | Failure | None = None,
        residual: float | None = None,
    ) -> "Trim":
        """The trim of unknowns y (9 or 10, core units) at ``altitude_ft`` and ``gamma_deg``.

        ``inside`` tells whether they are inside every limit, ``hit`` which limits hold them or are exceeded.

        ``failure`` is what it was found with; ``residual`` that of the aircraft that was trimmed, where it is not ours.
        """
        gamma, failure = gamma_deg * RAD_PER_DEG, Failure.of(failure)
        airframe = failure.airframe
        x, u = solver.trim_states(altitude_ft, gamma, y, airframe)
        if residual is None:
            if airframe.configuration is None:
                F = motion.derivatives(x, u)[:6]
            else:
                F = trim_residual(solver.with_both_throttles(y, airframe), altitude_ft, gamma, airframe.configuration)
            residual = float(np.abs(F).max())
        tas_kt, alpha_deg, beta_deg, turn_rate_deg_s, phi_deg = (y[: len(_UNIT)] * _UNIT).tolist()
        p_deg_s, q_deg_s, r_deg_s = (x[3:6] * DEG_PER_RAD + 0.0).tolist()  # no -0
        elevator_deg, aileron_deg, rudder_deg = y[ELEVATOR:THROTTLE].tolist()
        throttles = y[THROTTLE:].tolist()
        is_separate = airframe.throttles == solver.TWO_THROTTLES
        converged = bool(residual <= CONVERGED_RESIDUAL)
        return cls(
            converged=converged,
            feasible=converged and bool(inside),
            residual=float(residual),
            altitude_ft=float(altitude_ft),
            tas_kt=tas_kt,
            gamma_deg=float(gamma_deg),
            turn_rate_deg_s=turn_rate_deg_s,
            alpha_deg=alpha_deg,
            beta_deg=beta_deg,
            phi_deg=phi_deg,
            theta_deg=float(x[10] * DEG_PER_RAD),
            p_deg_s=p_deg_s,
            q_deg_s=q_deg_s,
            r_deg_s=r_deg_s,
            elevator_deg=elevator_deg,
            aileron_deg=aileron_deg,
            rudder_deg=rudder_deg,
            throttle_pct=None if is_separate else throttles[0],
            limits_hit=tuple(hit),
            unknowns=np.array(y),
            throttle_left_pct=throttles[0] if is_separate else None,
            throttle_right_pct=throttles[1] if is_separate else None,
            failure=failure,
        )

    @property
    def configuration(self) -> Configuration | None:
        """Of the airframe; None for the study's."""
        return self.failure.airframe.configuration

    @property
    def shortfall(self) -> str:
        """Why the trim is not feasible, in words."""
        if not self.converged:
            return f"largest acceleration {self.residual:.3g} ft/s^2 or rad/s^2"
        return f"outside {', '.join(self.limits_hit) or 'its limits'}"

    @property
    def state_and_controls(self) -> tuple[np.ndarray, np.ndarray]:
        """State x (12) and controls u (4) in the specification's units; latitude, longitude and psi are zero.

        With a configuration the controls are 5, a throttle for each engine.
        """
        gamma = self.gamma_deg * RAD_PER_DEG
        return solver.trim_states(self.altitude_ft, gamma, self.unknowns, self.failure.airframe)

    @property
    def eas_kt(self) -> float:
        """Equivalent airspeed in kn."""
        return airspeed.eas_of_tas(self.tas_kt, self.altitude_ft)

    @property
    def cas_kt(self) -> float:
        """Calibrated airspeed in kn."""
        return airspeed.cas_of_tas(self.tas_kt, self.altitude_ft)

    @property
    def load_factor(self) -> float:
        """What an accelerometer along the body's upward axis reads, in g: ``load_z`` (SPEC 8) with the other sign."""
        return float(load_factors(*self.state_and_controls, self.configuration))

    def start_values(self) -> dict[str, float]:
        """States and controls under the names of GtmDynamics and in SI, to start an FMU from; it flies on as it is.

        Damage and engines that are out are not among them.

        Raises:
            InputError: each engine has a throttle, which no FMU has.
        """
        if self.throttle_pct is None:
            raise InputError("Each engine of this trim has a throttle, but an FMU has one for both.")
        x, u = self.state_and_controls
        values = dict(zip(map(state_variable, STATES), (x * STATE_SI).tolist(), strict=True))
        controls = u[: len(CONTROLS)] * CONTROL_SI
        return values | dict(zip(map(control_variable, CONTROLS), controls.tolist(), strict=True))

    def to_dict(self) -> dict[str, Any]:
        """All named values, ready for JSON, with the speeds and the load factor that follow from them."""
        names = [f.name for f in fields(self) if f.name not in ("unknowns", "failure")]
        names += ["eas_kt", "cas_kt", "load_factor"]
        values = {name: value for name in names if (value := getattr(self, name)) is not None}
        return values | {"limits_hit": list(self.limits_hit)}
