"""Folders of long runs: new, empty or of an earlier run; never one with the user's own files."""

from pathlib import Path

import pytest

from gtm_study import kept
from gtm_study.kept import Kept, run_folder


class TestFolder:
    def test_new_or_empty(self, tmp_path):
        (tmp_path / "empty").mkdir()
        for path in (tmp_path / "empty", tmp_path / "new" / "below"):
            assert run_folder(path) == path
            assert path.is_dir()

    def test_of_an_earlier_run(self, tmp_path):
        Kept(tmp_path / "run").part("one", lambda: {"x": 1})
        (tmp_path / "run" / "results.json").write_text("{}")
        assert run_folder(tmp_path / "run") == tmp_path / "run"

    @pytest.mark.parametrize("command", ["study", "study --pdf", "protocol", "surrogates"])
    def test_of_the_user(self, ask, tmp_path, command, monkeypatch):
        """What is there stays as it is, nothing comes to it, and what the machine lacks is told later."""
        monkeypatch.setattr("gtm_fmu.extras.find_spec", lambda library: None)
        monkeypatch.setattr("gtm_study.report.browser.BROWSERS", ())
        (tmp_path / "index.html").write_text("mine")
        told = ask(*command.split(), "--output", tmp_path)
        assert told.code == 2
        assert (
            told.err == f"gtm-fmu: {tmp_path} holds files that are not of such a run; name a new or an empty folder.\n"
        )
        assert [path.name for path in tmp_path.iterdir()] == ["index.html"]
        assert (tmp_path / "index.html").read_text() == "mine"


class TestCode:
    """What a finished part follows from holds whatever a page or a figure is made of, not Python alone."""

    def test_pages_and_data_count(self):
        root = Path(kept.__file__).parents[1]
        found = {path.relative_to(root).as_posix() for path in kept.sources(root)}
        web = {path.relative_to(root).as_posix() for path in (root / "gtm_study").rglob("web/*") if path.is_file()}
        assert {Path(name).suffix for name in web} >= {".js", ".css", ".html"}
        assert web <= found
        assert {"gtm_fmu/core/gtm_t2.c", "gtm_study/paper/data/nasa_plots/level_trim_vs_alpha.csv"} <= found
        assert not [name for name in found if name.endswith((".pyc", ".so"))]

    def test_another_page_is_another_code(self, tmp_path):
        """So a stage that made the old one is run again."""
        page = tmp_path / "gtm_study" / "explorer" / "web" / "explorer.js"
        page.parent.mkdir(parents=True)
        page.write_text("one")
        before = kept.hashed(kept.sources(tmp_path))
        page.write_text("two")
        assert kept.hashed(kept.sources(tmp_path)) != before
