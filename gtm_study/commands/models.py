"""The commands `gtm-fmu train`, `predict` and `export`: models of the aircraft's data and of any other."""

import re
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Annotated, Any, Literal

import typer

from gtm_fmu.errors import InputError
from gtm_fmu.extras import advice
from surrogate.rudder.names import DEFAULT, MODEL_HELP, TRIM_MAP

Pair = tuple[float, float]
Method = Literal["br", "lm", "lolimot", "hilomot"]


def _layers(spelling: str) -> tuple[int, ...]:
    """Neurons of each hidden layer."""
    try:
        return tuple(int(size) for size in spelling.split(","))
    except ValueError:  # no numbers, or of more digits than Python reads
        raise InputError(f"--hidden was given as '{spelling:.40}': give numbers of neurons, as 10 or 20,20.") from None


def train(
    data: Annotated[Path, typer.Argument(help="Table: .csv, .parquet, or a .zarr data set.")],
    output: Annotated[Path, typer.Option(help="File of the model.")],
    method: Annotated[Method, typer.Option(help="Networks: br, lm. Local models: lolimot, hilomot.")] = "br",
    inputs: Annotated[
        list[str] | None,
        typer.Option(metavar="NAMES", help="Columns NAME or NAME:UNIT, with commas between, or given once for each."),
    ] = None,
    outputs: Annotated[
        list[str] | None, typer.Option(metavar="NAMES", help="Columns to be learnt, in the same way.")
    ] = None,
    hidden: Annotated[str, typer.Option(help="Neurons of a network, for each hidden layer: 10 or 20,20.")] = "10",
    splits: Annotated[int, typer.Option(min=1, help="Models, each on a random split; the best is kept.")] = 20,
    seed: Annotated[int, typer.Option(min=0, help="Start of all random numbers.")] = 0,
    device: Annotated[str, typer.Option(help="Where networks are trained: cpu, cuda.")] = "cpu",
    calibrate: Annotated[
        float | None,
        typer.Option(min=0, metavar="ROWS", help="Rows held back to make outputs safe: a share below 1, or a number."),
    ] = None,
    never_low: Annotated[
        list[str] | None, typer.Option(metavar="NAMES", help="Outputs whose safe value must not be too low.")
    ] = None,
    never_high: Annotated[
        list[str] | None, typer.Option(metavar="NAMES", help="Outputs whose safe value must not be too high.")
    ] = None,
    epsilon: Annotated[
        float | None, typer.Option(help="Probability with which a safe value may be wrong; default 0.001.")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object and nothing else.")] = False,
) -> None:
    """Train a model on a table.

    Without --inputs and --outputs the columns are those of a rudder's failure: altitude, gamma and the limits; V_min
    and V_max. A column of words is an input for each of its levels. Rows without a value are left out. Errors are
    mean squares of outputs mapped to 0 .. 1, on rows for the training, for the test of that split, and on a tenth of
    all rows that no training saw.

    With --calibrate further rows are held back. By their errors outputs get a safe value that errs to the wrong side
    with a probability of at most epsilon: V_min never too low, V_max never too high, or what --never-low and
    --never-high name. That takes 1 / epsilon rows at least.
    """
    from rich.console import Console

    from gtm_fmu.conformal import EPSILON
    from gtm_fmu.files import check_kept, check_writable
    from gtm_study.commands.printing import show
    from gtm_study.progress import stages
    from surrogate.rudder.emulator import INPUTS, SPEEDS
    from surrogate.training.model_training import Calibration, train_calibrated, train_model
    from surrogate.training.samples import read_samples

    if (inputs is None) != (outputs is None):
        raise InputError("Either --inputs or --outputs was given: give both, or none for a rudder's failure.")
    asked, learnt = inputs, outputs
    if asked is None or learnt is None:
        asked, learnt = ([f"{name}:{unit}" for name, unit in group] for group in (INPUTS, SPEEDS))
    if calibrate is None and any(given is not None for given in (never_low, never_high, epsilon)):
        raise InputError("--never-low, --never-high and --epsilon are for --calibrate: give that, or leave them out.")
    if inputs is None and never_low is None and never_high is None:
        never_low, never_high = ([name] for name, _ in SPEEDS)
    check_kept(output, data)
    check_writable(output)
    layers = _layers(hidden)
    samples = read_samples(data, asked, learnt)
    fit: Callable[..., Any] = train_model
    if calibrate is not None:
        never = _sides(never_low or (), never_high or ())
        calibration = Calibration(calibrate, never, EPSILON if epsilon is None else epsilon)
        fit = partial(train_calibrated, calibration=calibration)
    with stages(Console(stderr=True)) as stage, stage(f"Training on {len(samples.X)} rows") as advance:
        model = fit(samples, method, splits=splits, hidden=layers, seed=seed, device=device, progress=advance)
    try:
        model.save(output)
    except ValueError as error:
        raise InputError(str(error)) from None
    facts = {"model": str(output), "method": method, "rows": len(samples.X), "rows_left_out": samples.left_out}
    show(facts | model.metrics, as_json, "Trained")


def _sides(low: Sequence[str], high: Sequence[str]) -> dict[str, Any]:
    """What the safe value of each output must never be."""
    named = [
        (name.strip(), side)
        for side, group in (("low", low), ("high", high))
        for words in group
        for name in words.split(",")
        if name.strip()
    ]
    sides = dict(named)
    if len(sides) < len(named):
        raise InputError("An output was given twice to --never-low and --never-high: each is safe to one side only.")
    return sides


def load(path: Path) -> Any:
    """The model of a file.

    Raises:
        InputError: missing, damaged or foreign.
    """
    from surrogate import load_model

    try:
        return load_model(path)
    except ValueError as error:
        raise InputError(str(error)) from None


def predict(
    model_file: Annotated[Path | None, typer.Argument(metavar="MODEL", help="File of a model of your own.")] = None,
    altitude_ft: Annotated[float | None, typer.Option(help="Geometric altitude, 0 to 36089 ft.")] = None,
    gamma_deg: Annotated[float | None, typer.Option(help="Flight-path angle, in a climb positive; default 0.")] = None,
    rudder_deg: Annotated[
        Pair | None, typer.Option(metavar="LOWER UPPER", help="Equal values are a jam; default -30 30.")
    ] = None,
    aileron_deg: Annotated[Pair | None, typer.Option(metavar="LOWER UPPER", help="Limits of the aileron.")] = None,
    elevator_deg: Annotated[Pair | None, typer.Option(metavar="LOWER UPPER", help="Limits of the elevator.")] = None,
    model: Annotated[str | None, typer.Option(metavar="NAME|FILE|FOLDER", help=MODEL_HELP)] = None,
    at: Annotated[list[str] | None, typer.Option(metavar="NAME=VALUE", help="An input of MODEL; for each one.")] = None,
    data: Annotated[Path | None, typer.Option(help="Table of cases, in the place of one case.")] = None,
    output: Annotated[Path | None, typer.Option(help="Table for its outputs: .csv or .parquet.")] = None,
    epsilon: Annotated[
        float | None, typer.Option(help="Probability with which a safe speed may be wrong; default 0.001.")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object and nothing else.")] = False,
) -> None:
    """Lowest and highest speed that a failed control leaves, by its thrust map; or the outputs of a model of your own.

    One case is given by its options, for a model of your own by --at; limits of several controls are answered by the
    trim map. A whole table is given by --data and --output; its columns are the model's inputs, or altitude_ft,
    gamma_deg, rudder_lower_deg and rudder_upper_deg, or those of another control.
    """
    from gtm_fmu.files import check_kept

    if epsilon is not None and (model_file is not None or model == TRIM_MAP):
        raise InputError("--epsilon is for a thrust map; a model of your own has that of its training: leave it out.")
    given = {"rudder": rudder_deg, "aileron": aileron_deg, "elevator": elevator_deg}
    limits = {control: ends for control, ends in given.items() if ends is not None}
    condition = any(value is not None for value in (altitude_ft, gamma_deg, *limits.values()))
    if model_file is not None and (condition or model is not None):
        extra = f"Got unexpected extra argument ({model_file}) beside a flight condition"
        raise InputError(f"{extra}: give the condition alone, or the file of a model and --at.")
    if (data is None) != (output is None) or (data is not None and (at or condition)):
        raise InputError("A table is predicted into another: give --data and --output, and no single case.")
    if model_file is not None:
        if output is not None:
            check_kept(output, model_file)
        return _ask_own(load(model_file), at or [], data, output, as_json)
    if at:
        raise InputError("--at is for a model of your own: give its file, or leave --at out.")
    if altitude_ft is None and data is None:
        raise InputError("Missing option '--altitude-ft'; see `gtm-fmu predict --help`.")
    if len(limits) > 1 or model == TRIM_MAP:
        if model not in (None, TRIM_MAP):
            raise InputError(f"'{model}' is of one failed control, and several were given: leave --model out.")
        return _ask_trim_map((altitude_ft or 0.0, gamma_deg or 0.0), limits, data, output, as_json)
    control = next(iter(limits), None)
    name = model or (DEFAULT if control in (None, "rudder") else control)
    _ask_surrogate(name, (altitude_ft or 0.0, gamma_deg or 0.0), limits, data, output, epsilon, as_json)


def _ask_own(model: Any, at: list[str], data: Path | None, output: Path | None, as_json: bool) -> None:
    from gtm_study.commands.printing import show

    if data is None or output is None:
        found = {name: value.item() for name, value in _results(model, _case(model, at)).items()}
        show(found | _promises(model), as_json, "Prediction")
    else:
        rows = _predict_table(model.inputs, lambda X: _results(model, X), data, output)
        show({"output": str(output), "rows": rows}, as_json, "Predictions")


def _promises(model: Any) -> dict[str, str]:
    """What the safe values of a model promise."""
    from surrogate.models.evaluation import safe_name

    if model.safe is None:
        return {}
    told = [f"{safe_name(name)} is {model.safe.about(name)}" for name in model.safe.outputs]
    return {"promise": f"{'; '.join(told)}."}


def _ask_surrogate(
    name: str,
    condition: tuple[float, float],
    limits: Mapping[str, Pair],
    data: Path | None,
    output: Path | None,
    epsilon: float | None,
    as_json: bool,
) -> None:
    """By a surrogate of a failed control, with what is known of its errors, and what it promises."""
    from gtm_fmu.aircraft.ranges import WIDEST
    from gtm_fmu.envelopes.thrust_map import ThrustMap
    from gtm_study.commands.printing import show
    from surrogate.rudder.surrogates import load_surrogate, measured_errors, promise

    surrogate = load_surrogate(name, control=None)
    control, asked, promised = "rudder", {}, {}
    if isinstance(surrogate, ThrustMap):
        control, asked = surrogate.control, {} if epsilon is None else {"epsilon": epsilon}
        promised = {"promise": promise(surrogate, **asked)}
    elif epsilon is not None:
        raise InputError(f"--epsilon is for a thrust map, but '{name}' promises nothing: leave it out.")
    if limits.keys() - {control}:
        other = f"'{name}' is of a failed {control}, but --{next(iter(limits))}-deg was given"
        raise InputError(f"{other}: give --{control}-deg.")
    if data is None or output is None:
        ends = limits.get(control, WIDEST[f"{control}_deg"])
        facts: dict[str, Any] = surrogate.predict_one(*condition, ends, **asked)
    else:
        rows = _envelopes_of_table(partial(surrogate.predict, **asked), control, data, output)
        facts = {"output": str(output), "rows": rows}
    about = promised | {"measured": measured_errors(surrogate)}
    show({"model": name, **facts, **about}, as_json, f"Envelope by {name}")


def _ask_trim_map(
    condition: tuple[float, float], limits: Mapping[str, Pair], data: Path | None, output: Path | None, as_json: bool
) -> None:
    """By a trim map, which is solved for it in a second."""
    from gtm_fmu.aircraft.limits import ControlLimits
    from gtm_fmu.envelopes.trim_map import SURFACES, TrimMap
    from gtm_study.commands.printing import show
    from surrogate import Variable

    found = TrimMap.solve()
    if data is None or output is None:
        given = ControlLimits(**{f"{control}_deg": ends for control, ends in limits.items()})
        facts = found.predict_one(*condition, given)
    else:
        columns = [f"{control}_{end}_deg" for control in SURFACES for end in ("lower", "upper")]
        inputs = [Variable("altitude_ft", "ft"), *(Variable(name, "deg") for name in ("gamma_deg", *columns))]
        rows = _predict_table(inputs, lambda X: found.predict(X, SURFACES)._asdict(), data, output)
        facts = {"output": str(output), "rows": rows}
    show({"model": TRIM_MAP, **facts}, as_json, "Envelope by the trim map")


def _envelopes_of_table(predict: Callable[..., Any], control: str, data: Path, output: Path) -> int:
    from surrogate import Variable
    from surrogate.rudder.emulator import INPUTS

    inputs = [Variable(name.replace("rudder", control), unit) for name, unit in INPUTS]
    return _predict_table(inputs, lambda X: predict(X)._asdict(), data, output)


def _predict_table(inputs: Sequence[Any], results: Callable[[Any], dict[str, Any]], data: Path, output: Path) -> int:
    """Write the results at all rows of a table into another, beside what the table holds; how many rows."""
    from gtm_fmu.files import check_kept
    from surrogate.training.samples import inputs_of_table
    from surrogate.training.tables import check_table, read_table, with_results, write_table

    check_kept(output, data)
    check_table(output)
    X, rows = inputs_of_table(inputs, read_table(data))
    write_table(with_results(rows, results(X), data), output)
    return len(rows)


def _case(model: Any, at: list[str]) -> list[float]:
    """The inputs that --at gives."""
    from surrogate.training.samples import input_given

    names = [variable.name for variable in model.inputs]
    given: dict[str, float] = {}
    for item in at:
        values = input_given(item, names)
        if values.keys() & given.keys():
            raise InputError(f"--at gives {', '.join(values.keys() & given.keys())} twice: give each input once.")
        given |= values
    if given.keys() != set(names):
        raise InputError(f"--at gives {', '.join(given) or 'nothing'}: give one for each of {', '.join(names)}.")
    return [given[name] for name in names]


def _results(model: Any, X: Any) -> dict[str, Any]:
    """All results at the inputs X (..., d), each (...,)."""
    from surrogate.models.evaluation import IN_DOMAIN, check_result_names, safe_name, std_name

    try:
        safe = model.safe.outputs if model.safe is not None else ()
        check_result_names(model.inputs, model.outputs, safe)
        groups = [([v.name for v in model.outputs], model.predict(X))]
        if getattr(model, "has_std", False):
            groups.append(([std_name(v.name) for v in model.outputs], model.predict_std(X)))
        if safe:
            groups.append(([safe_name(name) for name in safe], model.predict_safe(X)))
    except ValueError as error:
        raise InputError(str(error)) from None
    values = {name: Y[..., k] for names, Y in groups for k, name in enumerate(names)}
    return {IN_DOMAIN: model.in_range(X)} | values


def export(
    model_file: Annotated[Path, typer.Argument(metavar="MODEL", help="File of a model.")],
    output: Annotated[Path, typer.Option(help="File to be written.")],
    fmu: Annotated[
        bool, typer.Option("--fmu", help="Native FMU of FMI 2.0: co-simulation and model exchange.")
    ] = False,
    fmu3: Annotated[bool, typer.Option("--fmu3", help="The same of FMI 3.0.")] = False,
    c: Annotated[bool, typer.Option("--c", help="C99, with slopes; needs the C library only.")] = False,
    js: Annotated[bool, typer.Option("--js", help="ES module of JavaScript, with slopes.")] = False,
    numpy: Annotated[bool, typer.Option("--numpy", help="Python functions that need NumPy only.")] = False,
    onnx: Annotated[bool, typer.Option("--onnx", help="ONNX in double precision.")] = False,
    onnx32: Annotated[bool, typer.Option("--onnx32", help="ONNX in single precision.")] = False,
    latex: Annotated[bool, typer.Option("--latex", help="Equations for amsmath.")] = False,
    text: Annotated[bool, typer.Option("--text", help="Equations as plain text.")] = False,
    json: Annotated[bool, typer.Option("--json", help="The steps of its evaluation as JSON.")] = False,
    without_std: Annotated[bool, typer.Option("--without-std", help="Leave standard deviations out.")] = False,
    all_platforms: Annotated[
        bool, typer.Option("--all-platforms", help="FMU for every platform; needs the extra 'cross'.")
    ] = False,
) -> None:
    """Write a model in another form: exactly one of the options that name one.

    An FMU and the functions of C bear the name of the file; C comes with a header beside it.
    """
    from gtm_fmu.files import check_kept, check_writable

    given = {"fmu": fmu, "fmu3": fmu3, "c": c, "js": js, "numpy": numpy, "onnx": onnx, "onnx32": onnx32}
    given |= {"latex": latex, "text": text, "json": json}
    chosen = [name for name, is_chosen in given.items() if is_chosen]
    if len(chosen) != 1:
        raise InputError(f"{len(chosen)} forms were chosen: give one of {', '.join(f'--{name}' for name in given)}.")
    if all_platforms and not (fmu or fmu3):
        raise InputError("--all-platforms is for an FMU: leave it out, or give --fmu or --fmu3.")
    check_kept(output, model_file)
    check_writable(output)
    model = load(model_file)
    if fmu or fmu3:
        from fmu_src.packing.model_fmu import build_model

        build_model(model, output, 2 if fmu else 3, all_platforms, has_std=not without_std)
    else:
        _write_form(model, chosen[0], output, has_std=not without_std)
    print(output)


def _write_form(model: Any, form: str, output: Path, *, has_std: bool) -> None:
    from gtm_study.files import write_bytes
    from surrogate.exports.closed_form import closed_form
    from surrogate.exports.forms import check_header, export_c, export_form

    closed = closed_form(model, has_std=has_std)
    if form == "c":
        if output.suffix != ".c" or not re.fullmatch(r"[A-Za-z_][A-Za-z0-9_]*", output.stem, re.ASCII):
            raise InputError(f"C cannot be called '{output.name}': choose letters, digits and _, and the ending .c.")
        contents = export_c(closed, output.stem)
        check_header(output.with_suffix(".h"))
    else:
        try:
            contents = {output.name: export_form(closed, form)}
        except ImportError as error:
            raise InputError(f"--{form} needs {error.name}: {advice(str(error.name))}.") from None
        except ValueError as error:
            raise InputError(str(error)) from None
    for name, content in contents.items():
        write_bytes(content, output.with_name(name))
