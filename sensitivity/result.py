"""What all results share: tables for pandas and xarray, JSON, and a figure."""

import json
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from .redraw_ratios import Estimate

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr
    from matplotlib.figure import Figure

NUMBERS = ("value", "lower", "upper", "standard_error")


class Result:
    """A result with estimates (rows, outputs) of several kinds; rows are inputs, groups or subsets.

    `kinds` names the attributes that hold the estimates.
    """

    kinds: tuple[str, ...]
    input_names: tuple[str, ...]
    output_names: tuple[str, ...]

    @property
    def row_names(self) -> tuple[str, ...]:
        """Name of each row: the inputs, where a result says nothing else."""
        return self.input_names

    def to_dict(self) -> dict[str, Any]:
        """Plain dictionaries and numbers, ready for JSON."""
        raise NotImplementedError

    @property
    def estimates(self) -> Mapping[str, Estimate]:
        """The estimates by kind."""
        return {kind: getattr(self, kind) for kind in self.kinds}

    def by_output(self) -> dict[str, dict[str, Any]]:
        """The estimates as plain numbers: output, row, kind."""
        return {
            output: {
                row: {kind: estimate.to_dict(i, j) for kind, estimate in self.estimates.items()}
                for i, row in enumerate(self.row_names)
            }
            for j, output in enumerate(self.output_names)
        }

    @property
    def half_width(self) -> float:
        """Half of the widest interval of all estimates."""
        return max(float((estimate.upper - estimate.lower).max()) / 2.0 for estimate in self.estimates.values())

    def to_json(self, indent: int | None = 1) -> str:
        """`to_dict` as text."""
        return json.dumps(self.to_dict(), indent=indent, allow_nan=False)

    def to_df(self) -> "pd.DataFrame":
        """One line for each output, row and kind (needs pandas)."""
        import pandas as pd

        return pd.DataFrame(
            [
                {"output": output, "input": row, "kind": kind}
                | {number: float(getattr(estimate, number)[i, j]) for number in NUMBERS}
                for j, output in enumerate(self.output_names)
                for i, row in enumerate(self.row_names)
                for kind, estimate in self.estimates.items()
            ]
        )

    def to_xarray(self) -> "xr.Dataset":
        """Variables over (input, output, number) for each kind (needs xarray)."""
        import numpy as np
        import xarray as xr

        return xr.Dataset(
            {
                kind: (
                    ("input", "output", "number"),
                    np.stack([getattr(estimate, number) for number in NUMBERS], axis=-1),
                )
                for kind, estimate in self.estimates.items()
            },
            coords={"input": list(self.row_names), "output": list(self.output_names), "number": list(NUMBERS)},
        )

    def plot(self, **options: Any) -> "Figure":
        """Bars with intervals (needs matplotlib); options as `plots.plot_bars`."""
        from .plots import plot_bars

        return plot_bars(self, **options)
