"""Expected results that travel in a native FMU, by the core: a flight with doublets, envelopes of a failing rudder."""

import csv
import io
from collections.abc import Callable, Sequence

import numpy as np

from fmu_src.description.model_description import EXTRA, ModelDescription
from gtm_fmu import core
from gtm_fmu.aircraft.failures import Failure
from gtm_fmu.aircraft.limits import ControlLimits
from gtm_fmu.aircraft.ranges import WIDEST
from gtm_fmu.airframe.names import LIMITED
from gtm_fmu.core.configuration import Configuration
from gtm_fmu.core.simulation import Simulation
from gtm_fmu.envelopes.envelope import envelope
from gtm_fmu.trims.steady import trim
from gtm_fmu.units import KG_PER_LB, M_PER_FT, M_S_PER_KT, RAD_PER_DEG

STEP_S, STOP_S, RECORDED_EVERY = 0.02, 10.0, 5
DOUBLETS = {"control.elevator": (1.0, 2.0, 3.0, 0.05), "control.aileron": (4.0, 4.5, 5.0, 0.03)}
"""Begin, turn and end in s, and amplitude in rad."""
Find = Callable[[float, float, tuple[float, float]], tuple[float, float, bool]]
ENVELOPES, ENVELOPE_RESULTS = 11, ("v_min", "v_max", "margin.slow", "margin.fast", "feasible")


def commands(time_s: float, trim: dict[str, float]) -> dict[str, float]:
    """Values of the moving controls (SI) that are held over the communication step from a time on."""
    values = {}
    for name, (begin, turn, end, size) in DOUBLETS.items():
        at = time_s + STEP_S / 2  # steps begin a rounding before or after these times
        values[name] = trim[name] + (size if begin <= at < turn else -size if turn <= at < end else 0.0)
    return values


def _substep_s(model: ModelDescription) -> float:
    return float(next(v.start for v in model.groups["solver"] if v.name == "solver.substep") or 0.0)


def reference_flight(model: ModelDescription) -> dict[str, bytes]:
    """Inputs and results of the reference flight as CSV, in SI, in the folder ``extra``."""
    x, u, outputs = (model.groups[group] for group in ("states", "controls", "outputs"))
    x_scale, u_scale, y_scale = (np.array([variable.scale for variable in group]) for group in (x, u, outputs))
    trim = {variable.name: float(variable.start or 0.0) for variable in u}
    state = np.array([variable.start for variable in x]) / x_scale
    inputs, results = [], []
    held = np.array(list(trim.values())) / u_scale
    for i in range(round(STOP_S / STEP_S) + 1):
        time_s = i * STEP_S
        if i % RECORDED_EVERY == 0:  # at the end of a step, with its controls
            results.append([time_s, *(state * x_scale), *(core.outputs(state, held) * y_scale)])
        given = trim | commands(time_s, trim)
        inputs.append([time_s, *given.values()])
        held = np.array(list(given.values())) / u_scale
        state = core.advance(state, held, STEP_S, _substep_s(model))
    return _files(["time", *trim], inputs, ["time", *(v.name for v in (*x, *outputs))], results)


def reference_simulation(model: ModelDescription) -> dict[str, bytes]:
    """The same flight through servos, delays and lag; the inputs that stay at their start values are left out."""
    x, u, outputs = (model.groups[group] for group in ("states", "controls", "outputs"))
    start, x_scale, u_scale, y_scale = (
        np.array(numbers, float)
        for numbers in ([v.start for v in x], *([v.scale for v in group] for group in (x, u, outputs)))
    )
    trim = {variable.name: float(variable.start or 0.0) for variable in u}
    simulation = Simulation(start / x_scale)
    inputs, results = [], []
    held = np.array(list(trim.values())) / u_scale
    for i in range(round(STOP_S / STEP_S) + 1):
        time_s = i * STEP_S
        if i % RECORDED_EVERY == 0:
            results.append([time_s, *(simulation.x * x_scale), *(simulation.evaluate(held)[1] * y_scale)])
        given = commands(time_s, trim)
        inputs.append([time_s, *given.values()])
        held = np.array(list((trim | given).values())) / u_scale
        simulation.advance(held, STEP_S, _substep_s(model))
    return _files(["time", *DOUBLETS], inputs, ["time", *(v.name for v in (*x, *outputs))], results)


def reference_envelopes(model: ModelDescription, find: Find, control: str = "rudder") -> dict[str, bytes]:
    """Inputs and results of a climb while ever less is left of a control, as CSV, in SI, in the folder ``extra``."""

    def find_one(part: float) -> tuple[dict[str, float], tuple[float, float, bool]]:
        return {}, find(*_failing(part, control))

    return _reference_envelopes(model, find_one, control)


def reference_failures(model: ModelDescription) -> dict[str, bytes]:
    """The same, exact, while the ailerons fail as well and fuel is used; halfway the left elevator is lost."""

    def find_one(part: float) -> tuple[dict[str, float], tuple[float, float, bool]]:
        altitude_ft, gamma_deg, rudder_deg = _failing(part)
        aileron_deg, fuel_used_lb, damage_case = (-20 + 8 * part, 20 - 12 * part), 8 * part, 5 if part > 0.5 else 0
        limits = ControlLimits(rudder_deg=rudder_deg, aileron_deg=aileron_deg)
        configuration = Configuration(damage_case=damage_case, fuel_used_lb=fuel_used_lb)
        left = envelope(altitude_ft, gamma_deg, Failure(limits, configuration))
        names = "limits.aileron.lower", "limits.aileron.upper", "damage.case", "fuel.used"
        angles = (angle * RAD_PER_DEG for angle in aileron_deg)
        given = dict(zip(names, (*angles, float(damage_case), fuel_used_lb * KG_PER_LB), strict=True))
        return given, (left.v_min_kt or 0.0, left.v_max_kt or 0.0, left.feasible)

    return _reference_envelopes(model, find_one)


def _failing(part: float, control: str = "rudder") -> tuple[float, float, tuple[float, float]]:
    """Altitude in ft, flight path and limits of a control in deg; in the end a jam at a sixth of its way."""
    sixth = WIDEST[f"{control}_deg"][1] / 6
    return 2000 + 20000 * part, -3 + 5 * part, ((-6 + 7 * part) * sixth, (5 - 4 * part) * sixth)


def _reference_envelopes(
    model: ModelDescription,
    find_one: Callable[[float], tuple[dict[str, float], tuple[float, float, bool]]],
    control: str = "rudder",
) -> dict[str, bytes]:
    """By ``find_one``: further inputs in SI and the envelope in kn at a part of the whole climb."""
    inputs, results = [], []
    more: dict[str, float] = {}
    for i in range(ENVELOPES):
        part, tas_kt = i / (ENVELOPES - 1), 90.0
        altitude_ft, gamma_deg, limits_deg = _failing(part, control)
        more, (v_min, v_max, feasible) = find_one(part)
        condition = (altitude_ft * M_PER_FT, *(angle * RAD_PER_DEG for angle in (gamma_deg, *limits_deg)))
        inputs.append([float(i), *condition, tas_kt * M_S_PER_KT, *more.values()])
        speeds = (v_min, v_max, tas_kt - v_min, v_max - tas_kt)
        results.append([float(i), *(speed * M_S_PER_KT for speed in speeds), float(feasible)])
    given = [variable.name for group in ("case", "speed") for variable in model.groups[group]]
    return _files(["time", *given, *more], inputs, ["time", *ENVELOPE_RESULTS], results)


def reference_manoeuvres(model: ModelDescription) -> dict[str, bytes]:
    """Inputs and results of ever faster and tighter turns with a jammed rudder; the last ones cannot be flown."""
    rudder_deg, gamma_deg, altitude_ft = 4.0, -2.0, 3000.0
    failure = Failure(ControlLimits(rudder_deg=(rudder_deg, rudder_deg)))
    given = ("altitude", "gamma", "tas", "turn_rate", "limits.rudder.lower", "limits.rudder.upper")
    inputs, results = [], []
    for i in range(ENVELOPES):
        tas_kt, turn_rate_deg_s = 75 + 5.0 * i, 2.0 * i - 4
        found = trim(altitude_ft, tas_kt, gamma_deg, turn_rate_deg_s, failure)
        gamma, turn_rate, rudder = (angle * RAD_PER_DEG for angle in (gamma_deg, turn_rate_deg_s, rudder_deg))
        inputs.append([float(i), altitude_ft * M_PER_FT, gamma, tas_kt * M_S_PER_KT, turn_rate, rudder, rudder])
        told = (found.alpha_deg, found.beta_deg, found.phi_deg, found.elevator_deg, found.aileron_deg, found.rudder_deg)
        throttle = (found.throttle_pct or 0.0) / 100
        results.append([float(i), *(angle * RAD_PER_DEG for angle in told), throttle, float(found.feasible)])
    names = [f"trim.{name}" for name in LIMITED[:-1]]
    return _files(["time", *given], inputs, ["time", *names, "feasible"], results)


def reference_samples(names: Sequence[str], X: np.ndarray, results: Sequence[str], Y: np.ndarray) -> dict[str, bytes]:
    """Inputs X (n, d) and results Y (n, m) of a user's model, one a second, in the folder ``extra``."""
    rows = ([[float(i), *row] for i, row in enumerate(values.tolist())] for values in (X, Y))
    inputs, outputs = rows
    return _files(["time", *names], inputs, ["time", *results], outputs)


def _files(given: list[str], inputs: list, found: list[str], results: list) -> dict[str, bytes]:
    names = ("reference_input", given, inputs), ("reference_result", found, results)
    return {f"{EXTRA}/{name}.csv": _csv(header, rows) for name, header, rows in names}


def _csv(header: list[str], rows: list[list[float]]) -> bytes:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(header)
    writer.writerows([[f"{value:.10g}" for value in row] for row in rows])
    return text.getvalue().encode()
