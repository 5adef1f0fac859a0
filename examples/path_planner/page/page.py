"""The page of a plan and its flights: what is drawn, what is told, and the file that holds it all."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import jinja2
import numpy as np
from contourpy import FillType, contour_generator
from markupsafe import Markup

from examples.path_planner.flight.review import Review
from examples.path_planner.page.charts import Chart, spread
from examples.path_planner.planner.plan import Plan, Segment
from examples.path_planner.planner.scenario import Scenario

_LEVELS, _ROOM_M = 8, 700.0
_KM = 1e-3


@dataclass(frozen=True)
class Outcome:
    """Everything that the page tells.

    Attributes:
        flights: of the plan, by the tool that flew it.
        healthy: the plan that the same planner makes for the aircraft in order; None where there is none.
        healthy_flight: that plan flown with the failure.
        notes: what was left out, and why, in sentences.
    """

    scenario: Scenario
    plan: Plan
    flights: dict[str, Review]
    healthy: Plan | None
    healthy_flight: Review | None
    notes: tuple[str, ...] = ()

    @property
    def flown(self) -> Review | None:
        """The plan's first flight."""
        return next(iter(self.flights.values()), None)


def render(outcome: Outcome) -> str:
    """The page."""
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(Path(__file__).parent),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template("page.html.j2").render(
        outcome=outcome,
        scenario=outcome.scenario,
        failure=_failure(outcome.scenario),
        plan=outcome.plan,
        plans=(outcome.plan, *outcome.plan.alternatives),
        flown=outcome.flown,
        charts={name: Markup(svg) for name, svg in _charts(outcome).items()},
        segments=[(segment, _tightest(segment)) for segment in outcome.plan.segments],
        flights=[
            *(("for the failure", review) for review in outcome.flights.values()),
            *([("for the aircraft in order", outcome.healthy_flight)] if outcome.healthy_flight else []),
        ],
        further=list(outcome.plan.segments[0].second_failures_kt),
    )


def _failure(scenario: Scenario) -> str:
    told = [
        f"{name} = {value:g}" if not isinstance(value, bool) else f"{name} = {str(value).lower()}"
        for name, value in scenario.failure.items()
    ]
    return ", ".join(told) or "nothing"


def _tightest(segment: Segment) -> str:
    """The margin that binds, with its unit."""
    control, _, end = segment.binding.rpartition(".")
    for name, pair in segment.margins.items():
        what, _, unit = name.rpartition("_")
        if what == control.replace(".", "_"):
            return f"{pair[end == 'upper']:.1f} {'%' if unit == 'pct' else unit} to {control} {end}"
    return segment.binding


def _charts(outcome: Outcome) -> dict[str, str]:
    charts = {"map": _map(outcome), "altitude": _altitude(outcome), "margin": _margins(outcome.plan)}
    if outcome.flown is not None:
        charts |= {"speed": _speed(outcome.plan, outcome.flown), "turn": _turn(outcome.plan, outcome.flown)}
        charts["limits"] = _limits(outcome.flown)
    return charts


def _map(outcome: Outcome) -> str:
    scenario, plan = outcome.scenario, outcome.plan
    tracks = [plan, *plan.alternatives, *([outcome.healthy] if outcome.healthy else [])]
    places = [(scenario.start.north_m, scenario.start.east_m)]
    places += [(runway.north_m, runway.east_m) for runway in scenario.runways]
    if scenario.goal:
        places.append((scenario.goal.north_m, scenario.goal.east_m))
    north_m = np.concatenate([*(track.north_m for track in tracks), [place[0] for place in places]])
    east_m = np.concatenate([*(track.east_m for track in tracks), [place[1] for place in places]])
    north = (north_m.min() - _ROOM_M) * _KM, (north_m.max() + _ROOM_M) * _KM
    east = (east_m.min() - _ROOM_M) * _KM, (east_m.max() + _ROOM_M) * _KM
    short = 0.75 * (north[1] - north[0]) - (east[1] - east[0])
    if short > 0:
        east = east[0] - short / 2, east[1] + short / 2
    chart = Chart.of_map(east, north, ("east in km", "north in km"))
    _ground(chart, scenario)
    for other in plan.alternatives:
        chart.line(other.east_m * _KM, other.north_m * _KM, "other")
    if outcome.healthy:
        chart.line(outcome.healthy.east_m * _KM, outcome.healthy.north_m * _KM, "healthy dashed")
    chart.line(plan.east_m * _KM, plan.north_m * _KM, "plan")
    for review, name in ((outcome.healthy_flight, "healthy"), (outcome.flown, "flown")):
        if review is not None:
            columns = review.flight.columns
            chart.line(columns["east_m"] * _KM, columns["north_m"] * _KM, name)
            if not review.flight.is_complete:
                chart.cross(columns["east_m"][-1] * _KM, columns["north_m"][-1] * _KM, f"{name} end")
    chart.circle(places[0][1] * _KM, places[0][0] * _KM, 0.0, "start")
    chart.text(places[0][1] * _KM, places[0][0] * _KM, "start")
    if scenario.goal:
        chart.circle(scenario.goal.east_m * _KM, scenario.goal.north_m * _KM, scenario.goal.radius_m * _KM, "goal")
        chart.text(scenario.goal.east_m * _KM, scenario.goal.north_m * _KM, "goal")
    for runway in scenario.runways:
        chart.circle(runway.east_m * _KM, runway.north_m * _KM, 0.0, "goal")
        chart.text(runway.east_m * _KM, runway.north_m * _KM, runway.name)
    alt = f"Plan view, north up: the path of {plan.measures.distance_m * _KM:.1f} km from the start over the terrain"
    return chart.svg("map", alt + ("; the flown path lies on it." if _on_track(outcome) else "."))


def _on_track(outcome: Outcome) -> bool:
    return outcome.flown is not None and outcome.flown.left_track_s is None


def _ground(chart: Chart, scenario: Scenario) -> None:
    """Heights as areas, the darker the higher, of what the chart shows."""
    north, east = (np.linspace(*axis, 90) for axis in (chart.y, chart.x))
    height = scenario.terrain.height(*np.meshgrid(north / _KM, east / _KM, indexing="ij"))
    known = np.isfinite(height)
    if not known.any() or np.ptp(height[known]) < 1.0:
        return
    levels = np.linspace(height[known].min(), height[known].max(), _LEVELS + 1)
    contours = contour_generator(east, north, np.ma.masked_invalid(height), fill_type=FillType.OuterOffset)
    for k, low in enumerate(levels[1:-1], 1):
        for points, offsets in zip(*contours.filled(low, np.inf), strict=True):
            chart.area(np.split(points, offsets[1:-1]), f"ground g{k}")


def _altitude(outcome: Outcome) -> str:
    plan, flown, terrain = outcome.plan, outcome.flown, outcome.scenario.terrain
    ground = terrain.height(plan.north_m, plan.east_m)
    columns = flown.flight.columns if flown else None
    seen = [plan.altitude_ft, ground] + ([columns["altitude_ft"]] if columns else [])
    chart = Chart((0.0, float(plan.time_s[-1])), spread(*seen), ("time in s", "altitude in ft"))
    chart.band(plan.time_s, np.full_like(ground, chart.y[0]), ground, "ground g8")
    if outcome.scenario.clearance_ft:
        chart.line(plan.time_s, ground + outcome.scenario.clearance_ft, "limit dashed")
    chart.line(plan.time_s, plan.altitude_ft, "plan")
    if columns:
        chart.line(columns["plan_s"], columns["altitude_ft"], "flown")
    alt = (
        f"Altitude over time, from {plan.altitude_ft[0]:.0f} to {plan.altitude_ft[-1]:.0f} ft, "
        f"{plan.measures.clearance_ft:.0f} ft above the ground at least."
    )
    return chart.svg("altitude", alt)


def _steps(plan: Plan, values: Sequence[float | None]) -> tuple[np.ndarray, np.ndarray]:
    """Time and value (2 n each) of what is constant over a segment; NaN for None."""
    starts = np.array([segment.start_s for segment in plan.segments])
    ends = starts + [segment.duration_s for segment in plan.segments]
    levels = np.array([np.nan if value is None else value for value in values], float)
    return np.stack([starts, ends], axis=1).ravel(), np.repeat(levels, 2)


def _margins(plan: Plan) -> str:
    """Of the speed, now and after each second failure."""
    lines = {"plan": [segment.margin_kt for segment in plan.segments]}
    for k, name in enumerate(plan.segments[0].second_failures_kt):
        lines[f"further f{k}"] = [segment.second_failures_kt[name] for segment in plan.segments]
    drawn = {name: _steps(plan, values) for name, values in lines.items()}
    span = spread(*(values for _, values in drawn.values()), np.zeros(1))
    chart = Chart((0.0, float(plan.time_s[-1])), span, ("time in s", "margin in kn"))
    chart.line(np.array(chart.x), np.zeros(2), "limit dashed")
    for name, (time, values) in drawn.items():
        chart.line(time, values, name)
    return chart.svg("margin", f"Margin of the speed along the plan: {plan.measures.margin_kt:.0f} kn at least.")


def _speed(plan: Plan, flown: Review) -> str:
    tas = flown.flight.columns["tas_kt"]
    span = spread(flown.v_min_kt, flown.v_max_kt, tas)
    chart = Chart((0.0, float(flown.time_s[-1])), span, ("time in s", "true airspeed in kn"))
    chart.band(flown.time_s, flown.v_min_kt, flown.v_max_kt, "left")
    chart.line(*_steps(plan, [segment.tas_kt for segment in plan.segments]), "plan")
    chart.line(flown.flight.columns["time_s"], tas, "flown")
    least = flown.least["tas_kt"]
    return chart.svg(
        "speed", f"Flown airspeed between V_min and V_max over time; it is {least:.0f} kn inside at least."
    )


def _turn(plan: Plan, flown: Review) -> str:
    rate, (low, high) = flown.flight.columns["turn_rate_deg_s"], flown.turns_deg_s.T
    chart = Chart((0.0, float(flown.time_s[-1])), spread(low, high, rate), ("time in s", "turn rate in deg/s"))
    chart.band(flown.time_s, low, high, "left")
    chart.line(*_steps(plan, [segment.turn_rate_deg_s for segment in plan.segments]), "plan")
    chart.line(flown.flight.columns["time_s"], rate, "flown")
    least = flown.least["turn_rate_deg_s"]
    alt = f"Flown turn rate and the turns that are left over time; the least margin is {least:.1f} deg/s."
    return chart.svg("turn", alt)


def _limits(flown: Review) -> str:
    """Alpha and bank to their bounds."""
    drawn = {"plan": flown.margins["alpha_deg"], "flown": flown.margins["bank_deg"]}
    span = spread(*drawn.values(), np.zeros(1))
    chart = Chart((0.0, float(flown.time_s[-1])), span, ("time in s", "margin in deg"))
    chart.line(np.array(chart.x), np.zeros(2), "limit dashed")
    for name, values in drawn.items():
        chart.line(flown.time_s, values, name)
    alpha, bank = flown.least["alpha_deg"], flown.least["bank_deg"]
    alt = f"Margins of alpha and bank along the flight: {alpha:.1f} and {bank:.1f} deg at least."
    return chart.svg("limits", alt)
