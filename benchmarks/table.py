"""Results of a benchmark: one JSON file each, with the machine they were measured on.

They go to build/benchmarks. `make publish-benchmarks` makes them those that README quotes, in benchmarks/results.
"""

import json
import os
import platform
import sys
from pathlib import Path

RESULTS = Path(__file__).parents[1] / "build" / "benchmarks"


def machine() -> str:
    """Processor, cores and Python of this machine."""
    model = platform.processor() or platform.machine()
    information = Path("/proc/cpuinfo")
    if information.exists():
        names = [line.split(":")[1].strip() for line in information.read_text().splitlines() if "model name" in line]
        model = names[0] if names else model
    return f"{model}, {os.cpu_count()} cores, Python {sys.version.split()[0]}"


def write(name: str, rows: list[dict]) -> None:
    """Print the rows and write them to NAME.json."""
    for row in rows:
        beside = f"   {row['peer']}: {row['peer_value']:g}, ratio {row['ratio']:.3g}" if "peer" in row else ""
        print(f"{row['name']}: {row['value']:g} {row['unit']}{beside}")
    write_json(name, {"machine": machine(), "rows": rows})


def write_json(name: str, result: dict) -> None:
    """Write a result to NAME.json."""
    RESULTS.mkdir(parents=True, exist_ok=True)
    (RESULTS / f"{name}.json").write_text(json.dumps(result, indent=1) + "\n")


def row(
    name: str, value: float, unit: str, peer: str | None = None, peer_value: float = 0.0, ratio: float = 0.0
) -> dict:
    """One measured value, beside a peer's of the same run."""
    plain = {"name": name, "value": float(f"{value:.4g}"), "unit": unit}
    if peer is None:
        return plain
    return plain | {"peer": peer, "peer_value": float(f"{peer_value:.4g}"), "ratio": float(f"{ratio:.3g}")}
