"""Plan a path for an aircraft with a failure, fly it, and leave a page of it.

python examples/path_planner/run.py [scenario.toml] [--output build/path_planner] [--tools FMPy ecospy]

A scenario names the failure, the start, the terrain, the goal or runways and what the path should cost least: copy one
of examples/path_planner/scenarios. Exit code 2 is bad input, 3 a request that cannot be met.
"""

import argparse
import multiprocessing
import sys
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path

from rich.console import Console

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from examples.path_planner.flight.failure import failure_of  # noqa: E402
from examples.path_planner.flight.flight import aircraft_fmu, fly  # noqa: E402
from examples.path_planner.flight.importers import IMPORTERS, PACKAGES  # noqa: E402
from examples.path_planner.flight.review import Review, review  # noqa: E402
from examples.path_planner.page.figure import draw  # noqa: E402
from examples.path_planner.page.page import Outcome, render  # noqa: E402
from examples.path_planner.planner import NoPathError, Plan, Scenario, exact_fmus, plan, read_scenario  # noqa: E402
from examples.path_planner.planner.glides import is_thrust_fixed  # noqa: E402
from gtm_fmu.errors import InputError  # noqa: E402
from gtm_fmu.files import writable_folder, write_whole  # noqa: E402
from gtm_study.progress import stages  # noqa: E402

USUAL = Path(__file__).with_name("scenarios") / "right.toml"
PROCESSES = 2
FIXED = "Not flown: the autopilot holds speed and flight path by the throttle, which this failure does not leave."


def planned(scenario: Scenario, folder: Path, alternatives: bool) -> Plan:
    """The plan, by the exact FMUs of a folder.

    Raises:
        InputError, NoPathError: as `planner.plan`.
    """
    source = exact_fmus(folder, scenario)
    try:
        return plan(scenario, source, alternatives)
    finally:
        source.close()


def flown(fmu: Path, scenario: Scenario, path: Plan, tool: str) -> Review:
    """A flight and what came of it."""
    return review(fly(fmu, scenario, path, tool), scenario)


def run(scenario: Scenario, folder: Path, tools: list[str], stage) -> Outcome:
    """Plan for the failure and for the aircraft in order, and fly both.

    Raises:
        InputError: an FMU that cannot be built, or a failure that the FMUs do not know.
        NoPathError: there is no path.
    """
    notes: list[str] = []
    with stage("Build"):
        fmu = aircraft_fmu(folder)
    with stage("Plan"):
        path = planned(scenario, folder, alternatives=True)
    if is_thrust_fixed(scenario.failure):
        return Outcome(scenario, path, {}, None, None, (FIXED,))
    healthy = None
    with stage("Plan for the aircraft in order"):
        try:
            in_order = replace(scenario, failure={}, cost=replace(scenario.cost, of="time"))
            healthy = planned(in_order, folder, alternatives=False)
        except NoPathError as error:
            notes.append(f"For the aircraft in order there is no path either: {error}")
    try:
        failure_of(scenario.failure)
    except InputError as error:
        return Outcome(scenario, path, {}, healthy, None, (*notes, f"Not flown: {error}"))
    with stage("Fly"):
        flights, healthy_flight = _fly(fmu, scenario, path, healthy, tools, notes)
    return Outcome(scenario, path, flights, healthy, healthy_flight, tuple(notes))


def _fly(
    fmu: Path, scenario: Scenario, path: Plan, healthy: Plan | None, tools: list[str], notes: list[str]
) -> tuple[dict[str, Review], Review | None]:
    """Each flight in a process of its own, so that a tool that fails ends its own flight only."""
    context = multiprocessing.get_context("spawn")
    usable = [tool for tool in tools if find_spec(PACKAGES[tool])]
    notes += [f"{tool} is not installed." for tool in tools if tool not in usable]
    asked = [(path, tool) for tool in usable] + ([(healthy, usable[0])] if healthy and usable else [])
    pools = [ProcessPoolExecutor(1, context) for _ in range(min(PROCESSES, len(asked)))]
    try:
        waiting = [pools[k % len(pools)].submit(flown, fmu, scenario, *each) for k, each in enumerate(asked)]
        done = [_result(future, tool, notes) for future, (_, tool) in zip(waiting, asked, strict=True)]
    finally:
        for pool in pools:
            pool.shutdown(cancel_futures=True)
    of_plan = {tool: found for tool, found in zip(usable, done, strict=False) if found is not None}
    return of_plan, done[-1] if len(done) > len(usable) else None


def _result(future: "Future[Review]", tool: str, notes: list[str]) -> Review | None:
    try:
        return future.result()
    except (RuntimeError, OSError, BrokenProcessPool) as error:
        notes.append(f"{tool} cannot fly it: {error}")
        return None


def main() -> int:
    """Plan, fly, write; 2 for bad input, 3 where there is no path."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenario", type=Path, nargs="?", default=USUAL, help="a TOML file")
    parser.add_argument("--output", type=Path, default=Path("build/path_planner"), help="folder of the page")
    parser.add_argument("--tools", nargs="+", choices=IMPORTERS, default=list(IMPORTERS), help="which fly the plan")
    given = parser.parse_args()
    console = Console(stderr=True)
    try:
        scenario = read_scenario(given.scenario)
        folder = writable_folder(given.output)
        with stages(Console(stderr=True, quiet=not console.is_terminal)) as stage:
            outcome = run(scenario, folder, given.tools, stage)
        page = folder / f"{given.scenario.stem}.html"
        write_whole(page, lambda draft: draft.write_text(render(outcome), encoding="utf-8"))
        draw(outcome, folder / f"{given.scenario.stem}.png")
    except InputError as error:
        print(error, file=sys.stderr)
        return 2
    except NoPathError as error:
        print(error, file=sys.stderr)
        return 3
    if outcome.flown:
        print(f"Planned for the failure: {outcome.flown.summary}")
    if outcome.healthy_flight:
        print(f"Planned for the aircraft in order: {outcome.healthy_flight.summary}")
    for note in outcome.notes:
        print(note)
    print(page)
    return 0


if __name__ == "__main__":
    sys.exit(main())
