"""Results of a benchmark: one JSON file each, with the machine they were measured on."""

import json
import os
import platform
import sys
from pathlib import Path

RESULTS = Path(__file__).parent / "results"


def machine() -> str:
    """Processor, cores and Python of this machine."""
    model = platform.processor() or platform.machine()
    information = Path("/proc/cpuinfo")
    if information.exists():
        names = [line.split(":")[1].strip() for line in information.read_text().splitlines() if "model name" in line]
        model = names[0] if names else model
    return f"{model}, {os.cpu_count()} cores, Python {sys.version.split()[0]}"


def write(name: str, rows: list[dict]) -> None:
    """Print the rows and write them to results/NAME.json."""
    RESULTS.mkdir(exist_ok=True)
    for row in rows:
        beside = f"   {row['peer']}: {row['peer_value']:g}, ratio {row['ratio']:.3g}" if "peer" in row else ""
        print(f"{row['name']}: {row['value']:g} {row['unit']}{beside}")
    text = json.dumps({"machine": machine(), "rows": rows}, indent=1)
    (RESULTS / f"{name}.json").write_text(text + "\n")


def row(
    name: str, value: float, unit: str, peer: str | None = None, peer_value: float = 0.0, ratio: float = 0.0
) -> dict:
    """One measured value, beside a peer's of the same run."""
    plain = {"name": name, "value": float(f"{value:.4g}"), "unit": unit}
    if peer is None:
        return plain
    return plain | {"peer": peer, "peer_value": float(f"{peer_value:.4g}"), "ratio": float(f"{ratio:.3g}")}
