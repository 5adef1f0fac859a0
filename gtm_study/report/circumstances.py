"""What was run: versions, data, seed and machine."""

import os
import platform
from importlib.metadata import version
from pathlib import Path

import psutil

from gtm_fmu.airframe.provenance import provenance
from gtm_study.tables import Table

LIBRARIES = ("numpy", "scipy", "casadi", "matplotlib", "torch")


def circumstances(seed: int) -> Table:
    """As rows of a table."""
    known = provenance()
    memory_gib = psutil.virtual_memory().total / 2**30
    rows = [
        ("gtm-fmu", known["gtm_fmu_version"]),
        ("aerodynamic data, SHA-256", known["aerodynamic_data_sha256"]),
        ("seed", str(seed)),
        ("Python", platform.python_version()),
        ("libraries", ", ".join(f"{name} {version(name)}" for name in LIBRARIES)),
        ("machine", f"{_processor()}, {os.cpu_count()} cores, {memory_gib:.0f} GiB of memory"),
        ("system", f"{platform.system()} {platform.release()}"),
    ]
    return Table(("what", "value"), rows, "Versions, data, seed and machine")


def _processor() -> str:
    """Name of the processor, where the system tells it."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
        return next(line.split(":", 1)[1].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        return platform.machine()
