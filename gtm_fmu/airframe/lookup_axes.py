"""The axes over which the core looks its tables up: alpha and beta are shared, each deflection and rate has its own.

A piecewise linear table keeps its values, inside and outside its axis, when breakpoints are added with the values that
it has there (SPEC 1). So every table may be brought to axes that hold the breakpoints of them all. The core does that
when it is loaded (`gtm_fmu/core/gtm/unfold.c`).
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import reduce

import numpy as np

from gtm_fmu.airframe.tables import Table, load_tables

MIRRORED = {"dC6_ail": ("beta", "ail"), "dC6_rud": ("beta",), "dC6_spo": ("beta",)}
"""Tables that have mirror images (SPEC 5.2, 5.3, 10.4), and the axes which these reverse."""


@dataclass(frozen=True)
class LookupAxes:
    """Breakpoints; alpha, beta and deflections in deg, the others normalised rates (SPEC 5.5)."""

    alpha: np.ndarray
    """Those of every static and rate table, -30 to 90 deg."""
    beta: np.ndarray
    """Those of the static tables."""
    p_hat: np.ndarray
    q_hat: np.ndarray
    r_hat: np.ndarray
    omega_hat: np.ndarray
    elevator_deg: np.ndarray
    aileron_deg: np.ndarray
    rudder_deg: np.ndarray
    stabilizer_deg: np.ndarray
    spoiler_deg: np.ndarray


def lookup_axes(tables: Mapping[str, Table] | None = None) -> LookupAxes:
    """The axes of the data file's tables, or of others.

    Raises:
        ValueError: an axis that a mirror rule reverses is not symmetric about zero.
    """
    tables = load_tables() if tables is None else tables
    for name, axes in MIRRORED.items():
        for axis in axes:
            _check_symmetric(tables[name], axis)
    basic, p, q, r, w = (tables[name] for name in ("C6_bas", "dC3_p", "dC3_q", "dC3_r", "dC6_w"))
    return LookupAxes(
        alpha=reduce(np.union1d, [table.axis("alpha") for table in (basic, p, q, r, w)]),
        beta=basic.axis("beta"),
        p_hat=p.axis("phat"),
        q_hat=q.axis("qhat"),
        r_hat=r.axis("rhat"),
        omega_hat=w.axis("what"),
        elevator_deg=tables["dC3_ele"].axis("elev"),
        aileron_deg=tables["dC6_ail"].axis("ail"),
        rudder_deg=with_other_sign(tables["dC6_rud"], "rud").axis("rud"),
        stabilizer_deg=tables["dC3_ele"].axis("stab"),
        spoiler_deg=tables["dC6_spo"].axis("spo"),
    )


def with_other_sign(table: Table, axis: str) -> Table:
    """A table of negative deflections up to zero, with the positive ones of the same size, where it is zero.

    Its mirror image belongs there (SPEC 5.2).
    """
    place, line = table.axis_names.index(axis), table.line_axes.index(axis)
    added = len(table.axes[place]) - 1

    def padded(array: np.ndarray, along: int) -> np.ndarray:
        return np.pad(array, [(0, added * (k == along)) for k in range(array.ndim)])

    axes = list(table.axes)
    axes[place] = np.concatenate([axes[place], -axes[place][-2::-1]])
    return replace(
        table,
        axes=tuple(axes),
        values=padded(table.values, place),
        coefficients=padded(table.coefficients, line + 1),
        tabulated=padded(table.tabulated, line),
    )


def _check_symmetric(table: Table, axis: str) -> None:
    if not np.array_equal(table.axis(axis), -table.axis(axis)[::-1]):
        raise ValueError(f"The mirror rule of {table.name} needs an axis {axis} symmetric about zero.")
