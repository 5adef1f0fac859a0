"""CITATION.cff names what pyproject.toml and NOTICE do."""

import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]


def test_citation_agrees_with_the_package():
    yaml = pytest.importorskip("yaml", reason="PyYAML is not installed")
    cited = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert (cited["version"], cited["license"]) == (project["version"], project["license"])
    notice = " ".join((ROOT / "NOTICE").read_text(encoding="utf-8").split())
    paper, data = cited["references"]
    assert paper["title"] in notice
    assert f"{paper['journal']} {paper['volume']} ({paper['year']})" in notice
    assert all(author["family-names"] in notice for author in paper["authors"])
    assert data["notes"].rpartition(" ")[2] in notice
