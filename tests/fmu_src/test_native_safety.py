"""Native FMUs under AddressSanitizer and UBSan: kept and random sequences of FMI calls with any values."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest

from fmu_src.packing.archive import digest
from fmu_src.packing.compiler import with_includes
from fmu_src.packing.native_fmus import NATIVE_MODELS
from gtm_fmu.airframe.tables import load_tables
from gtm_fmu.core import stored_tables

pytestmark = pytest.mark.slow

FUZZ = Path(__file__).parent / "fuzz"
SEED = 20261122
STRINGS = {
    "dynamics-native": 1500,
    "dynamics-native3": 1500,
    "aircraft-native": 200,
    "envelope-native3": 12,
    "manoeuvre-native3": 60,
    "surrogate-native3": 200,
    "thrust-map-native3": 200,
}
"""Random strings by model; an envelope takes some tenths of a second here."""

PLAIN = ("-std=c99", "-g", "-O1", "-fno-pic", "-I.")
SANITIZED = (*PLAIN, "-fsanitize=address,undefined", "-fno-sanitize-recover=all")


def needs(*tools: str) -> None:
    for tool in tools:
        if shutil.which(tool) is None:
            pytest.skip(f"{tool} is not installed")


def compiled(compiler: str, flags: tuple[str, ...], path: str, sources: dict[str, bytes], folder: Path) -> str:
    """One object of a file in the folder; made once for all models that share the file."""
    parts = with_includes(path, sources) | {"with": " ".join((compiler, *flags)).encode()}
    kept = folder.parent / f"{digest(parts)}.o"
    if not kept.exists():
        subprocess.run([compiler, *flags, "-c", path, "-o", kept], cwd=folder, check=True, capture_output=True)
    return str(kept)


def sources_of(model: str, networks: tuple, folder: Path) -> dict[str, bytes]:
    """The C of a native FMU and the driver, written to a folder too."""
    given = networks[2] if model.startswith("surrogate") else ()
    sources = NATIVE_MODELS[model](given).all_sources() | {"calls.c": (FUZZ / "calls.c").read_bytes()}
    for name, content in sources.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(content)
    return sources


def driver_of(model: str, networks: tuple, folder: Path, compiler: str, *fuzzer: str) -> Path:
    """The driver with an FMU; what generators wrote is compiled plainly, all else with sanitizers."""
    place = folder / f"{model}-{compiler}"
    sources = sources_of(model, networks, place)
    own = (*SANITIZED, f"-DFMI={3 if model.endswith('3') else 2}", *fuzzer)
    files = sorted(name for name in sources if name.endswith(".c"))
    objects = [
        compiled(compiler, PLAIN if name.startswith("generated/") else own, name, sources, place) for name in files
    ]
    subprocess.run(
        [compiler, *own, "-no-pie", "-o", "calls", *objects, "-lm"], cwd=place, check=True, capture_output=True
    )
    return place / "calls"


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    return tmp_path_factory.mktemp("safety")


@pytest.fixture(scope="module")
def has_sanitizers(folder) -> bool:
    needs("gcc")
    (folder / "empty.c").write_text("int main(void) { return 0; }\n")
    built = subprocess.run(["gcc", *SANITIZED, "-no-pie", "empty.c", "-o", "empty"], cwd=folder, capture_output=True)
    return built.returncode == 0 and subprocess.run([folder / "empty"], capture_output=True).returncode == 0


@pytest.mark.parametrize("model", STRINGS)
def test_sequences_of_calls(model, networks, folder, has_sanitizers):
    """The corpus holds whole lives of an instance in both kinds and what has once been wrong; then random strings."""
    if not has_sanitizers:
        pytest.skip("gcc has no AddressSanitizer and UBSan here")
    driver = driver_of(model, networks, folder, "gcc")
    corpus = sorted((FUZZ / "corpus").iterdir())
    assert corpus
    environment = os.environ | {"ASAN_OPTIONS": "detect_leaks=1", "UBSAN_OPTIONS": "print_stacktrace=1"}
    command = [driver, str(STRINGS[model]), str(SEED), *corpus]
    run = subprocess.run(command, capture_output=True, text=True, env=environment, timeout=500)
    assert run.returncode == 0, run.stdout[-2000:] + run.stderr[-4000:]
    assert run.stdout.startswith(f"{STRINGS[model]} strings")
    assert run.stderr == ""


def test_libfuzzer(networks, folder):
    """The same driver under libFuzzer, where clang has it, for some seconds from the corpus."""
    needs("clang")
    try:
        driver = driver_of("dynamics-native", networks, folder, "clang", "-fsanitize=fuzzer", "-DFUZZER")
    except subprocess.CalledProcessError as error:
        if b"fuzzer" in error.stderr:
            pytest.skip("clang has no libFuzzer here")
        raise
    shutil.copytree(FUZZ / "corpus", driver.parent / "corpus")
    command = [driver, "-max_total_time=6", "-max_len=600", "-timeout=200", "corpus"]
    run = subprocess.run(command, cwd=driver.parent, capture_output=True, text=True)
    assert run.returncode == 0, run.stderr[-4000:]
    assert "DONE" in run.stderr


def test_no_state_outside_instances(networks, folder):
    """No writable data in the compiled wrappers, models and core: nothing that two instances could share.

    But for the aerodynamic tables, which are written before the first call; tests/gtm_fmu/core/test_unfolded_tables.py
    sees to it that nothing else writes them. Not optimised, so that no compiler takes any away.
    """
    needs("gcc", "nm")
    objects = set()
    for model in NATIVE_MODELS:
        place = folder / model
        sources = sources_of(model, networks, place)
        files = [name for name in sources if name.endswith(".c") and name != "calls.c"]
        objects |= {compiled("gcc", (*PLAIN, "-O0"), name, sources, place) for name in files}
    symbols = subprocess.run(["nm", *objects], capture_output=True, text=True, check=True).stdout
    writable = (["b"], ["B"], ["C"], ["d"], ["D"])
    shared = {line.split()[-1] for line in symbols.splitlines() if line.split()[-2:-1] in writable}
    database = load_tables()
    tables = {*stored_tables.folded(database), *stored_tables.configured(database), "right_aileron"}
    assert shared == {f"gtm_{name}_table" for name in tables}
