"""Paths for an aircraft with a failure, along steady manoeuvres that its FMUs say are left.

from examples.path_planner.planner import exact_fmus, plan, read_scenario

scenario = read_scenario("examples/path_planner/scenarios/ridge.toml")
found = plan(scenario, exact_fmus(Path("build/fmu"), scenario))
"""

from examples.path_planner.planner.landing import Footprint, Reach
from examples.path_planner.planner.plan import Measures, NoPathError, Plan, Segment
from examples.path_planner.planner.planning import exact_fmus, footprint, plan
from examples.path_planner.planner.scenario import Scenario, read_scenario

__all__ = [
    "Footprint",
    "Measures",
    "NoPathError",
    "Plan",
    "Reach",
    "Scenario",
    "Segment",
    "exact_fmus",
    "footprint",
    "plan",
    "read_scenario",
]
