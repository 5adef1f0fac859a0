"""C of CasADi functions, axes and tables, as the core compiles it."""

from pathlib import Path

import casadi as ca
import numpy as np

SIX, THREE = 8, 4
"""Widths to which six and three components are padded."""


def function(name: str, arguments: list, results: list) -> ca.Function:
    """A function with dense results, in which no term is computed twice."""
    return ca.Function(name, arguments, ca.cse([ca.densify(result) for result in results]))


def slope_through_tables(result: ca.SX, wrt: ca.SX, C: ca.SX, T: ca.SX, lookups: ca.SX) -> ca.SX:
    """Jacobian of a result through C (6) of the look-ups too, with slopes T; transposed, so that C sees rows."""
    dC = T @ ca.jacobian(lookups, wrt)
    along = ca.vertcat(ca.SX.eye(wrt.numel()), dC)
    arguments = ca.vertcat(wrt, C)
    return ca.horzcat(*(ca.jtimes(result, arguments, along[:, k]) for k in range(wrt.numel()))).T


def write_functions(folder: Path, name: str, functions: list[ca.Function]) -> None:
    """Write name.c and name.h: plain C99 of the functions."""
    generator = ca.CodeGenerator(f"{name}.c", {"with_header": True, "casadi_int": "int", "include_math": True})
    for each in functions:
        generator.add(each)
    generator.generate(f"{folder}/")


def axis_definition(name: str, axis: np.ndarray) -> str:
    """C of an axis: breakpoints and search cells."""
    inverse_width, cells = _cells(axis)
    return (
        f"static const double {name}_points[] = {{{', '.join(repr(float(v)) for v in axis)}}};\n"
        f"static const unsigned char {name}_cells[] = {{{', '.join(map(str, cells))}}};\n"
        f"const gtm_axis gtm_{name}_axis = "
        f"{{{len(axis)}, {len(cells)}, {inverse_width!r}, {name}_points, {name}_cells}};\n"
    )


def _cells(axis: np.ndarray) -> tuple[float, list[int]]:
    """Inverse width of uniform cells that hold at most one breakpoint each, and the interval at each cell's start."""
    width = float(np.diff(axis).min()) * (1 - 1e-9)
    starts = axis[0] + width * np.arange(int((axis[-1] - axis[0]) / width) + 1)
    intervals = np.clip(np.searchsorted(axis, starts, side="right") - 1, 0, len(axis) - 2)
    return 1 / width, intervals.tolist()


def padded_width(components: int) -> int:
    """A vector-friendly width of so many components."""
    return SIX if components > THREE else THREE


def table_definition(name: str, values: np.ndarray) -> str:
    """C of a table; its last axis, the components, padded with zeros."""
    width = padded_width(values.shape[-1])
    padded = np.pad(values, [(0, 0)] * (values.ndim - 1) + [(0, width - values.shape[-1])]).ravel()
    rows = (padded[i : i + 8] for i in range(0, padded.size, 8))
    numbers = ",\n".join(", ".join(repr(float(v)) for v in row) for row in rows)
    return f"const double gtm_{name}_table[{padded.size}] = {{\n{numbers}}};\n"
