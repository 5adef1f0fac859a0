"""`gtm-fmu doctor`: what is here and what is missing."""

import json

from gtm_study.commands import doctor
from tests.gtm_study.conftest import Answer


def test_parts_that_are_here_have_a_version_or_a_place(ask):
    answer: Answer = ask("doctor", "--json")
    assert answer.code == 0
    found = {part["name"]: part["found"] for part in json.loads(answer.out)["parts"]}
    assert found["compiled core"].endswith(("gtm_core.so", "gtm_core.dylib", "gtm_core.dll"))
    assert found["Python"].startswith("3.")


def test_missing_parts_say_how_to_get_them(ask, monkeypatch):
    monkeypatch.setattr(doctor, "find_spec", lambda name: None)
    monkeypatch.setattr(doctor.shutil, "which", lambda name: None)
    answer = ask("doctor")
    assert answer.code == 0
    for word in ("gtm-fmu[cross]", "gtm-fmu[train]", "apt-get install"):
        assert word in answer.out


def test_without_a_core_the_exit_code_is_3(ask, monkeypatch):
    def missing():
        raise FileNotFoundError

    monkeypatch.setattr(doctor, "library_path", missing)
    assert ask("doctor", "--json").code == 3
