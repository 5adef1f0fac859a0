"""docs/fmus.md: its programs run, its table of importers is the tested one."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

from tests.fmu_src.importer_matrix import CASES, COLUMNS
from tests.fmu_src.test_importers import OTHERWISE

PAGE = (Path(__file__).parents[2] / "docs" / "fmus.md").read_text(encoding="utf-8")


def test_programs(built, tmp_path):
    for name in ("dynamics-native", "envelope-native"):
        path = built(name)
        (tmp_path / path.name).symlink_to(path)
    programs = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
    assert len(programs) == 3
    run = subprocess.run([sys.executable, "-c", "\n".join(programs)], cwd=tmp_path, capture_output=True, text=True)
    if "libtbb" in run.stderr:
        pytest.skip("ecospy needs libtbb12")
    assert run.returncode == 0, run.stderr
    flight, margin, shapes = run.stdout.splitlines()[-3:]
    assert flight.startswith("(10.0, ")
    assert 15 < float(margin) < 25  # m/s: 97 kn, and a V_min of about 57 kn
    assert shapes.startswith("(12, 12) (12, 4) [")


def test_table_of_importers():
    for model in CASES:
        row = (model, *(OTHERWISE.get((column, model), "yes") for column in COLUMNS))
        assert f"| {' | '.join(row)} |" in PAGE
    assert f"| | {' | '.join(COLUMNS)} |" in PAGE
