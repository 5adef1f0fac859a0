"""The sources of several FMUs linked into one program: no name is shared, each runs its own code."""

import re
import shutil
import subprocess
from pathlib import Path

import fmpy
import numpy as np
import pytest

from examples.foreign_fmus.build import HERE as FOREIGN
from fmu_src.packing.model_fmu import build_model
from fmu_src.packing.native_fmus import NATIVE_MODELS
from fmu_src.packing.native_sources import HEADERS, standard_headers
from tests.fmu_src.test_model_fmu import MODELS

pytestmark = pytest.mark.slow

LINKED = Path(__file__).with_name("linked.c")
PAGE = Path(__file__).parents[2] / "docs" / "fmus.md"
FULL_NAME = """#ifdef FMI2_FUNCTION_PREFIX
#define fmi2Paste(a, b) a##b
#define fmi2PasteB(a, b) fmi2Paste(a, b)
#define fmi2FullName(name) fmi2PasteB(FMI2_FUNCTION_PREFIX, name)
#else
#define fmi2FullName(name) name
#endif
"""


@pytest.fixture(scope="module")
def headers(tmp_path_factory) -> Path:
    """Those of the standard: FMPy's, but with the prefix that FMI 2.0.5, 2.1.1, asks for and FMPy has taken out."""
    folder = tmp_path_factory.mktemp("headers")
    for fmi in (2, 3):
        for name, content in standard_headers(fmi).items():
            text = content.decode()
            if name == "fmi2Functions.h":
                assert text.count("#define fmi2FullName(name) name\n") == 1
                text = text.replace("#define fmi2FullName(name) name\n", FULL_NAME)
            (folder / name).write_text(text)
    return folder


def names_of(archive: Path) -> set[str]:
    """External names that a library defines."""
    table = subprocess.run(["nm", "-g", "--defined-only", archive], capture_output=True, text=True, check=True).stdout
    return {line.split()[2] for line in table.splitlines() if len(line.split()) == 3}


def library(folder: Path, headers: Path, name: str) -> Path:
    """The sources of an unpacked FMU as a static library."""
    sources = folder / "sources"
    files = [path.relative_to(sources) for path in sources.rglob("*.c")]
    flags = ("-std=c99", "-Wall", "-Werror", "-I.", f"-I{headers}")
    subprocess.run(["cc", "-c", *flags, *files], cwd=sources, check=True)
    archive = folder / f"lib{name}.a"
    subprocess.run(["ar", "rcs", archive, *sources.glob("*.o")], check=True)
    return archive


def needs_binutils() -> None:
    for tool in ("cc", "ar", "nm"):
        if shutil.which(tool) is None:
            pytest.skip(f"{tool} is not installed")


def test_four_fmus_in_one_program(native_folders, headers, tmp_path):
    needs_binutils()
    model = MODELS["without deviations"]
    folders = {
        "GtmDynamicsNative": native_folders[2],
        "GtmDynamicsNative3": native_folders[3],
        "wing": Path(fmpy.extract(build_model(model, tmp_path / "wing.fmu"), tmp_path / "wing")),
    }
    libraries = {}
    for name, folder in folders.items():
        copy = tmp_path / "copies" / name
        shutil.copytree(folder, copy)
        libraries[name] = library(copy, headers, name)
        assert all(symbol.startswith(f"{name}_") for symbol in names_of(libraries[name]))
    by_hand = "GtmDynamicsNative_gtm_unfold_tables"  # where start-up code runs no constructors
    assert by_hand in names_of(libraries["GtmDynamicsNative"])
    assert f"`{by_hand}()`" in PAGE.read_text(encoding="utf-8")
    flags = ["-DFMI2_FUNCTION_PREFIX=VanDerPol_", f"-I{headers}"]
    subprocess.run(["cc", "-c", *flags, FOREIGN / "van_der_pol.c", "-o", tmp_path / "foreign.o"], check=True)

    descriptions = {name: fmpy.read_model_description(folder) for name, folder in folders.items()}
    names = {name: [v.name for v in description.modelVariables] for name, description in descriptions.items()}
    numbers = {"TAS": names["GtmDynamicsNative"].index("air.tas"), "LIFT": names["wing"].index(model.outputs[0].name)}
    tokens = {"DYNAMICS": "GtmDynamicsNative", "DYNAMICS3": "GtmDynamicsNative3", "WING": "wing"}
    given = [f"-D{key}={number}" for key, number in numbers.items()]
    given += [f'-DTOKEN_{key}="{descriptions[name].guid}"' for key, name in tokens.items()]
    program = tmp_path / "program"
    linked = [LINKED, tmp_path / "foreign.o", *libraries.values(), "-lm", "-o", program]
    subprocess.run(["cc", "-std=c99", f"-I{headers}", *given, *linked], check=True)
    run = subprocess.run([program], capture_output=True, text=True)
    assert (run.returncode, run.stderr) == (0, "")
    tas, lift, der_velocity, tas3 = map(float, run.stdout.split())
    assert tas == pytest.approx(164.14225 * 0.3048)  # SPEC 13: the trimmed level flight
    assert tas3 == tas
    assert lift == pytest.approx(model.predict(np.mean(model.input_ranges, axis=1))[0])
    assert der_velocity == -2.0  # x = 2, v = 0, mu = 1


def test_recipe_of_the_page(built, headers, tmp_path):
    needs_binutils()
    if shutil.which("unzip") is None:
        pytest.skip("unzip is not installed")
    page = PAGE.read_text(encoding="utf-8")
    (recipe,) = re.findall(r"```sh\n(.*?)```", page, re.DOTALL)
    (program,) = re.findall(r"```c\n(.*?)```", page, re.DOTALL)
    (tmp_path / "program.c").write_text(program)
    for name in ("dynamics-native", "thrust-map-native"):
        path = built(name)
        (tmp_path / path.name).symlink_to(path)
    environment = {"PATH": "/usr/bin:/bin", "FMI": str(headers)}
    subprocess.run(["sh", "-euc", recipe], cwd=tmp_path, check=True, env=environment)
    run = subprocess.run([tmp_path / "program"], capture_output=True, text=True, check=True)
    assert run.stdout == "2.0 2.0\n"
    assert not names_of(tmp_path / "libGtmDynamicsNative.a") & names_of(tmp_path / "libGtmThrustMapNative.a")


def test_shared_library_without_prefix(headers, tmp_path):
    """What FMI{2,3}_OVERRIDE_FUNCTION_PREFIX is for: an importer makes a shared library of the sources."""
    needs_binutils()
    for fmi in (2, 3):
        name = f"wing{fmi}"
        path = build_model(MODELS["without deviations"], tmp_path / f"{name}.fmu", fmi)
        sources = Path(fmpy.extract(path, tmp_path / name), "sources")
        flags = ["-shared", "-fPIC", f"-DFMI{fmi}_OVERRIDE_FUNCTION_PREFIX", "-I.", f"-I{headers}"]
        subprocess.run(["cc", *flags, *sources.glob("*.c"), "-lm", "-o", "wing.so"], cwd=sources, check=True)
        assert {f"fmi{fmi}DoStep", f"{name}_instance_step"} < names_of(sources / "wing.so")


def test_headers_are_the_importers():
    """FMI 2.0.5, 2.3, and FMI 3.0, 2.5.1: sources come without the standard's headers."""
    for name in ("dynamics-native", "dynamics-native3"):
        shipped = NATIVE_MODELS[name](()).shipped_sources()
        assert not {header for headers in HEADERS.values() for header in headers} & shipped.keys()


def test_all_names_of_the_core_have_the_prefix(headers, tmp_path):
    needs_binutils()
    contents = NATIVE_MODELS["aircraft-native"](())
    for path, content in contents.shipped_sources().items():
        (tmp_path / "sources" / path).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / "sources" / path).write_bytes(content)
    own = names_of(library(tmp_path, headers, "all"))
    assert len(own) > 300
    assert [symbol for symbol in own if not symbol.startswith(f"{contents.model.name}_")] == []
