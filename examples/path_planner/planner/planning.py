"""A plan for a scenario: the path of least cost beside those that are least in another respect."""

import math
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import numpy as np

from examples.path_planner.planner.costs import Margins
from examples.path_planner.planner.field import CostToGo
from examples.path_planner.planner.flight import fly
from examples.path_planner.planner.glides import ENGINES_OUT, Glides, is_thrust_fixed
from examples.path_planner.planner.landing import Descent, Footprint, final_approach, path_to_a_runway
from examples.path_planner.planner.plan import Measures, NoPathError, Plan, Segment
from examples.path_planner.planner.primitives import Leg, Manoeuvre, Primitives
from examples.path_planner.planner.scenario import COSTS, Goal, Pose, Scenario
from examples.path_planner.planner.search import Search, State
from examples.path_planner.planner.sources import EnvelopeSource, ExactFmus, MapFmu
from fmu_src.fmus import build_fmu
from gtm_fmu.errors import InputError
from gtm_fmu.units import M_S_PER_KT

_SEGMENT_FT = 500.0
"""A longer climb or descent is told in parts, each with its own limits."""
_SAMPLE_S = 1.0
_SPEEDS = 24
"""Speeds that are compared."""


def exact_fmus(folder: Path, scenario: Scenario) -> ExactFmus:
    """The exact source, of the FMUs in a folder, which are built where they are missing.

    Raises:
        InputError: an FMU that cannot be built, or a failure that they do not know.
    """
    manoeuvre = _built(folder, "GtmManoeuvreNative", "manoeuvre-native")
    return ExactFmus(manoeuvre, _built(folder, "GtmEnvelopeNative", "envelope-native"), scenario.failure)


MAPS = {"GtmSurrogateNative": "surrogate-native", "GtmThrustMapNative": "thrust-map-native"}
"""FMUs of maps, and by which name they are built."""


def map_fmu(
    folder: Path,
    scenario: Scenario,
    model: str = "GtmThrustMapNative",
    surrogate: str | None = None,
    is_safe: bool = False,
) -> MapFmu:
    """A map as the source, from a folder; built where it is missing.

    Args:
        surrogate: what GtmSurrogateNative carries, as ``network``, in a folder of that name; default the thrust map.
        is_safe: whether to take the map's safe speeds.

    Raises:
        InputError: as `exact_fmus`, or a failure of more than the rudder.
    """
    place = folder / surrogate if surrogate else folder
    return MapFmu(_built(place, model, MAPS[model], surrogate), scenario.failure, is_safe, surrogate)


def _built(folder: Path, model: str, name: str, surrogate: str | None = None) -> Path:
    path = folder / f"{model}.fmu"
    if not path.exists():
        build_fmu(name, folder, surrogate)
    return path


def plan(
    scenario: Scenario, source: ExactFmus | MapFmu, alternatives: bool = True, say: Callable[[str], None] | None = None
) -> Plan:
    """The path of least cost, and with ``alternatives`` those of every other cost.

    To runways, where the scenario has no goal: with a thrust that cannot be chosen to the one that a glide
    reaches with most height to spare, and without alternatives; else to the one of least cost.

    Raises:
        NoPathError: nothing leads there.
    """
    check_start(scenario)
    if scenario.goal is None and is_thrust_fixed(scenario.failure):
        return _glide_to_a_runway(scenario, source)
    tas_kt = scenario.tas_kt or safest_speed(scenario, source)
    if scenario.goal is None:
        return _powered_landing(scenario, source, tas_kt)
    found = _plan_for(scenario, source, tas_kt, scenario.cost.of)
    if not alternatives:
        return found
    others = []
    for of in COSTS:
        if of != scenario.cost.of:
            if say:
                say(of)
            with suppress(NoPathError):  # the search gives up before it proves that there is none
                others.append(_plan_for(scenario, source, tas_kt, of))
    return replace(found, alternatives=tuple(others))


def _powered_landing(scenario: Scenario, source: ExactFmus | MapFmu, tas_kt: float) -> Plan:
    """To the runway of least cost, with its final."""
    found: list[Plan] = []
    reasons: list[str] = []
    for runway in scenario.runways:
        final = final_approach(runway, tas_kt, scenario)
        if final is None:
            reasons.append(f"The wind is too strong across runway {runway.name}.")
            continue
        there = replace(scenario, goal=final[0])
        try:
            one = _plan_for(there, source, tas_kt, scenario.cost.of, (final[1],))
        except NoPathError as error:
            reasons.append(str(error))
            continue
        found.append(replace(one, name=f"{one.name}, to {runway.name}"))
    if not found:
        raise NoPathError(f"No runway can be reached. {reasons[0]}")
    return min(found, key=lambda each: each.cost)


def footprint(scenario: Scenario, source: ExactFmus) -> Footprint:
    """What a glide reaches from the start; with engines that can be chosen, as if both were out.

    Raises:
        NoPathError: no straight glide, or no turns to both sides.
    """
    failure = scenario.failure if is_thrust_fixed(scenario.failure) else {**scenario.failure, **ENGINES_OUT}
    glides = Glides(source, failure)
    try:
        return Descent(scenario, glides).footprint()
    finally:
        glides.close()


def _glide_to_a_runway(scenario: Scenario, source: ExactFmus | MapFmu) -> Plan:
    if not isinstance(source, ExactFmus):
        raise InputError(f"{source.name} knows no glides; ask the exact FMUs.")
    began, asked = time.perf_counter(), source.queries
    glides = Glides(source, scenario.failure)
    try:
        runway, legs = path_to_a_runway(Descent(scenario, glides))
        margins = Margins(glides, scenario.failure, replace(scenario.cost, engine_out=False))
        found = told(f"glide to {runway.name}", scenario, legs, glides, margins, sum(leg.duration_s for leg in legs))
        return replace(found, seconds=time.perf_counter() - began, queries=glides.queries - asked)
    finally:
        glides.close()


def check_start(scenario: Scenario) -> None:
    """Raises NoPathError where the start is in the ground."""
    start = scenario.start
    ground = float(scenario.terrain.height(np.float64(start.north_m), np.float64(start.east_m)))
    if start.altitude_ft < ground + scenario.clearance_ft:
        if math.isinf(ground):
            raise NoPathError(
                f"The start at {start.north_m:g} m north, {start.east_m:g} m east lies outside the terrain; "
                f"{_extent(scenario)}."
            )
        raise NoPathError(
            f"The start at {start.altitude_ft:g} ft is {'in' if start.altitude_ft < ground else 'too near'} the ground "
            f"of {ground:.0f} ft there; with the clearance, {ground + scenario.clearance_ft:.0f} ft is the least."
        )


def _check_goal(scenario: Scenario, goal: Goal, source: EnvelopeSource, tas_kt: float) -> None:
    """Raises NoPathError for a goal in the ground or outside the terrain, or at an altitude that is not reached."""
    start_ft, (low, high) = scenario.start.altitude_ft, goal.altitude_ft
    ground = float(scenario.terrain.height(np.float64(goal.north_m), np.float64(goal.east_m)))
    where = f"The goal at {goal.north_m:.0f} m north, {goal.east_m:.0f} m east"
    if math.isinf(ground):
        raise NoPathError(f"{where} lies outside the terrain; {_extent(scenario)}.")
    if high < ground + scenario.clearance_ft - 1e-6:
        least = ground + scenario.clearance_ft
        raise NoPathError(
            f"{where} and {low:g} to {high:g} ft is too near the ground of {ground:.0f} ft there, or in it; with the "
            f"clearance, {least:.0f} ft is the least."
        )
    nearest = min(max(start_ft, low), high)
    sought = {
        1: [g for g in scenario.gammas_deg if g > 0],
        0: list(scenario.gammas_deg),
        -1: [g for g in scenario.gammas_deg if g < 0],
    }[int(np.sign(nearest - start_ft))]
    reached = start_ft
    for altitude in np.linspace(start_ft, nearest, max(2, math.ceil(abs(nearest - start_ft) / _SEGMENT_FT))).tolist():
        if all(source.turn_rates(altitude, gamma, tas_kt) is None for gamma in sought):
            way = "climb" if nearest > start_ft else "descend" if nearest < start_ft else "fly"
            raise NoPathError(
                f"At {tas_kt:g} kn the aircraft does not {way} to {nearest:.0f} ft on the flight paths to choose from; "
                f"it gets to about {reached:.0f} ft."
            )
        reached = altitude


def _extent(scenario: Scenario) -> str:
    ground = scenario.terrain
    return (
        f"it reaches from {ground.north_m[0]:g} to {ground.north_m[-1]:g} m north and from {ground.east_m[0]:g} to "
        f"{ground.east_m[-1]:g} m east"
    )


def safest_speed(scenario: Scenario, source: EnvelopeSource) -> float:
    """The speed in kn with the most margin at the start, now and after a second failure.

    On the flight path next to level on which flight is possible, and of speeds at which the aircraft turns both ways,
    if there are any. A second failure that leaves nothing at any speed is of no consequence for the choice.

    Raises:
        NoPathError: no steady flight is possible.
    """
    margins = Margins(source, scenario.failure, scenario.cost)
    altitude, found = scenario.start.altitude_ft, []
    for gamma in sorted(scenario.gammas_deg, key=lambda each: (abs(each), each)):
        for tas, inside, ends in _turning(scenario, source, altitude, gamma):
            after = [m for m in margins.after(altitude, gamma, tas).values() if m is not None]
            found.append((ends[0] < 0 < ends[1], min([inside, *after]), float(round(tas))))
        if found:
            return max(found)[-1]
    raise NoPathError(_no_envelope(scenario, source))


def _turning(
    scenario: Scenario, source: EnvelopeSource, altitude_ft: float, gamma_deg: float
) -> Iterator[tuple[float, float, tuple[float, float]]]:
    """Speeds in kn between V_min and V_max, how far inside these they are, and the turn rates that are left there."""
    speeds = source.speeds(altitude_ft, gamma_deg, scenario.failure)
    for tas in np.linspace(*speeds, _SPEEDS + 2)[1:-1].tolist() if speeds else ():
        ends = source.turn_rates(altitude_ft, gamma_deg, tas)
        if ends is not None:
            yield tas, min(tas - speeds[0], speeds[1] - tas), ends


def _no_envelope(scenario: Scenario, source: EnvelopeSource) -> str:
    """With the nearest flight path and the nearest altitude that leave some."""
    start = scenario.start

    def is_left(altitude_ft: float, gamma_deg: float) -> bool:
        return any(True for _ in _turning(scenario, source, altitude_ft, gamma_deg))

    text = f"No steady flight on any of the flight paths is left at {start.altitude_ft:g} ft after this failure"
    paths = [g for g in np.arange(-20.0, 20.5, 0.5).tolist() if is_left(start.altitude_ft, g)]
    if paths:
        return f"{text}; the nearest that is possible there is {min(paths, key=abs):g} deg."
    altitudes = np.arange(0.0, 30_000.0, 1000.0).tolist()
    lower = [h for h in altitudes if any(is_left(h, g) for g in scenario.gammas_deg)]
    if lower:
        nearest = min(lower, key=lambda h: abs(h - start.altitude_ft))
        return f"{text}; the nearest altitude that leaves some is {nearest:g} ft."
    return f"{text}, nor at any other altitude."


def _plan_for(scenario: Scenario, source: EnvelopeSource, tas_kt: float, of: str, final: tuple[Leg, ...] = ()) -> Plan:
    """The path of least cost to the scenario's goal, with legs that follow there."""
    began, asked = time.perf_counter(), source.queries
    margins = Margins(source, scenario.failure, replace(scenario.cost, of=of))
    goal = scenario.goal
    if goal is None:
        raise NoPathError("There is no goal.")
    _check_goal(scenario, goal, source, tas_kt)
    primitives = Primitives(source, tas_kt, scenario.gammas_deg, scenario.reserve, scenario.start.altitude_ft)
    memo: dict[tuple[int, float], float] = {}

    def rate(altitude_ft: float, manoeuvre: Manoeuvre, ground_m_s: float) -> float:
        if of == "distance":
            return ground_m_s
        key = round(altitude_ft / _SEGMENT_FT), round(manoeuvre.gamma_deg)
        if key not in memo:
            memo[key] = margins.rate(key[0] * _SEGMENT_FT, float(key[1]), tas_kt, ground_m_s)
        return memo[key]

    fastest = tas_kt * M_S_PER_KT + math.hypot(*scenario.wind)
    level_m_s = tas_kt * M_S_PER_KT

    def coarse(altitude_ft: float, gamma_deg: float) -> float | None:
        """Where the flight path can be flown in any way."""
        if not scenario.gammas_deg[0] <= gamma_deg <= scenario.gammas_deg[-1]:
            return None
        if source.turn_rates(round(altitude_ft / 500.0) * 500.0, round(gamma_deg), tas_kt) is None:
            return None
        return rate(altitude_ft, Manoeuvre(gamma_deg, tas_kt, 0.0), level_m_s)

    to_go = CostToGo(scenario, goal, tas_kt, coarse)
    slowest = max(level_m_s - math.hypot(*scenario.wind), 0.0)
    least = margins.least_rate(fastest) / fastest, margins.least_rate(slowest)
    search = Search(scenario, goal, primitives, rate, to_go, *least)
    states = search.run()
    if states is None:
        raise NoPathError(_no_path(scenario, goal, search))
    legs = merged([leg for state in states for leg in state.legs] + list(final))
    found = told(of, scenario, legs, source, margins, states[-1].cost)
    return replace(found, seconds=time.perf_counter() - began, queries=source.queries - asked)


def _no_path(scenario: Scenario, goal: Goal, search: Search) -> str:
    state: State | None = search.nearest
    pose = state.pose if state else scenario.start
    return (
        f"No path leads to {goal.north_m:g} m north, {goal.east_m:g} m east at {goal.altitude_ft[0]:g} to "
        f"{goal.altitude_ft[1]:g} ft; the nearest that was reached is {search.distance_m(pose):.0f} m short of it at "
        f"{pose.altitude_ft:.0f} ft."
    )


def merged(legs: list[Leg]) -> list[Leg]:
    """The same with equal manoeuvres that follow each other as one."""
    found: list[Leg] = []
    for leg in legs:
        if found and found[-1].manoeuvre == leg.manoeuvre:
            found[-1] = Leg(leg.manoeuvre, found[-1].duration_s + leg.duration_s)
        else:
            found.append(leg)
    return found


def told(name: str, scenario: Scenario, legs: list[Leg], source: EnvelopeSource, margins: Margins, cost: float) -> Plan:
    """The plan of some legs: sampled, and each segment asked for again where it begins."""
    pose, now_s, segments = scenario.start, 0.0, []
    columns: list[np.ndarray] = []
    for leg in legs:
        climb = abs(float(fly(pose, leg, np.float64(leg.duration_s), scenario)[2]) - pose.altitude_ft)
        count = max(1, math.ceil(climb / _SEGMENT_FT - 1e-9))
        part = Leg(leg.manoeuvre, leg.duration_s / count)
        for _ in range(count):
            segments.append(segment(pose, part, now_s, source, margins))
            times = np.linspace(0.0, part.duration_s, max(2, math.ceil(part.duration_s / _SAMPLE_S) + 1))
            track = np.array([now_s + times, *fly(pose, part, times, scenario)])
            columns.append(track if not columns else track[:, 1:])
            pose, now_s = Pose(*(float(value) for value in track[1:, -1])), now_s + part.duration_s
    table = np.concatenate(columns, axis=1)
    measures = measured(segments, table, scenario)
    return Plan(name, tuple(segments), *table, cost=cost, measures=measures, source=source.name)


def segment(pose: Pose, leg: Leg, start_s: float, source: EnvelopeSource, margins: Margins) -> Segment:
    """All about a leg at its beginning."""
    gamma, tas, rate = leg.manoeuvre
    answer = source.answer(pose.altitude_ft, gamma, tas, rate)
    speeds = source.speeds(pose.altitude_ft, gamma, margins.failure) or (math.nan, math.nan)
    return Segment(
        start_s=start_s,
        duration_s=leg.duration_s,
        north_m=pose.north_m,
        east_m=pose.east_m,
        altitude_ft=pose.altitude_ft,
        heading_deg=pose.heading_deg % 360.0,
        tas_kt=tas,
        gamma_deg=gamma,
        turn_rate_deg_s=rate,
        bank_deg=answer.trim.get("bank_deg", math.nan),
        controls=answer.trim,
        v_min_kt=speeds[0],
        v_max_kt=speeds[1],
        turn_rates_deg_s=source.turn_rates(pose.altitude_ft, gamma, tas) or (math.nan, math.nan),
        margins=answer.margins,
        binding=answer.binding,
        second_failures_kt=margins.after(pose.altitude_ft, gamma, tas),
    )


def measured(segments: list[Segment], track: np.ndarray, scenario: Scenario) -> Measures:
    """Of a path in every respect; ``track`` has the rows time, north, east, altitude, heading."""
    left = [s.second_failures_kt.values() for s in segments]
    worst = [None if None in each else min(each, default=math.inf) for each in left]  # type: ignore[type-var]
    exposed = sum(s.duration_s for s, w in zip(segments, worst, strict=True) if w is None or w < 0)
    known = [w for w in worst if w is not None]
    height = track[3] - scenario.terrain.height(track[1], track[2])
    return Measures(
        time_s=float(track[0, -1]),
        distance_m=float(np.hypot(np.diff(track[1]), np.diff(track[2])).sum()),
        margin_kt=min(s.margin_kt for s in segments),
        second_failure_kt=None if len(known) < len(worst) else min(known),
        exposed_s=float(exposed),
        clearance_ft=float(height.min()),
    )
