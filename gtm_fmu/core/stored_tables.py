"""C of the aerodynamic tables in the form of the data file, in which the core carries them: `gtm/unfold.c` reads it."""

from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from gtm_fmu.airframe.configured_tables import RATES
from gtm_fmu.airframe.lookup_axes import LookupAxes, with_other_sign
from gtm_fmu.airframe.names import COEFFICIENTS
from gtm_fmu.airframe.tables import Table
from gtm_fmu.core.c_source import padded_width

LINE_COEFFICIENTS = 6
"""Of a line's polynomial, at most."""

LINE_VALUES = 1 << LINE_COEFFICIENTS
"""Form of a line that is no polynomial; else bit k tells that the k-th coefficient is not zero."""


class Stored(NamedTuple):
    """A table as the core carries it, and the axis that comes ahead of alpha in C."""

    table: Table
    block: str | None = None

    @property
    def blocks(self) -> int:
        """Number of its tables over alpha."""
        return len(self.table.axis(self.block)) if self.block else 1

    @property
    def places(self) -> np.ndarray:
        """Breakpoints along its lines; a single one where they are numbers."""
        return self.table.axis(self.table.fitted) if self.table.fitted else np.zeros(1)

    @property
    def thirds(self) -> int:
        """Number of lines of a component at an alpha."""
        others = (name for name in self.table.line_axes if name not in ("alpha", self.block))
        return int(np.prod([len(self.table.axis(name)) for name in others]))

    @property
    def entry(self) -> int:
        """Numbers at an alpha and a place."""
        return self.thirds * padded_width(len(self.table.components))

    def row_size(self, axes: LookupAxes) -> int:
        """Numbers at an alpha of the table that is looked up."""
        return self.entry * len(axes.beta if self.table.fitted == "beta" else self.places)

    def table_definition(self, name: str, axes: LookupAxes) -> str:
        """C of the table that is looked up, ``gtm_{name}_table``, to be filled in."""
        return f"double gtm_{name}_table[{self.blocks * len(axes.alpha) * self.row_size(axes)}];\n"

    def definition(self, name: str) -> str:
        """C of the constant ``gtm_{name}_stored``."""
        first = self.table.line_axes.index(self.block or "alpha")
        coefficients = np.moveaxis(np.moveaxis(self.table.coefficients, 0, -1), first, 0)
        tabulated, lines = np.moveaxis(self.table.tabulated, first, 0), np.moveaxis(self.table.lines, first, 0)
        is_present = coefficients != 0
        if coefficients.shape[-1] > LINE_COEFFICIENTS:
            raise ValueError(f"{self.table.name} has polynomials of degree {coefficients.shape[-1] - 1}.")
        forms = np.where(tabulated, LINE_VALUES, is_present @ (1 << np.arange(is_present.shape[-1])))
        numbers = [
            lines[line] if tabulated[line] else coefficients[line][is_present[line]] for line in np.ndindex(forms.shape)
        ]
        arrays = [
            _array("double", f"{name}_alphas", self.table.axis("alpha")),
            _array("double", f"{name}_places", self.places),
            _array("unsigned char", f"{name}_forms", forms.ravel()),
            _array("double", f"{name}_numbers", np.concatenate(numbers)),
        ]
        counts = (self.blocks, len(self.table.axis("alpha")), len(self.places), self.thirds, len(self.table.components))
        scale = float(np.abs(self.places).max()) or 1.0
        names = (f"{name}_{kind}" for kind in ("alphas", "places", "forms", "numbers"))
        entries = ", ".join(map(str, (*counts, self.entry // self.thirds, scale, *names)))
        return f"{''.join(arrays)}const gtm_stored_table gtm_{name}_stored = {{{entries}}};\n"


def _array(kind: str, name: str, values: np.ndarray) -> str:
    """C of a constant array, eight values a line."""
    words = [repr(value) for value in values.tolist()]
    rows = ",\n".join(", ".join(words[i : i + 8]) for i in range(0, len(words), 8))
    return f"static const {kind} {name}[] = {{\n{rows}}};\n"


def sizes(tables: Mapping[str, Table], axes: LookupAxes) -> dict[str, int]:
    """What `gtm/unfold.c` needs to know of all tables; the names of the constants lack their prefix."""
    stored = [*folded(tables).values(), *configured(tables).values()]
    return {
        "LINE_COEFFICIENTS": LINE_COEFFICIENTS,
        "LINE_VALUES": LINE_VALUES,
        "LONGEST_LINE": max(len(each.places) for each in stored),
        "LARGEST_ROW": max(each.row_size(axes) for each in stored),
    }


def folded(tables: Mapping[str, Table]) -> dict[str, Stored]:
    """The tables of the study's configuration (SPEC 9) by their names in C.

    The stabiliser is at zero; of both ailerons together, and of the rudder's positive deflections, the core adds the
    mirror images.
    """
    return {
        "basic": Stored(tables["C6_bas"]),
        "elevator": Stored(tables["dC3_ele"].at("stab", 0.0)),
        "aileron": Stored(tables["dC6_ail"]),
        "rudder": Stored(with_other_sign(tables["dC6_rud"], "rud")),
        "p": Stored(tables["dC3_p"]),
        "q": Stored(tables["dC3_q"]),
        "r": Stored(tables["dC3_r"]),
        "omega": Stored(tables["dC6_w"]),
    }


def configured(tables: Mapping[str, Table]) -> dict[str, Stored]:
    """Those that every other configuration needs besides; the right aileron's is one of `folded`."""
    increment, cy = tables["dC6_damage.ddinc"], COEFFICIENTS.index("CY")
    of_rates = replace(
        increment,  # the other components are not used (SPEC 10.5)
        axis_names=increment.axis_names[:-1],
        axes=increment.axes[:-1],
        components=tuple(RATES),
        values=increment.values[..., cy],
        coefficients=increment.coefficients[..., cy],
        tabulated=increment.tabulated[..., cy],
    )
    return {
        "right_spoiler": Stored(tables["dC6_spo"]),
        "tail": Stored(tables["dC3_ele"], block="stab"),
        "gear": Stored(tables["dC3_lgr"].at("gear", 1)),
        "damage_increment": Stored(of_rates, block="damage_case"),
    }
