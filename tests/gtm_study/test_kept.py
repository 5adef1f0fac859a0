"""Folders of long runs: new, empty or of an earlier run; never one with the user's own files."""

import pytest

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
    def test_of_the_user(self, ask, tmp_path, command):
        """What is there stays as it is, and nothing comes to it."""
        (tmp_path / "index.html").write_text("mine")
        told = ask(*command.split(), "--output", tmp_path)
        assert told.code == 2
        assert (
            told.err == f"gtm-fmu: {tmp_path} holds files that are not of such a run; name a new or an empty folder.\n"
        )
        assert [path.name for path in tmp_path.iterdir()] == ["index.html"]
        assert (tmp_path / "index.html").read_text() == "mine"
