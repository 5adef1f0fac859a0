"""The flight along a path of trims: the core's simulation, with servos, delays and throttle lag, and the autopilot."""

import numpy as np
from scipy.interpolate import PchipInterpolator

from examples.transitions.autopilot import Hold, states_in_air
from gtm_fmu.aircraft.failures import Failure
from gtm_fmu.airframe.actuators import SERVOS
from gtm_fmu.airframe.names import CONTROLS, SIMULATION_OUTPUTS, STATES
from gtm_fmu.core.configuration import Configuration
from gtm_fmu.core.simulation import Simulation
from gtm_fmu.errors import InputError
from gtm_fmu.units import DEG_PER_RAD

STEP_S, SUBSTEP_S = 0.02, 0.01
SURFACES = CONTROLS[:3]
MEASURED = ("tas", "alpha", "beta", "gamma", *(f"surface_{name}" for name in SURFACES), "throttle_position")
_OUTPUTS = [SIMULATION_OUTPUTS.index(name) for name in MEASURED]
_BODY = [STATES.index(name) for name in ("p", "q", "r", "phi", "theta")]
COLUMNS = (
    *("time_s", "altitude_ft", "tas_kt", "alpha_deg", "beta_deg", "gamma_deg"),
    *(f"{name}_deg" for name in SURFACES),
    *("throttle_pct", "phi_deg", "turn_rate_deg_s"),
    *(f"{name}_demand" for name in CONTROLS),
)


def control_ranges(failure: Failure) -> np.ndarray:
    """What is left (4, 2) of the controls: the failure's limits inside the travel of the servos; deg, %."""
    travel = [*(SERVOS[name] for name in SURFACES), (0.0, 100.0)]
    left = np.stack([failure.lower, failure.upper], axis=1)
    return np.clip(left, *np.array(travel).T[:, :, None])


def simulation_settings(failure: Failure) -> dict[str, float]:
    """Settings of the core's simulation that mean a failure which is there from the start.

    Raises:
        InputError: engines with a throttle each, or an airframe that the simulation does not know.
    """
    what, known = failure.configuration, ("damage_case", "engine_running", "stabilizer_deg")
    same = Configuration(**{name: getattr(what, name) for name in known})
    if failure.controls != CONTROLS or what != same:
        raise InputError(
            "The simulation knows limits, damage, engines out and the stabiliser, and one throttle: "
            "leave separate throttles and every other change of the airframe out."
        )
    limits = zip(CONTROLS, control_ranges(failure).tolist(), strict=True)
    return {
        **{
            f"{name}_{end}": value for name, pair in limits for end, value in zip(("lower", "upper"), pair, strict=True)
        },
        **{f"{name}_rate": getattr(failure.rate_limits, f"{name}_deg_s") for name in SURFACES},
        **dict(zip(("engine_left_running", "engine_right_running"), map(float, what.engine_running), strict=True)),
        "damage_case": what.damage_case,
        "stabilizer": what.stabilizer_deg,
    }


def fly(start: np.ndarray, failure: Failure, time_s: np.ndarray, holds: list[Hold]) -> dict[str, np.ndarray]:
    """Fly from a state (12) along what is to be held at times (n), smoothly interpolated, to the last of them.

    Returns:
        `COLUMNS` (steps + 1) by name; ``*_demand`` is what the autopilot asks of a control, beyond its limits too.
        Where the simulation ends early (tumbling, a pitch of 90 deg) the columns end there.
    """
    simulation = Simulation(start, simulation_settings(failure))
    times = np.minimum(time_s[0] + STEP_S * np.arange(1 + np.ceil((time_s[-1] - time_s[0]) / STEP_S)), time_s[-1])
    parts = [PchipInterpolator(time_s, np.array(part)) for part in zip(*holds, strict=True)]
    held, trim_rates = [Hold(*step) for step in zip(*(part(times) for part in parts), strict=True)], parts[0](times, 1)
    demand, rows = held[0].controls, []
    for now, hold, rates in zip(times.tolist(), held, trim_rates, strict=True):
        try:
            outputs = simulation.evaluate(demand)[1]
            measured, body = outputs[_OUTPUTS], simulation.x[_BODY]
            demand = hold.commands(states_in_air(*measured[:3], body), rates)
            rows.append(_row(now, simulation.x, measured, body, demand))
            simulation.advance(demand, STEP_S, SUBSTEP_S)
        except FloatingPointError:
            break
    return dict(zip(COLUMNS, np.array(rows).T, strict=True))


def _row(now: float, x: np.ndarray, measured: np.ndarray, body: np.ndarray, demand: np.ndarray) -> list[float]:
    _, q, r, phi, theta = body
    turn_rate = (q * np.sin(phi) + r * np.cos(phi)) / np.cos(theta)
    return [now, x[STATES.index("altitude")], *measured, phi * DEG_PER_RAD, turn_rate * DEG_PER_RAD, *demand]
