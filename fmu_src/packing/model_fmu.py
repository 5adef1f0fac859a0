"""A user's own fitted model as a native FMU: its inputs and outputs under their own names and units."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

import numpy as np

from fmu_src.description.model_description import ModelDescription, Variable
from fmu_src.description.reference_results import reference_samples
from fmu_src.packing.archive import write_archive
from fmu_src.packing.native_fmus import NativeContents, NativeModel
from gtm_fmu.errors import InputError
from gtm_fmu.files import check_writable
from surrogate.exports.closed_form import ClosedForm, Model, closed_form
from surrogate.exports.forms import export_c
from surrogate.models.evaluation import IN_DOMAIN, safe_name, std_name

ALIASES = {"": "1", "-": "1", "kt": "kn"}
"""Other spellings of units that the descriptions know."""
FAULTS = ("", "The outputs are not finite.")
SAFE_USAGE = (
    "What is called safe is an output moved by a constant margin, so that it errs to the other side with a small "
    "probability only. That is promised of cases that are distributed as the rows of the calibration, each output by "
    "itself.",
)
SAMPLES = 11
"""Expected results that travel in the FMU."""


def build_model(
    model: Model, path: str | Path, fmi: int = 2, all_platforms: bool = False, has_std: bool = True
) -> Path:
    """Write the FMU of a fitted model; equal models give equal bytes.

    Args:
        model: a fitted model. Its inputs become inputs in its own units; its outputs, their standard deviations (as
            ``NAME_std``) where it has them, ``in_domain``, and safe values (as ``NAME_safe``) where it was calibrated
            become outputs.
        path: of the FMU; its stem becomes the name of the model.
        fmi: 2 or 3.
        all_platforms: binaries for all platforms by Zig, not only for this one.
        has_std: with standard deviations, where the model has them.

    Raises:
        InputError: names that an FMU cannot have, no compiler, or a file that cannot be written.
    """
    path = check_writable(path)
    if path.suffix != ".fmu" or not re.fullmatch(r"[A-Za-z_][A-Za-z0-9_]*", path.stem, re.ASCII):
        raise InputError(f"An FMU cannot be called '{path.name}': choose letters, digits and _, and the ending .fmu.")
    form = closed_form(model, has_std=has_std, has_short_factor=True)
    return write_archive(path, _contents(model, form, path.stem, fmi).members(all_platforms))


def _contents(model: Model, form: ClosedForm, name: str, fmi: int) -> NativeContents:
    native = NativeModel(
        faults=FAULTS,
        native=("form_model.c", "stateless.c"),
        written=export_c(form, "form"),
        has_partial_derivatives=True,
        defers=True,
    )
    return native.contents(_description(form, model, name), fmi, lambda _: _reference(model))


def _reference(model: Model) -> dict[str, bytes]:
    """The way from the least to the greatest values of all inputs."""
    least, greatest = model.input_ranges.T
    X = np.linspace(least, greatest, SAMPLES)
    names = ([variable.name for variable in group] for group in (model.inputs, model.outputs))
    inputs, outputs = names
    Y = model.predict(X)
    if model.safe is not None:
        outputs, Y = [*outputs, *map(safe_name, model.safe.outputs)], np.hstack([Y, model.predict_safe(X)])
    return reference_samples(inputs, X, outputs, Y)


def _description(form: ClosedForm, model: Model, name: str) -> ModelDescription:
    inputs = tuple(
        _input(v.name, v.unit, *ends) for v, ends in zip(form.inputs, form.input_ranges.tolist(), strict=True)
    )
    known = tuple(variable.name for variable in inputs)
    outputs = [_output(v.name, v.unit, "Output of the model", known) for v in form.outputs]
    deviations = [
        replace(_output(std_name(v.name), v.unit, f"Standard deviation of {v.name}", known), deferred=True)
        for v in form.outputs
        if form.std
    ]
    domain = Variable(
        name=IN_DOMAIN,
        description="Whether all inputs are inside the ranges of the training data",
        causality="output",
        variability="discrete",
        initial="calculated",
        depends_on=known,
        boolean=True,
    )
    groups = {"inputs": inputs, "outputs": tuple(outputs)}
    groups |= {"deviations": tuple(deviations)} if deviations else {}
    groups["flags"] = (domain,)
    if form.safe:
        told = zip(form.safe_outputs, form.safe.outputs, strict=True)
        groups["safe"] = tuple(_output(v.name, v.unit, f"{name}, {form.safe.about(name)}", known) for v, name in told)
    _check_names([v.name for group in groups.values() for v in group] + ["time"])
    _check_names([v.unit for v in (*inputs, *outputs)], are_unique=False)
    facts = [f"{key}: {value}" for key, value in (*model.provenance.items(), *model.metrics.items())]
    return ModelDescription(
        name=name,
        title=f"{', '.join(v.name for v in form.outputs)} by a fitted model",
        groups=groups,
        stop_time=float(SAMPLES - 1),
        step_size=1.0,
        usage=(
            "Outputs follow the inputs at once, also in Initialization Mode. Where in_domain is false an input is "
            "outside the training data, and the outputs are guesses.",
            *(SAFE_USAGE if form.safe else ()),
            "Partial derivatives of all real outputs with respect to the inputs are exact.",
        ),
        origin="\n".join(facts) or "A fitted model that does not say where it comes from.",
    )


def _input(name: str, unit: str, least: float, greatest: float) -> Variable:
    return Variable(
        name=name,
        description=f"Input of the model, {least:.6g} .. {greatest:.6g} in the training data",
        causality="input",
        unit=ALIASES.get(unit, unit),
        start=(least + greatest) / 2,
        nominal=max(abs(least), abs(greatest)),
    )


def _output(name: str, unit: str, description: str, known: tuple[str, ...]) -> Variable:
    return Variable(
        name=name,
        description=description,
        causality="output",
        initial="calculated",
        unit=ALIASES.get(unit, unit),
        depends_on=known,
    )


def _check_names(names: Iterable[str], *, are_unique: bool = True) -> None:
    seen: set[str] = set()
    for name in names:
        if not name.isprintable() or not name.strip():
            raise InputError(f"An FMU cannot have {name!r} as a name or unit: train the model with a printable one.")
        if are_unique and name in seen:
            raise InputError(f"The FMU would have two variables called '{name}': train the model with another name.")
        seen.add(name)
