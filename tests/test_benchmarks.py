"""Benchmarks leave the published results alone."""

import json
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]
BENCHMARKS = ROOT / "benchmarks"


def test_results_go_to_the_build_folder(tmp_path):
    script = (
        "import sys; from pathlib import Path; sys.path.insert(0, sys.argv[1]); import table\n"
        "print(table.RESULTS); table.RESULTS = Path(sys.argv[2]) / 'deep'\n"
        "table.write('speed', [table.row('a step', 1.5, 'us', 'a peer', 3.0, 2.0)])"
    )
    done = subprocess.run(
        [sys.executable, "-c", script, BENCHMARKS, tmp_path], capture_output=True, text=True, check=True, timeout=60
    )
    place, told = done.stdout.splitlines()
    assert Path(place) == ROOT / "build" / "benchmarks"
    assert told == "a step: 1.5 us   a peer: 3, ratio 2"
    assert json.loads((tmp_path / "deep" / "speed.json").read_text())["rows"][0]["ratio"] == 2


def test_no_script_names_the_published_folder():
    for script in BENCHMARKS.glob("*.py"):
        assert '"results"' not in script.read_text(encoding="utf-8"), script.name
