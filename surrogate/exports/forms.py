"""Every form in which a fitted model can be written to a file."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

from gtm_fmu.errors import InputError
from surrogate.exports.c_source import HEADER_MARK, c_header, c_source
from surrogate.exports.closed_form import ClosedForm
from surrogate.exports.javascript import javascript
from surrogate.exports.numpy_source import numpy_source
from surrogate.exports.text import latex, text


def json_text(form: ClosedForm) -> str:
    """Inputs, outputs and the steps of `predict` and `std`, which `exports.program` defines, as one JSON object.

    Of a calibrated model also those of the safe values, which follow from the outputs.
    """
    document = {
        "inputs": [
            {"name": name, "unit": unit, "least": least, "greatest": greatest}
            for (name, unit), (least, greatest) in zip(form.inputs, form.input_ranges.tolist(), strict=True)
        ],
        "outputs": [{"name": name, "unit": unit} for name, unit in form.outputs],
        "predict": form.predict.to_list(),
        "std": form.std.to_list() if form.std else None,
    }
    if safe := form.safe_program:
        document |= {"safe_outputs": [{"name": name, "unit": unit} for name, unit in form.safe_outputs]}
        document |= {"safe": safe.to_list()}
    return json.dumps(document, allow_nan=False) + "\n"


def _onnx(dtype: str) -> Callable[[ClosedForm], bytes]:
    def serialized(form: ClosedForm) -> bytes:
        from surrogate.exports.onnx_model import onnx_model

        return bytes(onnx_model(form, dtype).SerializeToString(deterministic=True))

    return serialized


FORMS: dict[str, Callable[[ClosedForm], str | bytes]] = {
    "c": c_source,
    "js": javascript,
    "numpy": numpy_source,
    "onnx": _onnx("float64"),
    "onnx32": _onnx("float32"),
    "json": json_text,
    "text": text,
    "latex": latex,
}
"""Short names of the forms, and what writes them."""


def export_form(closed: ClosedForm, form: str) -> bytes:
    """The content of a file with the closed form of a model; `form` is a key of `FORMS`."""
    if form not in FORMS:
        raise ValueError(f"'{form}' is no form of an export: choose one of {', '.join(FORMS)}.")
    content = FORMS[form](closed)
    return content if isinstance(content, bytes) else content.encode()


def export_c(closed: ClosedForm, name: str) -> dict[str, bytes]:
    """C99 source and header by their file names; all public names begin with `name`, an identifier of C."""
    return {f"{name}.c": c_source(closed, name).encode(), f"{name}.h": c_header(closed, name).encode()}


def check_header(path: Path) -> None:
    """Refuse to replace a header that no export wrote, as nobody names it.

    Raises:
        InputError: there is one.
    """
    if path.exists() and not (path.is_file() and path.read_bytes().startswith(HEADER_MARK.encode())):
        raise InputError(f"{path} would be replaced by the header, but is not one of an export: choose another name.")
