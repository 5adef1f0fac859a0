"""What an installed package has beside its modules: data, and all that FMUs are built from."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PACKAGES = ("gtm_fmu", "surrogate", "sensitivity", "fmu_src", "study")


def test_every_file_of_the_packages_is_installed(tmp_path):
    """Built from a copy, since generated C is written into the tree that is built."""
    if shutil.which("git") is None or not (ROOT / ".git").exists():
        pytest.skip("what belongs to the packages is asked of git")
    listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True).stdout.split()
    tree, built = tmp_path / "tree", tmp_path / "built"
    for name in listed:
        (tree / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / name, tree / name)
    command = [sys.executable, "setup.py", "-q", "build_py", "--build-lib", str(built)]
    subprocess.run(command, cwd=tree, check=True, capture_output=True)
    installed = {str(path.relative_to(built)) for path in built.rglob("*") if path.is_file()}
    assert {name for name in listed if name.startswith(PACKAGES)} <= installed
    assert {f"gtm_fmu/core/generated/{name}.c" for name in ("airframe", "tables", "actuators")} <= installed
