"""`gtm-fmu sensitivity`: which inputs matter, for the aircraft, a model of one's own, an FMU or a table of runs."""

import json
import shutil
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import comb
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer
from rich.console import Console
from rich.table import Table

from gtm_fmu.errors import InputError
from gtm_fmu.files import check_kept, check_writable
from gtm_study.commands.options import Json, Pair, pair
from gtm_study.commands.sensitivity_inputs import Laws, described_inputs, words
from gtm_study.files import save_figure, write_text
from gtm_study.progress import stages
from gtm_study.style import figure_style

if TYPE_CHECKING:
    from gtm_study.commands.evaluated_model import Model
    from sensitivity import Distribution
    from sensitivity.result import Result

Method = Literal["variance", "interactions", "shapley", "full-independent", "effects", "given-data", "pawn"]
OF_TABLES = ("given-data", "pawn")
SAMPLES = {"variance": 2**13, "interactions": 2**13, "shapley": 2**11, "full-independent": 2**11, "effects": 64}
SAMPLES |= {"given-data": 2**12, "pawn": 2**12}
SLOWER_BY = 32
"""So many times fewer samples where a case takes milliseconds."""


@dataclass(frozen=True)
class Asked:
    """How the indices are estimated."""

    method: Method
    samples: int
    sampling: Any
    replications: int
    seed: int
    confidence: float
    order: int
    groups: tuple[tuple[str, ...], ...]
    until: float | None


def sensitivity(
    model: Annotated[
        str, typer.Option(metavar="NAME|FILE", help="thrust-map, exact, network; MODEL.json of `train`; an FMU.")
    ] = "thrust-map",
    distribution: Annotated[
        Path | None, typer.Option(help="What the inputs vary over: .toml or .json, see docs/sensitivity.md.")
    ] = None,
    inputs: Annotated[
        list[str] | None,
        typer.Option(
            "--input",
            metavar="NAME=LAW:NUMBERS",
            help="In its place, for each input: x=uniform:0,1 (bounds), x=norm:5,2 or any law of scipy.stats.",
        ),
    ] = None,
    altitude_ft: Annotated[Pair | None, pair("Altitude in ft, uniform between these; default 0 30000.")] = None,
    gamma_deg: Annotated[Pair | None, pair("Flight-path angle in deg, uniform between these; default -5 5.")] = None,
    rudder_deg: Annotated[
        Pair | None, pair("The rudder's limits in deg, uniform in order between these; default -30 30.")
    ] = None,
    jam_share: Annotated[float | None, typer.Option(help="Share of jams among the failures; default 0.")] = None,
    infeasible: Annotated[
        Literal["condition", "output"] | None,
        typer.Option(
            help="Cases without an envelope, or without outputs: condition: leave them out of the distribution; "
            "output: ask what decides whether there is one. Default: condition for the aircraft, else refused."
        ),
    ] = None,
    outputs: Annotated[
        str | None, typer.Option(metavar="NAMES", help="Outputs of the model or columns of the table; default all.")
    ] = None,
    stop_time_s: Annotated[
        float | None, typer.Option(help="Simulate an FMU until then and take its last outputs; default: its first.")
    ] = None,
    step_s: Annotated[float, typer.Option(help="Communication step of that simulation.")] = 0.01,
    data: Annotated[Path | None, typer.Option(help="A table of runs in the place of a model; needs --columns.")] = None,
    columns: Annotated[str | None, typer.Option(metavar="NAMES", help="Columns of the table that are inputs.")] = None,
    method: Annotated[
        Method, typer.Option(help="variance: first and total indices, whatever the inputs' dependence.")
    ] = "variance",
    samples: Annotated[int | None, typer.Option(help="Base rows N, or repetitions of effects.")] = None,
    sampling: Annotated[Literal["sobol", "latin", "random"], typer.Option(help="How points are drawn.")] = "sobol",
    replications: Annotated[int, typer.Option(help="Independent sequences that the intervals come from.")] = 8,
    groups: Annotated[
        list[str] | None, typer.Option("--group", metavar="NAMES", help="Inputs with an index of their own together.")
    ] = None,
    order: Annotated[int | None, typer.Option(help="Of interactions: 2 (default), up to all inputs.")] = None,
    until: Annotated[
        float | None, typer.Option(help="Double N until no interval of the indices reaches further, as 0.01.")
    ] = None,
    confidence: Annotated[float, typer.Option(help="Of the intervals.")] = 0.95,
    seed: Annotated[int, typer.Option(min=0, help="Start of all random numbers.")] = 0,
    output: Annotated[
        Path | None, typer.Option(help="Write the result to this .json or .csv; a run that was stopped goes on.")
    ] = None,
    plot: Annotated[Path | None, typer.Option(help="Draw it: .png.")] = None,
    as_json: Json = False,
) -> None:
    """Which inputs matter, also where they depend on each other.

    Without options: V_min and V_max of a failed rudder over the paper's ranges, by the thrust map, given that there is
    an envelope. Methods: variance (first, total), interactions (independent inputs), shapley, full-independent, effects
    (elementary effects), and of a table or a random sample given-data (first) and pawn (moment-free).
    """
    _check_files(output, plot, data, distribution)
    chosen = tuple(words(spelling) for spelling in groups or [])
    ranges = {"altitude_ft": altitude_ft, "gamma_deg": gamma_deg, "rudder_deg": rudder_deg}
    wanted = words(outputs) if outputs else ()
    if order is not None and method != "interactions":
        raise InputError(f"--order is for the method interactions, not for {method}: leave it out.")
    highest = 2 if order is None else order
    asked = Asked(method, samples or 0, sampling, replications, seed, confidence, highest, chosen, until)
    _check_asked(asked, samples)
    kept = output.with_name(f"{output.name}.unfinished") if output and data is None else None
    with stages(Console(stderr=True, quiet=as_json and not sys.stderr.isatty())) as stage:
        try:
            if data is not None:
                beside = [distribution, *(inputs or []), *ranges.values(), jam_share, infeasible, stop_time_s, samples]
                if any(item is not None for item in beside) or columns is None or not wanted:
                    raise InputError("A table of runs is read by --data, --columns and --outputs; no distribution.")
                result, facts = _of_table(data, words(columns), wanted, asked)
            else:
                if columns is not None:
                    raise InputError("--columns are of a table of runs: give --data too, or leave it out.")
                laws = described_inputs(model, distribution, inputs or [], ranges, jam_share)
                result, facts = _of_model(model, laws, wanted, (stop_time_s, step_s), infeasible, asked, kept, stage)
        except ValueError as error:
            raise InputError(str(error)) from None
    _finish(result, facts, output, plot, as_json)
    if kept:
        shutil.rmtree(kept, ignore_errors=True)


def _check_files(output: Path | None, plot: Path | None, *read: Path | None) -> None:
    for path, endings in ((output, (".json", ".csv")), (plot, (".png",))):
        if path is None:
            continue
        if path.suffix not in endings:
            raise InputError(f"'{path}' cannot be written: give a name that ends in {' or '.join(endings)}.")
        check_kept(path, *(source for source in read if source is not None))
        check_writable(path)


def _check_asked(asked: Asked, samples: int | None) -> None:
    if samples is not None and not 1 <= samples <= 2**26:
        raise InputError(f"--samples was given as {samples}: give 1 to {2**26}.")
    if not 1 <= asked.replications <= 1024:
        raise InputError(f"--replications was given as {asked.replications}: give 1 to 1024.")
    if not 0.0 < asked.confidence < 1.0:
        raise InputError(f"--confidence was given as {asked.confidence:g}: give a number between 0 and 1, as 0.95.")
    if asked.until is not None and asked.method != "variance":
        raise InputError(f"--until is for the method variance, not for {asked.method}: leave it out.")
    if asked.groups and asked.method != "variance":
        raise InputError(f"--group is for the method variance, not for {asked.method}: leave it out.")


def _of_table(path: Path, columns: tuple[str, ...], outputs: tuple[str, ...], asked: Asked) -> tuple["Result", dict]:
    from sensitivity import given_data_indices, pawn_indices
    from surrogate.training.samples import read_samples

    if asked.method not in OF_TABLES:
        raise InputError(f"A table has no design, which {asked.method} needs: choose the method given-data or pawn.")
    samples = read_samples(path, columns, outputs)
    names = [[variable.name for variable in group] for group in (samples.inputs, samples.outputs)]
    measure: Callable[..., Result] = given_data_indices if asked.method == "given-data" else pawn_indices
    result = measure(
        samples.X, samples.Y, input_names=names[0], output_names=names[1], confidence=asked.confidence, seed=asked.seed
    )
    facts = {"data": str(path), "rows": len(samples.X), "rows_left_out": samples.left_out}
    return result, facts | {"result": result.to_dict()}


def _of_model(
    name: str,
    laws: Laws | None,
    outputs: tuple[str, ...],
    simulated: tuple[float | None, float],
    infeasible: str | None,
    asked: Asked,
    kept: Path | None,
    stage: Any,
) -> tuple["Result", dict]:
    """The result, and facts about the run; `kept`: a folder for the outputs of an unfinished run."""
    from gtm_study.commands.evaluated_model import kept_on_disk, remembered
    from gtm_study.commands.sensitivity_models import AIRCRAFT, opened
    from sensitivity import conditioned

    with opened(name, laws[0].names if laws else (), outputs, *simulated) as model:
        whole, groups = laws or (model.ranges, ())
        if whole is None:
            raise InputError(f"{model.name} does not tell what its inputs vary over: give --distribution or --input.")
        model = model.over(whole)
        infeasible = infeasible or ("condition" if name in AIRCRAFT else None)
        together = [block for block in whole.dependent if len(block) < len(whole.names)]
        groups = tuple(dict.fromkeys((*together, *groups, *asked.groups)))
        rows = asked.samples or SAMPLES[asked.method] // (
            SLOWER_BY if model.is_slow and asked.method != "effects" else 1
        )
        distribution = whole
        with stage(f"{asked.method.capitalize()} by {model.name}") as advance:
            model = model.telling(_counter(_evaluations(asked, rows, len(whole.names), len(groups)), advance))
            model = remembered(kept_on_disk(model, kept) if kept else model)
            if infeasible == "output":
                model = model.whether()
            elif infeasible is None:
                model = model.everywhere()
            else:
                met = model.whether()
                distribution = conditioned(whole, lambda points: met.evaluate(points)[:, 0] > 0.5)
            result = _estimate(model, distribution, groups, asked, rows)
            numbers = result.to_dict()  # where the model is open: it may ask whether points meet the condition
        facts: dict[str, Any] = {"model": name, "infeasible": infeasible, "method": asked.method}
        facts["distribution"] = repr(whole)
        if infeasible == "condition":
            (condition,) = distribution.blocks
            facts["share_with_values"] = getattr(condition, "acceptance", None)
    return result, facts | {"result": numbers}


def _evaluations(asked: Asked, n: int, m: int, groups: int) -> int:
    """About how many points a method asks for, with m inputs and n rows."""
    blocks = {"variance": 2 * (m + groups) + 2, "interactions": comb(m, asked.order) + m + 2, "shapley": 2 ** min(m, 8)}
    return n * (blocks | {"full-independent": 6 * m + 2, "effects": m + 1}).get(asked.method, 1)


def _counter(total: int, advance: Callable[[int, int], None]) -> Callable[[int], None]:
    done = 0

    def count(points: int) -> None:
        nonlocal done
        done += points
        advance(done, max(total, done))

    return count


def _estimate(
    model: "Model", distribution: "Distribution", groups: Sequence[tuple[str, ...]], asked: Asked, n: int
) -> "Result":
    import sensitivity as package
    from sensitivity.design import unit_numbers

    replicates = 1 if asked.sampling == "random" else asked.replications
    drawn: dict[str, Any] = {"sampling": asked.sampling, "replicates": replicates, "seed": asked.seed}
    confidence: dict[str, Any] = {"confidence": asked.confidence}
    bootstrap = confidence | {"seed": asked.seed}
    named: dict[str, Any] = {"output_names": model.outputs}
    match asked.method:
        case "variance":
            drawn["groups"] = groups
            if asked.until is not None:
                return package.variance_indices_until(
                    model.evaluate, distribution, asked.until, least=n, **named, **confidence, **drawn
                )
            design = package.variance_design(distribution, n, **drawn)
            return package.variance_indices(design.evaluate(model.evaluate, **named), **bootstrap)
        case "interactions":
            design = package.interaction_design(distribution, n, asked.order, **drawn)
            return package.interactions(design.evaluate(model.evaluate, **named), **bootstrap)
        case "shapley":
            return package.shapley_design(distribution, n, **drawn).evaluate(model.evaluate, **named, **bootstrap)
        case "full-independent":
            return package.full_independent_indices(distribution, model.evaluate, n, **named, **confidence, **drawn)
        case "effects":
            effects = package.effects_design(distribution, n, seed=asked.seed)
            return effects.evaluate(model.evaluate, **named, **bootstrap)
    points = distribution.sample(unit_numbers(n, len(distribution.names), "random", 1, asked.seed))
    measure = package.given_data_indices if asked.method == "given-data" else package.pawn_indices
    return measure(points, model.evaluate(points), input_names=distribution.names, **named, **bootstrap)


def _finish(result: "Result", values: dict[str, Any], output: Path | None, plot: Path | None, as_json: bool) -> None:
    if output is not None:
        if output.suffix == ".json":
            write_text(json.dumps(values, indent=1, allow_nan=False) + "\n", output)
        else:
            write_text(result.to_df().to_csv(index=False), output)
    if plot is not None:
        with figure_style():
            save_figure(result.plot(), plot)
    if as_json:
        print(json.dumps(values, allow_nan=False))
        return
    for name, value in values.items():
        if value is not None and name not in ("distribution", "result"):
            print(f"{name.replace('_', ' ')}: {f'{value:.4g}' if isinstance(value, float) else value}")
    table = Table("output", "input", *result.kinds, title=f"Intervals of {getattr(result, 'confidence', 0):.0%}")
    table.title_justify = "left"
    for j, name in enumerate(result.output_names):
        for i, row in enumerate(result.row_names):
            numbers = (
                f"{e.value[i, j]:.3g} [{e.lower[i, j]:.3g}, {e.upper[i, j]:.3g}]" for e in result.estimates.values()
            )
            table.add_row(name, row, *numbers)
    Console().print(table)
