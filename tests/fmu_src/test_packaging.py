"""The archive: reproducible, only what runs here, code that no other FMU of the process can take the place of."""

import gc
import json
import math
import os
import shutil
import subprocess
import sys
import zipfile
from dataclasses import replace
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.fmi2 import FMU2Slave

from fmu_src import build
from fmu_src.packing import compiler
from fmu_src.packing import python_fmus as packaging
from fmu_src.slaves.slave import platform_folder
from gtm_fmu.aircraft.client import FmuClient, FmuError
from gtm_fmu.core import library_path
from gtm_fmu.errors import InputError

pytestmark = pytest.mark.slow


def members(path: Path) -> dict[str, bytes]:
    with zipfile.ZipFile(path) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def repacked(source: Path, target: Path, drop: str) -> Path:
    with zipfile.ZipFile(target, "w") as archive:
        for name, content in members(source).items():
            if not name.startswith(drop):
                archive.writestr(name, content)
    return target


class TestArchive:
    def test_equal_sources_give_equal_bytes(self, dynamics_fmu, tmp_path):
        assert build("dynamics", tmp_path).read_bytes() == dynamics_fmu.read_bytes()

    def test_another_process_gives_equal_bytes(self, dynamics_fmu, tmp_path):
        script = Path(__file__).parents[2] / "build_fmu.py"
        command = [sys.executable, script, "dynamics", "-o", tmp_path]
        run = subprocess.run(command, capture_output=True, text=True, check=True)
        assert Path(run.stdout.strip()).read_bytes() == dynamics_fmu.read_bytes()

    def test_another_compiler_of_the_same_name_is_another_compiler(self, tmp_path, monkeypatch):
        """What one has compiled is not taken for the other's."""
        sources = {"doubled.c": b'__attribute__((visibility("default"))) int doubled(int n) { return 2 * n; }'}
        (usual,) = compiler.host_binary("doubled", sources).values()
        (tmp_path / "cc").write_text(f'#!/bin/sh\nexec {shutil.which("cc")} "$@" -Ddoubled=twice\n')
        (tmp_path / "cc").chmod(0o755)
        monkeypatch.setenv("PATH", str(tmp_path), prepend=os.pathsep)
        (other,) = compiler.host_binary("doubled", sources).values()
        assert (b"doubled" in usual, b"twice" in other) == (True, True)

    def test_binaries_only_where_the_core_is(self, dynamics_fmu):
        files = members(dynamics_fmu)
        here = platform_folder()
        assert {name.split("/")[1] for name in files if name.startswith("binaries/")} == {here}
        assert {name.split("/")[2] for name in files if name.startswith("resources/core/")} == {here}
        assert files[f"resources/core/{here}/{library_path().name}"] == library_path().read_bytes()

    def test_documentation_icon_and_licences(self, dynamics_fmu):
        files = members(dynamics_fmu)
        page = files["documentation/index.html"].decode()
        for variable in fmpy.read_model_description(dynamics_fmu).modelVariables:
            assert f"<code>{variable.name}</code>" in page
            assert variable.description in page
        assert "LAR-17625-1" in page
        assert "needsExecutionTool" in page
        assert b"Apache License" in files["documentation/licenses/gtm-fmu-LICENSE.txt"]
        assert b"MIT License" in files["documentation/licenses/pythonfmu-LICENSE.txt"]
        assert files["model.png"].startswith(b"\x89PNG")

    def test_nothing_of_this_machine_is_inside(self, dynamics_fmu):
        for name, content in members(dynamics_fmu).items():
            if not name.endswith((".so", ".dll")):
                assert str(Path(__file__).parents[2]).encode() not in content, name

    def test_a_build_leaves_the_process_as_it_was(self, tmp_path):
        search_path, modules = list(sys.path), set(sys.modules)
        build("dynamics", tmp_path)
        assert sys.path == search_path
        assert not [name for name in set(sys.modules) - modules if name.startswith("gtm_")]


class TestBadInput:
    def test_unknown_name(self, tmp_path):
        with pytest.raises(InputError, match=r"No FMU is called 'glider': choose one of dynamics"):
            build("glider", tmp_path)

    def test_folder_that_cannot_be_written(self, tmp_path):
        (tmp_path / "file").touch()
        with pytest.raises(InputError, match=r"Cannot write .*; choose a folder"):
            build("dynamics", tmp_path / "file" / "folder")
        assert [path.name for path in tmp_path.iterdir()] == ["file"]

    def test_missing_core(self, tmp_path, monkeypatch):
        def nowhere():
            raise FileNotFoundError("No compiled core in X: install the package first.")

        monkeypatch.setattr(packaging, "library_path", nowhere)
        with pytest.raises(InputError, match="install the package first"):
            build("dynamics", tmp_path)

    def test_networks_that_are_not_used(self, tmp_path):
        with pytest.raises(InputError, match="Networks were given for the dynamics FMU"):
            build("dynamics", tmp_path, networks=["net.json"])

    def test_platform_without_a_wrapper(self, tmp_path, monkeypatch):
        monkeypatch.setattr(compiler, "platform_folder", lambda: "riscv64-linux")
        with pytest.raises(InputError, match=r"FMUs are not built for riscv64-linux: build on one of .*linux64"):
            build("dynamics", tmp_path)

    def test_no_compiler(self, tmp_path, monkeypatch):
        monkeypatch.setenv("CC", "no-such-compiler")
        with pytest.raises(InputError, match="An FMU needs a C compiler and none was found: install one"):
            build("dynamics", tmp_path)

    def test_command_line(self, tmp_path):
        script = Path(__file__).parents[2] / "build_fmu.py"
        (tmp_path / "file").touch()
        command = [sys.executable, script, "dynamics", "-o", tmp_path / "file"]
        run = subprocess.run(command, capture_output=True, text=True)
        assert run.returncode == 2
        assert run.stdout == ""
        assert run.stderr.count("\n") == 1
        assert run.stderr.startswith("Cannot write ")


class TestOneProcess:
    """Slaves share sys.modules: each FMU must run its own code and resources all the same."""

    def test_rebuilt_with_changed_resources(self, dynamics_fmu, tmp_path, monkeypatch):
        contents = packaging.dynamics_contents([])
        states = tuple(
            replace(variable, start=1000.0) if variable.name == "state.altitude" else variable
            for variable in contents.model.groups["states"]
        )
        model = replace(contents.model, groups={**contents.model.groups, "states": states})
        monkeypatch.setitem(packaging.MODELS, "dynamics", lambda networks: replace(contents, model=model))
        with FmuClient(dynamics_fmu) as old, FmuClient(build("dynamics", tmp_path)) as rebuilt:
            assert old.get(["state.altitude"]) == pytest.approx(800 * 0.3048)
            assert rebuilt.get(["state.altitude"]) == 1000.0
            old.reset()
            assert old.get(["state.altitude"]) == pytest.approx(800 * 0.3048)

    def test_rebuilt_with_changed_source(self, dynamics_fmu, tmp_path, monkeypatch):
        """The copy computes the rates with the opposite sign."""
        source = tmp_path / "fmu_src"
        shutil.copytree(Path(packaging.__file__).parents[1], source)
        slave = source / "slaves" / "gtm_dynamics.py"
        text = slave.read_text()
        assert text.count("= rates") == 1
        slave.write_text(text.replace("= rates", "= [-rate for rate in rates]"))
        monkeypatch.setattr(packaging, "SOURCES", source)
        with FmuClient(dynamics_fmu) as old, FmuClient(build("dynamics", tmp_path)) as rebuilt:
            x, u = old.get(old.states), old.get(old.controls)
            x[5] += 0.2
            expected = old.evaluate(x, u)
            assert np.abs(expected).max() > 1
            np.testing.assert_array_equal(rebuilt.evaluate(x, u), -expected)
            np.testing.assert_array_equal(old.evaluate(x, u), expected)

    def test_instances_are_independent(self, dynamics_fmu):
        with FmuClient(dynamics_fmu) as one, FmuClient(dynamics_fmu) as other:
            before = other.get(other.states)
            one.set(["control.elevator"], [-0.2])
            one.step(1.0)
            np.testing.assert_array_equal(other.get(other.states), before)
            other.set(["control.elevator"], [-0.2])
            other.step(1.0)
            np.testing.assert_array_equal(other.get(other.states), one.get(one.states))

    def test_search_path_does_not_grow(self, dynamics_fmu):
        search_path = list(sys.path)
        for _ in range(3):
            with FmuClient(dynamics_fmu):
                pass
        assert sys.path == search_path


def resident_kb() -> float:
    gc.collect()
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith("VmRSS"):
            return float(line.split()[1])
    pytest.skip("the system does not tell the resident memory")


def test_a_thousand_instances_do_not_grow(dynamics_fmu, tmp_path):
    """An instance leaves nothing behind."""
    folder = fmpy.extract(dynamics_fmu, tmp_path)
    description = fmpy.read_model_description(dynamics_fmu)

    def cycle():
        fmu = FMU2Slave(guid=description.guid, unzipDirectory=folder, modelIdentifier="GtmDynamics", instanceName="one")
        fmu.instantiate()
        fmu.setupExperiment()
        fmu.enterInitializationMode()
        fmu.getReal([12])
        fmu.freeInstance()

    for _ in range(500):
        cycle()
    before = resident_kb()
    for _ in range(1000):
        cycle()
    assert resident_kb() - before < 2000


@pytest.mark.parametrize("content", [None, b"", b"\0not what it was"])
@pytest.mark.parametrize("member", ["resources/variables.json", "resources/core/linux64/gtm_core.so"])
def test_damaged_resources(dynamics_fmu, tmp_path, member, content):
    """The host lives on and gets a sentence."""
    path = repacked(dynamics_fmu, tmp_path / "damaged.fmu", member)
    if content is not None:
        with zipfile.ZipFile(path, "a") as archive:
            archive.writestr(member, content)
    with pytest.raises(FmuError, match=r"(?s)does not instantiate: .*(has no compiled core|build the FMU anew)"):
        FmuClient(path)
    with FmuClient(dynamics_fmu) as fmu:
        fmu.step(0.1)


def test_platform_without_core(dynamics_fmu, tmp_path):
    path = repacked(dynamics_fmu, tmp_path / "elsewhere.fmu", "resources/core/")
    with pytest.raises(FmuError, match=r"GtmDynamics has no compiled core for this platform .*inside: none"):
        FmuClient(path)


BARE_HOST = """
import ctypes, json, sys
folder, identifier, guid = sys.argv[1:]
library = ctypes.CDLL(f"{folder}/binaries/linux64/{identifier}.so")
Logger = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_char_p, ctypes.c_int, ctypes.c_char_p, ctypes.c_char_p)
class Callbacks(ctypes.Structure):
    _fields_ = [("logger", Logger)] + [(name, ctypes.c_void_p) for name in ("allocate", "free", "finished", "host")]
callbacks = Callbacks(Logger(lambda *_: None))
library.fmi2Instantiate.restype = ctypes.c_void_p
resources = f"file://{folder}/resources".encode()
fmu = ctypes.c_void_p(library.fmi2Instantiate(b"bare", 1, guid.encode(), resources, ctypes.byref(callbacks), 0, 0))
real = ctypes.c_double
library.fmi2SetupExperiment(fmu, 0, real(0), real(0), 0, real(0))
library.fmi2EnterInitializationMode(fmu)
library.fmi2ExitInitializationMode(fmu)
status = library.fmi2DoStep(fmu, real(0), real(1), 0)
references, values = (ctypes.c_uint * 12)(*range(12)), (real * 12)()
library.fmi2GetReal(fmu, references, ctypes.c_size_t(12), values)
print(json.dumps([status, list(values), sorted(name.split(".")[0] for name in sys.modules)]))
"""


@pytest.mark.skipif(platform_folder() != "linux64", reason="the bare host names the Linux binary")
def test_host_without_any_package(dynamics_fmu, tmp_path):
    """A CPython without site-packages: the FMU brings all that it needs."""
    fmpy.extract(dynamics_fmu, tmp_path)
    command = [sys.executable, "-I", "-S", "-c", BARE_HOST, str(tmp_path), "GtmDynamics"]
    command.append(fmpy.read_model_description(dynamics_fmu).guid)
    run = subprocess.run(command, capture_output=True, text=True, check=True)
    status, values, modules = json.loads(run.stdout)
    assert status == 0
    assert {"numpy", "casadi", "fmpy"}.isdisjoint(modules)
    with FmuClient(dynamics_fmu) as fmu:
        fmu.step(1.0)
        np.testing.assert_array_equal(values, fmu.get(fmu.states))
    assert math.dist(values[:3], (49.96199, 0, 2.618397)) < 1e-4
