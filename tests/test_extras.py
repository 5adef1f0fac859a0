"""What `pip install gtm-fmu` alone gives, and what it says about the rest."""

import json
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from gtm_fmu.extras import advice

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[1]
CONDITION = "--altitude-ft 10000"
GIVEN = [
    f"trim {CONDITION} --tas-kt 100",
    f"linearize {CONDITION} --tas-kt 100",
    f"envelope {CONDITION} --rudder-deg 10 10",
    f"manoeuvre {CONDITION} --tas-kt 100",
    f"performance {CONDITION}",
    f"predict {CONDITION} --rudder-deg 10 10",
    f"predict {CONDITION} --model network --rudder-deg 10 10",
    "build dynamics thrust-map-native --output fmus",
    f"advise {CONDITION}",
]
REFUSED = {
    f"envelope {CONDITION} --over rudder -10 10 5 --plot pages.html": "study",
    f"map limits {CONDITION} --plot limits.png": "study",
    "dataset cases.zarr --cases 3": "study",
    "train table.csv --inputs a --outputs b --output model.json": "study",
}
WITHOUT_EXTRAS = """
import sys, contextlib, io, json

class Missing:
    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] in MISSING:
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)

MISSING, commands = json.loads(sys.argv[1])
sys.meta_path.insert(0, Missing())
from gtm_study.commands import cli

answers = []
for words in commands:
    sys.argv = ["gtm-fmu", *words.split()]
    told = io.StringIO()
    with contextlib.redirect_stderr(told), contextlib.redirect_stdout(io.StringIO()):
        try:
            cli.main()
        except SystemExit as end:
            answers.append((end.code, told.getvalue()))
print(json.dumps(answers))
"""


def modules_of_extras() -> set[str]:
    """Those of the extras that are no part of the plain package, by the names they are imported under."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    named = {line.split(">")[0] for extra in ("study", "train") for line in project["optional-dependencies"][extra]}
    return (named - {"scikit-learn", "contourpy"}) | {"sklearn"}  # contourpy comes with matplotlib


def test_commands_without_extras(tmp_path):
    asked = json.dumps([sorted(modules_of_extras()), [*GIVEN, *REFUSED]])
    (tmp_path / "table.csv").write_text("a,b\n1,2\n")
    done = subprocess.run(
        [sys.executable, "-c", WITHOUT_EXTRAS, asked], cwd=tmp_path, capture_output=True, text=True, timeout=300
    )
    answers = json.loads(done.stdout.splitlines()[-1])
    assert [code for code, _ in answers[: len(GIVEN)]] == [0] * len(GIVEN), answers
    for (code, told), extra in zip(answers[len(GIVEN) :], REFUSED.values(), strict=True):
        assert code == 2
        assert f"pip install 'gtm-fmu[{extra}]'" in told
        assert told.count("\n") == 1


@pytest.mark.parametrize(
    ("module", "extra"),
    [("xarray", "study"), ("sklearn.base", "train"), ("torch", "train"), ("onnx", "onnx"), ("ziglang", "cross")],
)
def test_advice(module, extra):
    assert advice(module) == f"pip install 'gtm-fmu[{extra}]'"


def test_no_advice_on_other_modules():
    assert advice("nowhere") is None
