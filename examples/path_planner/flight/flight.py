"""A flight of GtmAircraft along a plan: straight and level in order, the failure, a few seconds later the plan."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from examples.path_planner.flight.failure import BOUNDS, bounds_of, failure_of
from examples.path_planner.flight.guidance import Guide, Place
from examples.path_planner.flight.importers import IMPORTERS, Aircraft
from examples.path_planner.flight.pilot import ASKED_EVERY_S, Pilot
from examples.path_planner.planner.plan import Plan
from examples.path_planner.planner.scenario import Scenario
from examples.path_planner.planner.sources import display_factors
from examples.transitions.autopilot import states_in_air
from examples.transitions.path import Manoeuvre
from fmu_src.fmus import build_fmu
from gtm_fmu import Failure, trim
from gtm_fmu.aircraft.fmu_file import read_description
from gtm_fmu.aircraft.ranges import CONTROL_SI
from gtm_fmu.airframe.motion import NAVIGATION_RADIUS_FT
from gtm_fmu.airframe.names import CONTROLS, control_variable, state_variable
from gtm_fmu.envelopes.manoeuvres import manoeuvres
from gtm_fmu.units import DEG_PER_RAD, M_PER_FT, M_S_PER_KT, RAD_PER_DEG

STEP_S = 0.02
LEAD_S, FAILED_S = 10.0, 8.0
"""Before the plan begins: the flight starts; the failure happens, where straight and level flight is left."""
LATEST = 1.3
"""Times of the plan after which a flight that has not come to its end is given up."""
LOST_M = 5000.0
_READ = (
    *("air.tas", "air.alpha", "air.beta", "state.p", "state.q", "state.r", "state.phi", "state.theta", "state.psi"),
    *("state.latitude", "state.longitude", "state.altitude"),
    *("der(state.latitude)", "der(state.longitude)", "der(state.altitude)"),
    *(f"surface.{name}" for name in CONTROLS[:3]),
    "engine.throttle",
)
COLUMNS = (
    *("time_s", "plan_s", "north_m", "east_m", "altitude_ft", "heading_deg", "across_m", "above_ft"),
    *("tas_kt", "gamma_deg", "alpha_deg", "beta_deg", "bank_deg"),
    *("elevator_deg", "aileron_deg", "rudder_deg", "throttle_pct"),
)
RADIUS_M = NAVIGATION_RADIUS_FT * M_PER_FT


@dataclass(frozen=True)
class Flight:
    """What was flown.

    Attributes:
        tool: which flew it.
        end: why it ended, in words.
        is_complete: whether it came to the end of the plan.
        columns: `COLUMNS` (n) by name and the path's ``turn_rate_deg_s``, every `ASKED_EVERY_S`; ``time_s`` is zero
            where the plan begins.
    """

    tool: str
    end: str
    is_complete: bool
    columns: dict[str, np.ndarray]


def aircraft_fmu(folder: Path) -> Path:
    """The aircraft's FMU in a folder, built where it is missing.

    Raises:
        InputError: it cannot be built.
    """
    path = folder / "GtmAircraftNative.fmu"
    return path if path.exists() else build_fmu("aircraft-native", folder)


def fly(fmu: Path, scenario: Scenario, plan: Plan, tool: str = "FMPy") -> Flight:
    """Fly a plan with the scenario's failure, which happens shortly before it begins.

    Raises:
        InputError: a failure that the aircraft does not have.
    """
    failure, bounds = failure_of(scenario.failure), bounds_of(scenario.failure)
    first = plan.segments[0]
    start = Manoeuvre(first.tas_kt)
    is_straight_left = manoeuvres(scenario.start.altitude_ft, *start, failure, *bounds).feasible[0]
    failed_s = LEAD_S - FAILED_S if is_straight_left else LEAD_S
    aircraft = IMPORTERS[tool](fmu, _start(fmu, scenario, start, failed_s), STEP_S)
    pilot, guide = Pilot(start, scenario.start.altitude_ft, Failure(), bounds), Guide(plan, LEAD_S, scenario.wind)
    rows, end = [], "it was not at its end in time"
    asked_every = round(ASKED_EVERY_S / STEP_S)
    try:
        for step in range(round((LEAD_S + LATEST * guide.end_s) / STEP_S)):
            now_s = step * STEP_S - LEAD_S
            seen = _Seen.of(aircraft, scenario)
            if step % asked_every == 0:
                if step == round(failed_s / STEP_S):
                    pilot.fails(failure)
                pilot.steer(seen.place.altitude_ft, guide.manoeuvre(seen.place), now_s)
                rows.append([now_s, guide.at_s, *seen.place, guide.across_m, guide.above_ft, *seen.told])
                if reason := _ended(seen.place, guide, scenario):
                    end = reason
                    break
            commands = pilot.commands(seen.states, now_s) * CONTROL_SI
            aircraft.set(tuple(map(control_variable, CONTROLS)), commands.tolist())
            aircraft.step()
    except RuntimeError as error:  # an FMU that refuses a step; FmuError is one
        end = f"the aircraft could not go on: {error}"
    finally:
        aircraft.close()
    columns = dict(zip(COLUMNS, np.array(rows).T, strict=True))
    heading = np.unwrap(columns["heading_deg"], period=360.0)
    return Flight(tool, end, guide.is_over, columns | {"turn_rate_deg_s": np.gradient(heading, columns["time_s"])})


def _ended(place: Place, guide: Guide, scenario: Scenario) -> str:
    ground = float(scenario.terrain.height(np.float64(place.north_m), np.float64(place.east_m)))
    if place.altitude_ft <= ground:
        return "it hits the ground" if np.isfinite(ground) else "it leaves the terrain"
    if abs(guide.across_m) > LOST_M:
        return f"it is more than {LOST_M:.0f} m off the track"
    return "it is at its end" if guide.is_over else ""


def _start(fmu: Path, scenario: Scenario, manoeuvre: Manoeuvre, failed_s: float) -> dict[str, float | bool]:
    """Start values in SI: straight and level in order, `LEAD_S` before the plan's start, and what fails when."""
    pose, wind = scenario.start, scenario.wind
    level = trim(pose.altitude_ft, manoeuvre.tas_kt, limits=Failure(), turn_rate_deg_s=0.0)
    values: dict[str, float | bool] = dict(level.start_values())
    body = np.array([values[state_variable(name)] for name in ("u", "v", "w")], float)
    phi, theta = (float(values[state_variable(name)]) for name in ("phi", "theta"))
    through_air = Rotation.from_euler("ZYX", [0.0, theta, phi]).apply(body)
    psi = pose.heading_deg * RAD_PER_DEG - float(np.arctan2(through_air[1], through_air[0]))
    to_earth = Rotation.from_euler("ZYX", [psi, theta, phi])
    drift = np.array([wind.north_m_s, wind.east_m_s, 0.0])
    velocity = to_earth.apply(body) + drift
    values |= dict(zip(map(state_variable, ("u", "v", "w")), to_earth.inv().apply(velocity).tolist(), strict=True))
    north, east = pose.north_m - LEAD_S * velocity[0], pose.east_m - LEAD_S * velocity[1]
    values["state.latitude"], values["state.longitude"] = north / RADIUS_M, east / RADIUS_M
    values["state.psi"] = psi
    values |= {"wind.north": drift[0], "wind.east": drift[1], "wind.shear": False, "failure.time": failed_s}
    factors = display_factors(read_description(fmu))
    for name, value in scenario.failure.items():
        if name not in BOUNDS:
            values[name] = value if isinstance(value, bool) else value / factors[name]
    return values


@dataclass(frozen=True)
class _Seen:
    """What the autopilot sees: place, states (8) relative to the air, and the last columns of the record."""

    place: Place
    states: np.ndarray
    told: list[float]

    @classmethod
    def of(cls, aircraft: Aircraft, scenario: Scenario) -> "_Seen":
        seen = dict(zip(_READ, aircraft.get(_READ).tolist(), strict=True))
        radius, latitude = RADIUS_M + seen["state.altitude"], seen["state.latitude"]
        north_m, east_m = RADIUS_M * latitude, RADIUS_M * seen["state.longitude"]
        north = seen["der(state.latitude)"] * radius - scenario.wind.north_m_s
        east = seen["der(state.longitude)"] * radius * np.cos(latitude) - scenario.wind.east_m_s
        heading = float(np.arctan2(east, north)) * DEG_PER_RAD % 360.0
        gamma = float(np.arctan2(seen["der(state.altitude)"], np.hypot(north, east))) * DEG_PER_RAD
        tas_kt = seen["air.tas"] / M_S_PER_KT
        alpha, beta, phi = (seen[name] * DEG_PER_RAD for name in ("air.alpha", "air.beta", "state.phi"))
        rates = np.array([seen[f"state.{name}"] for name in ("p", "q", "r", "phi", "theta")])
        told = [tas_kt, gamma, alpha, beta, phi]
        told += [seen[f"surface.{name}"] * DEG_PER_RAD for name in CONTROLS[:3]] + [seen["engine.throttle"] * 100.0]
        place = Place(north_m, east_m, seen["state.altitude"] / M_PER_FT, heading)
        return cls(place, states_in_air(tas_kt, alpha, beta, rates), told)
