"""The aerodynamic tables of SPEC sections 5 and 10.4-10.5, evaluated at their breakpoints.

The data file holds a table as Chebyshev coefficients over the variable in which it is a polynomial (sideslip or a
normalised rate), scaled to [-1, 1]:

    value(.., x_i, ..) = sum_k c_k(..) T_k(x_i / x_max)

and only the coefficients that are not zero, with one presence bit each. The polynomial is evaluated at the
breakpoints alone; between them every table is multilinear (SPEC 1). `gtm_fmu.airframe.refit` writes the file.
"""

import zipfile
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.polynomial import chebyshev

from gtm_fmu.airframe.names import COEFFICIENTS
from gtm_fmu.errors import InputError

DATA_FILE = Path(__file__).parent / "data" / "aerodynamics.npz"

LONGITUDINAL = ("CX", "CZ", "Cm")
LATERAL = ("CY", "Cl", "Cn")


@dataclass(frozen=True)
class Layout:
    """Shape and stored form of one table.

    Attributes:
        axes: names of the axes in the order of the database; the component axis follows last.
        components: names along the last axis.
        fitted: the axis in which the table is a polynomial; None if the values are stored as they are.
        degree: largest degree of that polynomial.
        has_tabulated_entries: some lines along the fitted axis are no polynomials and are stored as values.
        labels: what the positions of an axis without breakpoints mean.
    """

    axes: tuple[str, ...]
    components: tuple[str, ...]
    fitted: str | None = None
    degree: int = 5
    has_tabulated_entries: bool = False
    labels: Mapping[str, tuple[Any, ...]] = field(default_factory=dict)


_CASES = {"damage_case": (1, 2, 3, 4, 5, 6)}
_CASES_AND_RATES = {**_CASES, "rate": ("p", "q", "r")}

LAYOUTS: dict[str, Layout] = {
    "C6_bas": Layout(("alpha", "beta"), COEFFICIENTS, "beta"),
    "dC6_rud": Layout(("alpha", "beta", "rud"), COEFFICIENTS, "beta"),
    "dC6_ail": Layout(("alpha", "beta", "ail"), COEFFICIENTS, "beta", has_tabulated_entries=True),
    "dC3_ele": Layout(("alpha", "beta", "stab", "elev"), LONGITUDINAL, "beta"),
    "dC6_spo": Layout(("alpha", "beta", "spo"), COEFFICIENTS, "beta"),
    "dC3_lgr": Layout(("alpha", "gear"), LONGITUDINAL, labels={"gear": (0, 1)}),
    "dC3_p": Layout(("alpha", "phat"), LATERAL, "phat"),
    "dC3_q": Layout(("alpha", "qhat"), LONGITUDINAL, "qhat"),
    "dC3_r": Layout(("alpha", "rhat"), LATERAL, "rhat"),
    "dC6_w": Layout(("alpha", "what", "beta"), COEFFICIENTS, "beta"),
    "flaps": Layout(("panel",), COEFFICIENTS, labels={"panel": ("flaplob", "flaplib", "flaprib", "flaprob")}),
    # No low-order polynomials (SPEC 12): degree 12 through the 13 breakpoints is the interpolating, so exact, form.
    "dC6_damage.bas": Layout(("alpha", "beta", "damage_case"), COEFFICIENTS, "beta", degree=12, labels=_CASES),
    "dC6_damage.ddscale": Layout(("alpha", "damage_case", "rate"), COEFFICIENTS, labels=_CASES_AND_RATES),
    "dC6_damage.ddinc": Layout(("alpha", "damage_case", "rate"), COEFFICIENTS, labels=_CASES_AND_RATES),
}
"""Every table of the database but dC3_sym, which is identically zero (SPEC 5.1). Names as in the database."""


@dataclass(frozen=True)
class Table:
    """One table of the database.

    Attributes:
        name: as in the database.
        axis_names: one a lookup axis.
        axes: breakpoints in deg (alpha, beta, deflections) or of a normalised rate; labels for gear, damage case,
            rate and panel.
        components: coefficients along the last axis, body axes.
        values: shape (*[len(axis) for axis in axes], len(components)); per deg of deflection for `flaps`.
        fitted: the axis that its lines run along; None if the table is stored as values.
        coefficients: of the lines' Chebyshev polynomials, shape (degree + 1, *lines); lines follow the other axes and
            the components. Of degree 0, the values themselves, where nothing is fitted.
        tabulated: which lines are no polynomials, shape (*lines).
    """

    name: str
    axis_names: tuple[str, ...]
    axes: tuple[np.ndarray, ...]
    components: tuple[str, ...]
    values: np.ndarray
    fitted: str | None
    coefficients: np.ndarray
    tabulated: np.ndarray

    def axis(self, name: str) -> np.ndarray:
        """Breakpoints of the axis of that name."""
        return self.axes[self.axis_names.index(name)]

    @property
    def line_axes(self) -> tuple[str, ...]:
        """Names of the axes that lines follow, components aside."""
        return tuple(name for name in self.axis_names if name != self.fitted)

    @property
    def lines(self) -> np.ndarray:
        """Values line by line, shape (*lines, points of the fitted axis)."""
        if self.fitted is None:
            return self.values[..., np.newaxis]
        return np.moveaxis(self.values, self.axis_names.index(self.fitted), -1)

    def at(self, axis: str, position: float) -> "Table":
        """The table at a breakpoint or label of an axis that lines follow."""
        place, line = self.axis_names.index(axis), self.line_axes.index(axis)
        index = int(np.flatnonzero(self.axes[place] == position)[0])
        return replace(
            self,
            axis_names=self.axis_names[:place] + self.axis_names[place + 1 :],
            axes=self.axes[:place] + self.axes[place + 1 :],
            values=self.values.take(index, place),
            coefficients=self.coefficients.take(index, line + 1),
            tabulated=self.tabulated.take(index, line),
        )


def load_tables(path: Path | str | None = None) -> dict[str, Table]:
    """Every table of `LAYOUTS`, by name; without a path from the file that the package carries.

    Error against the database: below 1e-12 at every breakpoint (docs/aerodynamic-data.md).
    """
    path = DATA_FILE if path is None else Path(path)
    try:
        with np.load(path, allow_pickle=False) as members:
            return {name: _decode(name, layout, members) for name, layout in LAYOUTS.items()}
    except FileNotFoundError:
        raise InputError(
            f"There is no aerodynamic data file {path}: write one with python -m gtm_fmu.airframe.refit."
        ) from None
    except (OSError, EOFError, KeyError, ValueError, TypeError, zipfile.BadZipFile) as error:
        raise InputError(
            f"{path} is damaged or no aerodynamic data file: write one with python -m gtm_fmu.airframe.refit."
        ) from error


def _decode(name: str, layout: Layout, members: Mapping[str, np.ndarray]) -> Table:
    axes = tuple(
        np.array(layout.labels[axis]) if axis in layout.labels else members[f"{name}/{axis}"] for axis in layout.axes
    )
    shape = (*(len(axis) for axis in axes), len(layout.components))
    if layout.fitted is None:
        values = members[f"{name}/values"].reshape(shape)
        coefficients, tabulated = values[np.newaxis], np.zeros(shape, dtype=bool)
    else:
        fitted = layout.axes.index(layout.fitted)
        lines = shape[:fitted] + shape[fitted + 1 :]
        present = _unpack(members[f"{name}/present"], (layout.degree + 1, *lines))
        coefficients, tabulated = np.zeros(present.shape), np.zeros(lines, dtype=bool)
        coefficients[present] = members[f"{name}/coefficients"]
        along_line = chebyshev.chebval(axes[fitted] / np.abs(axes[fitted]).max(), coefficients)
        if layout.has_tabulated_entries:
            tabulated = _unpack(members[f"{name}/tabulated"], lines)
            along_line[tabulated] = members[f"{name}/tabulated_values"]
        values = np.ascontiguousarray(np.moveaxis(along_line, -1, fitted))
    values.setflags(write=False)
    return Table(name, layout.axes, axes, layout.components, values, layout.fitted, coefficients, tabulated)


def _unpack(bits: np.ndarray, shape: tuple[int, ...]) -> np.ndarray:
    return np.unpackbits(bits, count=int(np.prod(shape))).astype(bool).reshape(shape)
