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


def test_a_ratio_that_fell_by_more_than_a_third_is_named(tmp_path):
    """3 from 4.6 is less than two thirds, 3.1 from 4.6 is more."""
    published = {"rows": [row(name, 4.6) for name in ("a step", "a trim", "a part gone")], "times_faster_than_x": 10.0}
    measured = {"rows": [row("a step", 3.0), row("a trim", 3.1), row("a part new", 1.0)], "times_faster_than_x": 6.0}
    for folder, result in (("then", published), ("now", measured)):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "speed.json").write_text(json.dumps(result))
    assert compare(tmp_path / "now", tmp_path / "then") == [
        "speed: a step against a peer: fell from 4.6 to 3.",
        "speed: a part new against a peer: 1, not among the published results.",
        "speed: times_faster_than_x: fell from 10 to 6.",
        "speed: a part gone against a peer: published, not measured now.",
    ]


def test_the_published_results_have_not_fallen_behind_themselves():
    published = BENCHMARKS / "results"
    assert compare(published, published) == ["No ratio fell by more than a third since the published results."]


def row(name: str, ratio: float) -> dict:
    return {"name": name, "value": 1.0, "unit": "us", "peer": "a peer", "peer_value": ratio, "ratio": ratio}


def compare(measured: Path, published: Path) -> list[str]:
    command = [sys.executable, BENCHMARKS / "compare.py", measured, published]
    return subprocess.run(command, capture_output=True, text=True, check=True, timeout=60).stdout.splitlines()


def test_no_script_names_the_published_folder():
    for script in BENCHMARKS.glob("*.py"):
        assert '"results"' not in script.read_text(encoding="utf-8"), script.name
