"""What an installed package has beside its modules: data, and all that FMUs are built from."""

import os
import platform
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

import gtm_fmu

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[1]
PACKAGES = ("gtm_fmu", "surrogate", "sensitivity", "fmu_src", "gtm_study")


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
    assert {f"gtm_fmu/core/generated/{name}.c" for name in ("airframe", "actuators")} <= installed


@pytest.fixture(scope="module")
def wheel(tmp_path_factory) -> Path:
    """The wheel for old Linux systems, which Zig compiles from the source archive."""
    pytest.importorskip("ziglang", reason="Zig is not installed")
    tag = "manylinux_2_17_x86_64.manylinux2014_x86_64"
    if platform.machine() != "x86_64" or sys.platform != "linux":
        pytest.skip("the wheel is for Linux on x86_64")
    dist = tmp_path_factory.mktemp("dist")
    subprocess.run([sys.executable, ROOT / "build_wheels.py", dist, "--only", tag], check=True, capture_output=True)
    (built,) = dist.glob("*.whl")
    assert built.name.endswith(f"-py3-none-{tag}.whl")
    assert built.stat().st_size < 3e6
    return built


def test_wheel_of_another_compiler_works_without_the_checkout(tmp_path, wheel):
    place = tmp_path / "place"
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(place)
    code = (
        "import gtm_fmu, fmu_src.fmus; print(gtm_fmu.__file__); print(gtm_fmu.envelope(10000, 0).v_max_kt); "
        "print(fmu_src.fmus.build_fmu('dynamics-native', __import__('pathlib').Path('.')))"
    )
    environment = {**os.environ, "PYTHONPATH": str(place)}
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, env=environment, capture_output=True, text=True)
    where, v_max_kt, fmu = done.stdout.splitlines()
    assert Path(where).is_relative_to(place)
    assert float(v_max_kt) == pytest.approx(gtm_fmu.envelope(10000, 0).v_max_kt, abs=1e-6)
    assert (tmp_path / fmu).exists()


def test_container(tmp_path, wheel):
    """What the Dockerfile runs, with the libraries that are here; the study starts without the checkout."""
    environment = {**os.environ, "PIP_NO_DEPS": "1", "PYTHONPATH": str(Path(pytest.__file__).parents[1])}

    def run(*words: str | Path) -> str:
        done = subprocess.run(words, cwd=tmp_path, env=environment, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        return done.stdout

    venv = tmp_path / "venv"
    assert f"compiled core        {venv}" in run(ROOT / "container" / "install.sh", venv, wheel)
    run(venv / "bin" / "gtm-fmu", "study", "--only", "trims", "--output", tmp_path / "study")
    assert (tmp_path / "study" / "index.html").exists()


def test_dockerfile():
    hadolint = Path(sys.executable).with_name("hadolint")
    if not hadolint.exists():
        pytest.skip("hadolint is not installed")
    assert subprocess.run([hadolint, ROOT / "Dockerfile"], capture_output=True, text=True).stdout == ""
