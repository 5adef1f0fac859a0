"""The paper's two cases and a landing, each with a figure and what the exact envelope says of the paper's words.

python examples/path_planner/cases.py [--output build/path_planner_cases]

Around or over a ridge: a climbing turn against a level one. The same height steeply or shallowly, at two speeds. The
ground in reach with both engines out. `cases.md` tells the numbers, with the advice of `gtm-fmu advise` beside them.
"""

import argparse
import sys
from dataclasses import replace
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from examples.path_planner.planner import NoPathError, Plan, exact_fmus, footprint, plan, read_scenario  # noqa: E402
from examples.path_planner.planner.climbs import Climb, climbs  # noqa: E402
from examples.path_planner.planner.figures import climb_case, footprint_map, turn_case  # noqa: E402
from examples.path_planner.planner.planning import safest_speed  # noqa: E402
from examples.path_planner.planner.scenario import Scenario  # noqa: E402
from gtm_fmu import ControlLimits, envelope_slopes  # noqa: E402
from gtm_fmu.errors import InputError  # noqa: E402
from gtm_fmu.files import writable_folder, write_whole  # noqa: E402
from gtm_study.files import save_figure  # noqa: E402
from gtm_study.paper.advice import advice, sentences  # noqa: E402
from gtm_study.style import figure_style  # noqa: E402

SCENARIOS = Path(__file__).with_name("scenarios")
CLIMB_FT, SLOW_KT = 2000.0, 90.0


def paper_cases(folder: Path) -> str:
    """Figures in a folder, and the text.

    Raises:
        InputError: an FMU that cannot be built.
        NoPathError: no path, which these scenarios have.
    """
    ridge, landing = (read_scenario(SCENARIOS / f"{name}.toml") for name in ("ridge", "engines_out"))
    source = exact_fmus(folder, ridge)
    try:
        safe = plan(ridge, source, alternatives=False)
        fast = plan(replace(ridge, cost=replace(ridge.cost, of="time")), source, alternatives=False)
        speed = safest_speed(ridge, source)
        cases = {tas: climbs(ridge, source, CLIMB_FT, tas) for tas in (speed, SLOW_KT)}
    finally:
        source.close()
    source = exact_fmus(folder, landing)
    try:
        reach, glide = footprint(landing, source), plan(landing, source)
    finally:
        source.close()
    with figure_style():
        save_figure(turn_case(ridge, [safe, fast]), folder / "turn.png")
        save_figure(climb_case(cases, CLIMB_FT), folder / "climb.png")
        save_figure(footprint_map(landing, reach, glide), folder / "footprint.png")
    near = ", ".join(f"{each.runway.name} {each.excess_ft:+.0f} ft" for each in reach.runways)
    return "\n".join(
        [
            *_turns_in_words(ridge, safe, fast),
            "",
            *_climbs_in_words(cases),
            "",
            "## With both engines out",
            "",
            f"At {reach.tas_kt:g} kn the glide is at {reach.gamma_deg:.2f} deg; turns that lose least height for their "
            f"angle are at {reach.turns_deg_s[0]:g} and {reach.turns_deg_s[1]:g} deg/s. Height to spare: {near}. The "
            f"path ({glide.name}) takes {glide.measures.time_s:.0f} s.",
            "",
            "![Ground in reach](footprint.png)",
            "",
        ]
    )


def _turns_in_words(scenario: Scenario, safe: Plan, fast: Plan) -> list[str]:
    lines = [
        "## A climbing turn or a level one",
        "",
        "| least in | s | km | margin, kn | after the second failure, kn | steepest, deg | nearest bank limit, deg |",
        "|---|---|---|---|---|---|---|",
    ]
    for each in (safe, fast):
        m = each.measures
        left = "none" if m.second_failure_kt is None else f"{m.second_failure_kt:.1f}"
        steepest = max(segment.gamma_deg for segment in each.segments)
        bank = min(min(segment.margins["bank_deg"]) for segment in each.segments)
        lines.append(
            f"| {each.name} | {m.time_s:.0f} | {m.distance_m / 1000:.1f} | {m.margin_kt:.1f} | {left} | {steepest:g} | "
            f"{bank:.1f} |"
        )
    limits = tuple(float(scenario.failure[f"limits.rudder.{end}"]) for end in ("lower", "upper"))
    advised = advice(envelope_slopes(scenario.start.altitude_ft, 0.0, ControlLimits(rudder_deg=limits)))
    return [
        *lines,
        "",
        "The paper's words hold: the level way is longer, and a second failure of the rudder is survived on it. They "
        "say nothing of the bank: a turn to the side that the jam resists comes nearer to its limit than the climb.",
        "",
        "![Around or over the ridge](turn.png)",
        "",
        "The advice at the start, of slopes and sensitivity indices:",
        "",
        *(f"- {sentence}" for sentence in sentences(advised)),
    ]


def _climbs_in_words(cases: dict[float, list[Climb]]) -> list[str]:
    lines = [
        "## Steeply or shallowly",
        "",
        f"A straight climb over {CLIMB_FT:.0f} ft. Short: what is missing to the margin that is wanted after the "
        "second failure, over the whole climb.",
        "",
        "| kn | deg | s | margin, kn | after the second failure, kn | short, kn min |",
        "|---|---|---|---|---|---|",
    ]
    for tas_kt, found in cases.items():
        for climb in (found[0], found[len(found) // 2], found[-1]):
            left = "none" if climb.after_kt is None else f"{climb.after_kt:.1f}"
            lines.append(
                f"| {tas_kt:g} | {climb.gamma_deg:g} | {climb.seconds:.0f} | {climb.margin_kt:.1f} | {left} | "
                f"{climb.short_kt_s / 60:.0f} |"
            )
    return [
        *lines,
        "",
        "The paper says that the shallow climb is safer, because V_max falls more with the angle than with the "
        "altitude. At the faster speed, which V_max ends, that is so at every moment; but the steep climb is over "
        "sooner, and over the whole of it about as much is short. At the slower speed V_min is nearer: it falls with "
        "the angle and rises with the altitude, so there the steep climb is safer at nearly every angle, and by far "
        "over the whole. The paper's words are about V_max alone.",
        "",
        "![Climbs](climb.png)",
    ]


def main() -> int:
    """Compute, draw and tell; 2 for what cannot be built, 3 where there is no path."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--output", type=Path, default=Path("build/path_planner_cases"), help="folder of all files")
    arguments = parser.parse_args()
    try:
        folder = writable_folder(arguments.output)
        text = paper_cases(folder)
    except InputError as error:
        print(error, file=sys.stderr)
        return 2
    except NoPathError as error:
        print(error, file=sys.stderr)
        return 3
    write_whole(folder / "cases.md", lambda draft: draft.write_text(text, encoding="utf-8"))
    print(folder / "cases.md")
    return 0


if __name__ == "__main__":
    sys.exit(main())
