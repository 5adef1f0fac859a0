"""How a command prints a result: as one JSON object, or as a table."""

import json
from typing import Any


def show(values: dict[str, Any], as_json: bool, title: str) -> None:
    """Print a result: one JSON object, or a table of its plain entries."""
    if as_json:
        print(json.dumps(values, allow_nan=False))
        return
    from rich.console import Console  # a program that asks for JSON need not wait for tables
    from rich.table import Table

    table = Table("quantity", "value", title=title, title_justify="left")
    for name, value in values.items():
        if isinstance(value, dict):
            for inner, number in value.items():
                table.add_row(f"{name}.{inner}", _plain(number))
        else:
            table.add_row(name, _plain(value))
    Console().print(table)


def _plain(value: Any) -> str:
    if isinstance(value, bool) or value is None:
        return {True: "yes", False: "no", None: "-"}[value]
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, list | tuple):
        is_matrix = any(isinstance(entry, list) for entry in value)
        return ("\n" if is_matrix else ", ").join(_plain(entry) for entry in value) or "none"
    return str(value)
