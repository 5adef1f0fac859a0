"""Can it get there: from one steady manoeuvre to another after a failure, flown in a simulation inside all limits.

The reference moves on a straight line in speed, flight path and turn rate, with rates that begin and end at zero. It is
a path of trims. Is one of them missing, the answer is no. If all exist, the `autopilot` flies along them, and every
limit is watched at every step: what is left of the controls and how fast they move, alpha, bank, the speeds of the
steady envelope, and the lowest altitude. The answer is yes if none is exceeded and the aircraft ends at the target.

A no is no proof: another path, other rates or another autopilot may get there where this one does not.
"""

from dataclasses import dataclass, field

import numpy as np
from threadpoolctl import threadpool_limits

from examples.transitions.autopilot import hold
from examples.transitions.flight import SURFACES, control_ranges, fly, simulation_settings
from examples.transitions.path import CHECKED_S, DEFAULT_RATES, Manoeuvre, Path, Rates, straight_path
from gtm_fmu.aircraft.failures import Failure
from gtm_fmu.aircraft.limits import ControlLimits
from gtm_fmu.aircraft.ranges import ALPHA_DEG, ALTITUDE_FT, PHI_DEG, Range
from gtm_fmu.airframe.actuators import BANDWIDTH_RAD_S
from gtm_fmu.airframe.names import CONTROLS
from gtm_fmu.envelopes.envelope import FlightCondition

KNOTS_S = 0.25
"""Between trims with gains of their own; what is held is interpolated."""
REACHED = {"tas_kt": 0.5, "gamma_deg": 0.2, "turn_rate_deg_s": 0.2}
"""How near the target the flight has to end."""
SLACK = 0.01
"""By how much a limit may be exceeded, in deg, %, kn or ft: a trim at a limit is no violation."""
_SPEEDS_ASKED = 9  # envelopes along a path; between them V_min and V_max are interpolated


@dataclass(frozen=True)
class Transition:
    """An answer.

    Attributes:
        possible: the flight kept every limit and ended at the target.
        reason: why not, in one sentence; empty if it is.
        limit: what stopped it, as ``aileron.upper``, ``aileron_rate.upper``, or ``tas_kt`` of a missed target.
        time_s: when, since the reference began to move.
        flight: columns by name (`flight.COLUMNS`), up to the violation if there is one; empty if the path is refused.
        limits: (2) or (2, steps) of the columns that were watched.
    """

    possible: bool
    reason: str
    limit: str | None
    time_s: float | None
    path: Path
    flight: dict[str, np.ndarray] = field(default_factory=dict)
    limits: dict[str, np.ndarray] = field(default_factory=dict)


def transition(
    altitude_ft: float,
    start: Manoeuvre,
    target: Manoeuvre,
    limits: ControlLimits | Failure | None = None,
    rates: Rates = DEFAULT_RATES,
    alpha_deg: Range = ALPHA_DEG,
    phi_deg: Range = PHI_DEG,
    lowest_altitude_ft: float = 0.0,
) -> Transition:
    """Whether the aircraft gets from ``start`` to ``target`` inside all limits that the failure leaves.

    Raises:
        InputError: a value outside what is allowed, or a failure that the simulation does not know.
    """
    failure = Failure.of(limits)
    simulation_settings(failure)
    path = straight_path(altitude_ft, start, target, failure, rates, alpha_deg, phi_deg)
    allowed = max(lowest_altitude_ft, ALTITUDE_FT[0]), ALTITUDE_FT[1]
    if (outside := np.clip(path.altitude_ft, *allowed) != path.altitude_ft).any():
        k = int(np.argmax(outside))
        at, end = float(path.time_s[k]), "lower" if path.altitude_ft[k] < allowed[0] else "upper"
        reason = f"The way leads beyond {allowed[end == 'upper']:g} ft after {at:.1f} s."
        return Transition(False, reason, f"altitude.{end}", at, path)
    if (k := path.refusal) is not None:
        return Transition(False, _refusal(path, k), path.trims.binding[k], float(path.time_s[k]), path)
    last = len(path.time_s) - 1
    knots = np.unique([*range(0, last, round(KNOTS_S / CHECKED_S)), last])
    try:
        with threadpool_limits(1):  # matrices of 8 rows: threads would only wait for each other
            holds = [hold(path.trims, k) for k in knots.tolist()]
    except (ValueError, np.linalg.LinAlgError):
        reason = "No gain holds the manoeuvres on the way: the controls that are left do not reach a growing mode."
        return Transition(False, reason, None, 0.0, path)
    first = path.trims.trim(0)
    assert first is not None
    flight = fly(first.state_and_controls[0], failure, path.time_s[knots], holds)
    watched = {
        "alpha_deg": np.array(alpha_deg),
        "phi_deg": np.array(phi_deg),
        "altitude_ft": np.array(allowed),
        "tas_kt": _speeds(path, flight["time_s"], failure, alpha_deg, phi_deg),
        **{f"{name}_demand": ends for name, ends in zip(CONTROLS, control_ranges(failure), strict=True)},
    }
    flight |= {
        f"{name}_rate": BANDWIDTH_RAD_S * (flight[f"{name}_demand"] - flight[f"{name}_deg"]) for name in SURFACES
    }
    fastest = {f"{name}_rate": getattr(failure.rate_limits, f"{name}_deg_s") for name in SURFACES}
    watched |= {name: np.array([-most, most]) for name, most in fastest.items()}
    return _verdict(path, flight, watched, target)


def _refusal(path: Path, k: int) -> str:
    """Why the path is refused at its ``k``-th manoeuvre."""
    where = f"There is no steady flight at {path.manoeuvre(k)}, {path.time_s[k]:.1f} s on the way"
    binding = path.trims.binding[k]
    if binding is None:
        return f"{where}: no trim at all."
    name, end = binding.split(".")
    margins = next((pair for key, pair in path.trims.margins(k).items() if key.startswith(f"{name}_")), None)
    unit = "%" if name.startswith("throttle") else "deg"
    by = "" if margins is None else f" by {-margins[end == 'upper']:.2g} {unit}"
    return f"{where}: {name} exceeds its {end} limit{by}."


def _speeds(path: Path, time_s: np.ndarray, failure: Failure, alpha_deg: Range, phi_deg: Range) -> np.ndarray:
    """V_min and V_max (2, steps) in kn of steady flight at the altitudes and flight paths of the reference."""
    asked = np.unique(np.linspace(0, np.searchsorted(path.time_s, path.moving_s), _SPEEDS_ASKED).astype(int))
    asked = np.minimum(asked, len(path.time_s) - 1)
    altitude, _, gamma, _ = path.trims.asked
    ends = []
    for k in asked.tolist():
        found = FlightCondition(altitude[k], gamma[k], failure, alpha_deg, phi_deg).envelope()
        ends.append((found.v_min_kt, found.v_max_kt))
    return np.array([np.interp(time_s, path.time_s[asked], column) for column in np.array(ends, float).T])


def _verdict(
    path: Path, flight: dict[str, np.ndarray], watched: dict[str, np.ndarray], target: Manoeuvre
) -> Transition:
    """The first limit that is exceeded, or what is missed of the target, or yes."""
    time_s = flight["time_s"]
    exceeded = {}
    for name, (lower, upper) in watched.items():
        beyond = np.stack([lower - flight[name], flight[name] - upper])
        if (beyond > SLACK).any():
            exceeded[name] = int(np.argmax((beyond > SLACK).any(axis=0)))
    if exceeded:
        name = min(exceeded, key=lambda each: exceeded[each])
        k = exceeded[name]
        lower, upper = (np.broadcast_to(end, time_s.shape)[k] for end in watched[name])
        end = "lower" if flight[name][k] < lower else "upper"
        what, _, unit = name.rpartition("_")
        reason = _words(what, unit, end, float(flight[name][k]), float(lower if end == "lower" else upper), time_s[k])
        until = {column: values[: k + 1] for column, values in flight.items()}
        kept = {column: ends[..., : k + 1] if ends.ndim == 2 else ends for column, ends in watched.items()}
        limit = f"{name if unit == 'rate' else what}.{end}"
        return Transition(False, reason, limit, float(time_s[k]), path, until, kept)
    at = float(time_s[-1])
    if at < path.time_s[-1] - 1e-6:
        return Transition(False, f"The simulation ends at {at:.1f} s.", None, at, path, flight, watched)
    for name, most in REACHED.items():
        off = float(flight[name][-1] - getattr(target, name))
        if abs(off) > most:
            reason = f"The flight ends {abs(off):.2g} off the target's {name}, more than {most:g}."
            return Transition(False, reason, name, at, path, flight, watched)
    return Transition(True, "", None, None, path, flight, watched)


_WORDS = {
    "demand": "the autopilot asks the {what} for {value:.2f}, beyond its {end} limit of {limit:.2f}",
    "rate": "the {what} would have to move at {value:.0f} deg/s, faster than {limit:.0f}",
}


def _words(what: str, unit: str, end: str, value: float, limit: float, time_s: float) -> str:
    text = _WORDS.get(unit, "{what} is {value:.2f} {unit}, beyond its {end} limit of {limit:.2f}")
    said = text.format(what=what, unit=unit, end=end, value=value, limit=limit)
    return f"At {time_s:.1f} s {said}."
