"""Wrappers under AddressSanitizer and UBSan: kept and random sequences of FMI calls with any values."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest

from fmu_src.native_packaging import NATIVE_MODELS

FUZZ = Path(__file__).parent / "fuzz"
STRINGS = 3000
SEED = 20261122
SANITIZED = ("-std=c99", "-g", "-O1", "-fsanitize=address,undefined", "-fno-sanitize-recover=all", "-I.")


def unpack(folder: Path, model: str) -> list[str]:
    """Sources of a native FMU and the driver in a folder; the files to compile."""
    sources = NATIVE_MODELS[model](()).all_sources() | {"calls.c": (FUZZ / "calls.c").read_bytes()}
    for name, content in sources.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(content)
    return sorted(name for name in sources if name.endswith(".c"))


def has_sanitizers(folder: Path) -> bool:
    (folder / "empty.c").write_text("int main(void) { return 0; }\n")
    command = ["gcc", "-fsanitize=address,undefined", "empty.c", "-o", "empty"]
    built = subprocess.run(command, cwd=folder, capture_output=True).returncode == 0
    return built and subprocess.run([folder / "empty"], capture_output=True).returncode == 0


@pytest.fixture(scope="module", params=[("dynamics-native", 2), ("dynamics-native3", 3)], ids=["fmi2", "fmi3"])
def driver(request, tmp_path_factory) -> Path:
    """The driver with the sources of an FMU, compiled with sanitizers."""
    if shutil.which("gcc") is None:
        pytest.skip("gcc is not installed")
    model, fmi = request.param
    folder = tmp_path_factory.mktemp(model)
    if not has_sanitizers(folder):
        pytest.skip("gcc has no AddressSanitizer and UBSan here")
    files = unpack(folder, model)
    command = ["gcc", *SANITIZED, f"-DFMI={fmi}", "-o", "calls", *files, "-lm"]
    built = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    assert built.returncode == 0, built.stderr
    return folder / "calls"


def test_sequences_of_calls(driver):
    """The corpus holds whole lives of an instance in both kinds and what has once been wrong; then random strings."""
    corpus = sorted((FUZZ / "corpus").iterdir())
    assert corpus
    environment = os.environ | {"ASAN_OPTIONS": "detect_leaks=1", "UBSAN_OPTIONS": "print_stacktrace=1"}
    run = subprocess.run(
        [driver, str(STRINGS), str(SEED), *corpus], capture_output=True, text=True, env=environment, timeout=500
    )
    assert run.returncode == 0, run.stdout[-2000:] + run.stderr[-4000:]
    assert run.stdout.startswith(f"{STRINGS} strings")
    assert run.stderr == ""


def test_libfuzzer(tmp_path):
    """The same driver under libFuzzer, where clang has it, for ten seconds from the corpus."""
    if shutil.which("clang") is None:
        pytest.skip("clang is not installed")
    files = unpack(tmp_path, "dynamics-native")
    command = ["clang", *SANITIZED, "-fsanitize=fuzzer", "-DFUZZER", "-DFMI=2", "-o", "calls", *files, "-lm"]
    built = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    if built.returncode and "fuzzer" in built.stderr:
        pytest.skip("clang has no libFuzzer here")
    assert built.returncode == 0, built.stderr
    shutil.copytree(FUZZ / "corpus", tmp_path / "corpus")
    run = subprocess.run(
        ["./calls", "-max_total_time=10", "-max_len=600", "-timeout=20", "corpus"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
    )
    assert run.returncode == 0, run.stderr[-4000:]


def test_no_state_outside_instances(tmp_path):
    """No writable data in the compiled wrappers and the core: nothing that two instances could share."""
    if shutil.which("nm") is None or shutil.which("gcc") is None:
        pytest.skip("gcc and nm are not installed")
    for model in NATIVE_MODELS:
        if model.startswith("surrogate"):  # whose own C is written from networks
            continue
        folder = tmp_path / model
        files = [name for name in unpack(folder, model) if name != "calls.c"]
        subprocess.run(["gcc", "-std=c99", "-O0", "-fno-pic", "-I.", "-c", *files], cwd=folder, check=True)
        for compiled in folder.glob("*.o"):
            symbols = subprocess.run(["nm", compiled], capture_output=True, text=True, check=True).stdout
            shared = [line for line in symbols.splitlines() if line.split()[-2] in ("b", "B", "C", "d", "D")]
            assert shared == [], compiled.name
