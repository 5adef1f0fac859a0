"""The example of docs/surrogates.md runs as it stands."""

import re
from pathlib import Path

PAGE = Path(__file__).parents[2] / "docs" / "surrogates.md"


def test_example_runs(tmp_path, monkeypatch, capsys):
    [example] = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    monkeypatch.chdir(tmp_path)
    exec(compile(example, str(PAGE), "exec"), {})
    printed = capsys.readouterr().out
    score, share = float(re.search(r"R2 (\S+),", printed)[1]), float(re.search(r"(\d+)% of the tests", printed)[1])
    assert score > 0.3  # linear regression: 0.36
    assert 90 <= share <= 99
    assert "model 1: target = " in printed
    assert (tmp_path / "diabetes.json").exists()
