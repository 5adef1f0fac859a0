"""`gtm_fmu` and `surrogate`: what a program imports from them, how long that takes, and the version."""

import pkgutil
import subprocess
import sys
import tomllib
from pathlib import Path
from types import FunctionType

import pytest

import gtm_fmu
import surrogate

ROOT = Path(__file__).parents[1]
ESTIMATORS = [
    "BayesianRegularizationRegressor",
    "HilomotRegressor",
    "LevenbergMarquardtRegressor",
    "LolimotRegressor",
]


def run(program: str) -> str:
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, cwd=ROOT, timeout=300)
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


@pytest.mark.parametrize("package", [gtm_fmu, surrogate])
def test_every_public_name_is_there(package):
    for name in package.__all__:
        assert getattr(package, name) is not None
    assert dir(package) == sorted(package.__all__)
    with pytest.raises(AttributeError, match=f"'{package.__name__}' has no attribute 'absent'"):
        package.absent  # noqa: B018


def test_estimators_without_torch():
    program = f"import sys\nfrom surrogate import {', '.join(ESTIMATORS)}\nprint('torch' in sys.modules)"
    assert run(program) == "False"
    assert set(ESTIMATORS) < set(surrogate.__all__)


@pytest.mark.parametrize("package", ["gtm_fmu", "surrogate"])
def test_import_loads_no_library(package):
    """What stands behind the names comes when it is asked for."""
    listed = f"import sys\nbefore = set(sys.modules)\nimport {package}\nprint(*set(sys.modules) - before)"
    loaded = {name.partition(".")[0] for name in run(listed).split()} - sys.stdlib_module_names
    assert loaded == {package}


def test_no_module_hides_a_function():
    """Python binds an imported module to its package: none may have the name of something public."""
    for package in (gtm_fmu, surrogate):
        modules = {name for _, name, _ in pkgutil.iter_modules(package.__path__)}
        assert modules
        assert not modules & set(package.__all__)
    assert all(isinstance(getattr(gtm_fmu, name), FunctionType) for name in ("envelope", "equilibrium", "trim"))


def test_version():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    assert gtm_fmu.__version__ == project["version"]


def test_module_is_the_command_line():
    """`python -m gtm_fmu`; the package itself does not know the command line."""
    done = subprocess.run([sys.executable, "-m", "gtm_fmu", "--version"], capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stdout, done.stderr) == (0, f"gtm-fmu {gtm_fmu.__version__}\n", "")
    assert run("import sys\nfrom gtm_fmu import ControlLimits, envelope\nprint('gtm_study' in sys.modules)") == "False"
