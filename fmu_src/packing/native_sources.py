"""C sources of a native FMU: wrapper, model, core, the table of variables, and the prefix of all names."""

import posixpath
import re
from collections.abc import Sequence
from functools import cache
from importlib.resources import files
from pathlib import Path

import numpy as np

from fmu_src.description.model_description import ModelDescription, Variable
from gtm_fmu.errors import InputError

NATIVE = Path(__file__).parents[1] / "native"
CORE = Path(str(files("gtm_fmu.core")))
HEADERS = {
    2: ("fmi2TypesPlatform.h", "fmi2FunctionTypes.h", "fmi2Functions.h"),
    3: ("fmi3PlatformTypes.h", "fmi3FunctionTypes.h", "fmi3Functions.h"),
}
"""Headers of the standards, which FMPy carries under their own licence."""

_ARRAYS = {"STATES": "STATE", "DERIVATIVES": "DERIVATIVE", "INPUTS": "INPUT", "OUTPUTS": "OUTPUT"}


def standard_headers(fmi: int) -> dict[str, bytes]:
    """Headers of FMI 2.0 or 3.0 by their names."""
    folder = files("fmpy").joinpath("c-code")
    return {name: folder.joinpath(name).read_bytes() for name in HEADERS[fmi]}


def header_licence() -> bytes:
    """Licence of the headers: their own first comment."""
    text = standard_headers(3)["fmi3Functions.h"].decode()
    return (text.split("/*", 1)[1].split("*/", 1)[0].strip() + "\n").encode()


def source_files(native: Sequence[str], core: Sequence[str], fmi: int) -> dict[str, bytes]:
    """The sources but for the table of variables, by their paths; with files of the core come all of its headers.

    Args:
        native: file names in `NATIVE`, ``fmi2.c`` or ``fmi3.c`` aside.
        core: C files in the core's folder.

    Raises:
        InputError: the core's generated C is missing.
    """
    sources = core_files(core) if core else {}
    return sources | {name: (NATIVE / name).read_bytes() for name in (*native, f"fmi{fmi}.c")}


def core_files(core: Sequence[str]) -> dict[str, bytes]:
    """C files of the core, and all of its headers.

    Raises:
        InputError: the core's generated C is missing.
    """
    headers = sorted(path.relative_to(CORE).as_posix() for path in CORE.rglob("*.h"))
    generated = {f"generated/{name}": text.encode() for name, text in _tables().items()}
    try:
        return {name: generated.get(name) or (CORE / name).read_bytes() for name in (*headers, *core)}
    except FileNotFoundError as error:
        raise InputError(f"There is no '{error.filename}': install the package first, with `pip install .`.") from error


@cache
def _tables() -> dict[str, str]:
    from gtm_fmu.core.generate import table_sources

    return table_sources()


PREFIX = "prefix.h"
_DEFINITION = re.compile(r"^(?!(?:static|extern|typedef)\b)(?:\w+[ *]+)+(\w+) *[(\[=]", re.MULTILINE)
"""A function or array of C at the margin, where it is no type's; the group is its name."""
_COMMENT = re.compile(r"/\*.*?\*/", re.DOTALL)
_OF_CASADI = re.compile(r"^#define (\w+) CASADI_PREFIX\((\w+)\)", re.MULTILINE)


def with_prefix(sources: dict[str, bytes], name: str, fmi: int) -> dict[str, bytes]:
    """Sources that share no external name with those of another FMU, so that one program can hold both.

    Each file includes prefix.h first. It asks for the prefix of the functions of FMI as the standard says (FMI 2.0.5,
    2.1.1; FMI 3.0, 2.6) and renames all else that a linker would see.

    Args:
        name: model identifier.
    """
    found = sorted({given for path, text in sources.items() if path.endswith(".c") for given in _defined(path, text)})
    prefix = f"FMI{fmi}_FUNCTION_PREFIX"
    header = (
        "/* Written when the FMU is built. Included first by every file: no name is shared with another FMU of the\n"
        f"   same program. A shared library is compiled with FMI{fmi}_OVERRIDE_FUNCTION_PREFIX. */\n"
        "#ifndef PREFIX_H\n#define PREFIX_H\n\n"
        f"#if !defined(FMI{fmi}_OVERRIDE_FUNCTION_PREFIX) && !defined({prefix})\n#define {prefix} {name}_\n#endif\n\n"
        + "".join(f"#define {given} {name}_{given}\n" for given in found)
        + "\n#endif\n"
    )
    changed = {
        path: f'#include "{posixpath.relpath(PREFIX, posixpath.dirname(path) or ".")}"\n'.encode() + text
        for path, text in sources.items()
        if path.endswith(".c")
    }
    return sources | changed | {PREFIX: header.encode()}


def _defined(path: str, text: bytes) -> set[str]:
    """External names that a C file defines, those of FMI aside, which its headers rename."""
    code = _COMMENT.sub("", text.decode())
    stem = posixpath.splitext(posixpath.basename(path))[0]
    by_macro = {macro: f"{stem}_{own}" for macro, own in _OF_CASADI.findall(code)}
    return {by_macro.get(name, name) for name in _DEFINITION.findall(code) if not name.startswith("fmi")}


def kind(variable: Variable, states: set[str]) -> str:
    """What a variable is to the wrappers: one of ``enum Kind`` in model.h."""
    if variable.causality != "output":
        return {"input": "INPUT", "parameter": "PARAMETER", "independent": "TIME"}[variable.causality]
    return "DERIVATIVE" if variable.derivative_of else "STATE" if variable.name in states else "OUTPUT"


def variable_table(model: ModelDescription, faults: Sequence[str], token: str) -> dict[str, bytes]:
    """variables.h and variables.c of a model.

    Args:
        faults: sentences by fault, the first one being empty.
    """
    variables = model.variables
    states = {variable.derivative_of for variable in variables if variable.derivative_of}
    kinds = [kind(variable, {name for name in states if name}) for variable in variables]
    counts = {"N_VARIABLES": len(variables), "N_FAULTS": len(faults)}
    for array, name in _ARRAYS.items():
        places = [place for place, found in enumerate(kinds) if found == name]
        if name != "INPUT" and places != list(range(min(places, default=0), min(places, default=0) + len(places))):
            raise ValueError(f"The variables of kind {name} do not follow each other.")
        counts |= {array: min(places, default=0), f"N_{array}": len(places)}
    inputs = [str(place) for place, found in enumerate(kinds) if found == "INPUT"]
    counts |= {"TIME_REFERENCE": kinds.index("TIME"), "N_MEMORY": model.implementation.memory}
    deferred = [place for place, variable in enumerate(variables) if variable.deferred]
    if deferred != list(range(min(deferred, default=0), min(deferred, default=0) + len(deferred))):
        raise ValueError("The deferred outputs do not follow each other.")
    counts |= {"DEFERRED": min(deferred, default=0), "N_DEFERRED": len(deferred)}
    counts["HAS_STEP_EVENTS"] = int(model.has_step_events)
    counts["HAS_MODEL_EXCHANGE"] = int(model.implementation.has_model_exchange)
    references = {
        variable.name.upper().replace(".", "_"): place
        for place, (variable, found) in enumerate(zip(variables, kinds, strict=True))
        if found in ("INPUT", "OUTPUT", "PARAMETER") and model.origin is None
    }
    lines = [f"    {name} = {value}" for name, value in (counts | references).items()]
    constants = [(f"const double model_{name}", np.atleast_1d(value)) for name, value in model.constants.items()]
    declared = "".join(f"extern {name}[{len(values)}];\n" for name, values in constants)
    header = (
        "/* Written from the model description: value references, groups of them, and how many there are. */\n"
        "#ifndef VARIABLES_H\n#define VARIABLES_H\n\n"
        f'#define MODEL_TOKEN "{token}"\n\nenum {{\n' + ",\n".join(lines) + f"\n}};\n\n{declared}\n#endif\n"
    )
    rows = ",\n".join(_row(variable, found, model, counts) for variable, found in zip(variables, kinds, strict=True))
    sentences = ",\n".join(f"    {_text(sentence)}" for sentence in faults)
    table = (
        '#include <math.h>\n\n#include "model.h"\n\n'
        f"const Variable model_variables[N_VARIABLES] = {{\n{rows}}};\n\n"
        f"const int model_inputs[] = {{{', '.join(inputs or ['0'])}}};\n\n"
        f"const char *const model_faults[N_FAULTS] = {{\n{sentences}}};\n"
        + "".join(f"\n{name}[] = {{{', '.join(map(_number, values))}}};\n" for name, values in constants)
    )
    return {"variables.h": header.encode(), "variables.c": table.encode()}


def _row(variable: Variable, found: str, model: ModelDescription, counts: dict[str, int]) -> str:
    """One entry of model_variables."""
    limits = model.limits.get(variable.name)
    names = [other.name for other in model.variables]
    lower = -1 if limits is None else names.index(limits[0])
    if limits is not None and names.index(limits[1]) != lower + 1:
        raise ValueError(f"The limits of {variable.name} do not follow each other.")
    numbers = (
        _number(variable.start, "0"),
        _number(variable.minimum, "-INFINITY"),
        _number(variable.maximum, "INFINITY"),
        _number(variable.nominal, "1"),
        _number(variable.scale, "1"),
    )
    started = -1 if variable.starts is None else names.index(variable.starts)
    whole = (str(int(number)) for number in (variable.bounded, lower, started))
    typed = "BOOLEAN" if variable.boolean else "ENUMERATION" if variable.items else "REAL"
    entries = (_text(variable.name), _text(variable.unit), found, typed, *whole, *numbers)
    return f"    {{{', '.join(entries)}}}"


def _number(value: float | None, default: str = "") -> str:
    return default if value is None else repr(float(value))


def _text(value: str) -> str:
    """A string literal; question marks are escaped too, since two of them may begin a trigraph of C99."""
    return '"' + re.sub(r'[\\"?]', r"\\\g<0>", value) + '"'
