"""The native FMUs as files: descriptions, schemas, sources that compile elsewhere, reproducible builds."""

import errno
import os
import re
import shutil
import subprocess
import sys
import zipfile
from importlib.resources import files
from pathlib import Path

import fmpy
import numpy as np
import psutil
import pytest
from fmpy.validation import validate_fmu
from lxml import etree

from fmu_src import build
from fmu_src.description.dynamics_variables import dynamics_description
from fmu_src.packing import compiler, native_sources
from gtm_fmu import core
from gtm_fmu.airframe.names import CONTROLS, STATES
from gtm_fmu.errors import InputError

pytestmark = pytest.mark.slow

NAMES = {2: "GtmDynamicsNative", 3: "GtmDynamicsNative3"}


@pytest.fixture
def fmu(fmi, native_fmus) -> Path:
    return native_fmus[fmi]


@pytest.fixture
def description(fmu):
    return fmpy.read_model_description(fmu, validate=False)


def members(path: Path) -> dict[str, bytes]:
    with zipfile.ZipFile(path) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def test_fmpy_validation_is_clean(fmu):
    assert validate_fmu(str(fmu)) == []


def test_schemas(fmu, fmi):
    schemas = {"modelDescription.xml": "ModelDescription"}
    if fmi == 3:
        schemas["sources/buildDescription.xml"] = "BuildDescription"
        schemas["terminalsAndIcons/terminalsAndIcons.xml"] = "TerminalsAndIcons"
    content = members(fmu)
    assert [name for name in content if name.endswith(".xml")] == sorted(schemas)
    for name, schema in schemas.items():
        path = files("fmpy").joinpath("schema", f"fmi{fmi}", f"fmi{fmi}{schema}.xsd")
        etree.XMLSchema(etree.parse(str(path))).assertValid(etree.fromstring(content[name]))


def test_kind_and_capabilities(description, fmi):
    assert description.fmiVersion == f"{fmi}.0"
    for interface in (description.coSimulation, description.modelExchange):
        assert interface.modelIdentifier == NAMES[fmi]
        assert not interface.needsExecutionTool
        assert interface.canGetAndSetFMUstate
        assert interface.canSerializeFMUstate
        assert interface.providesDirectionalDerivative or fmi == 3  # FMPy does not read FMI 3.0's attribute
    assert description.coSimulation.canHandleVariableCommunicationStepSize
    assert description.numberOfContinuousStates == len(STATES)
    assert description.numberOfEventIndicators == 0


def test_partial_derivatives_are_declared_in_fmi3(native_fmus):
    root = etree.fromstring(members(native_fmus[3])["modelDescription.xml"])
    for kind in ("ModelExchange", "CoSimulation"):
        assert root.find(kind).get("providesDirectionalDerivatives") == "true"
        assert root.find(kind).get("providesAdjointDerivatives") == "true"


def test_variables_are_those_of_the_python_fmu(description, dynamics_fmu):
    """By value reference; the native one has more."""
    other = fmpy.read_model_description(dynamics_fmu).modelVariables
    own = description.modelVariables
    starts = [f"start.{name}" for name in STATES]
    assert [variable.name for variable in own[len(other) :]] == ["solver.tolerance", *starts, "time"]
    attributes = ("name", "valueReference", "causality", "variability", "initial", "unit", "displayUnit", "description")
    for mine, its in zip(own, other, strict=False):
        for attribute in attributes:
            assert getattr(mine, attribute) == getattr(its, attribute)
        for attribute in ("start", "min", "max", "nominal"):
            numbers = [getattr(variable, attribute) for variable in (mine, its)]
            assert (None in numbers and numbers[0] is numbers[1]) or float(numbers[0]) == float(numbers[1])


def test_dependencies_are_those_of_the_core(description):
    rng = np.random.default_rng(1)
    x = rng.uniform(-1, 1, (300, 12)) * (60, 60, 40, 1, 1, 1, 0.6, 3, 15000, 1, 1, 3) + np.eye(12)[0] * 150
    u = rng.uniform(-1, 1, (300, 4)) * (25, 18, 28, 45) + (0, 0, 0, 50)
    knowns = [f"state.{name}" for name in STATES] + [f"control.{name}" for name in CONTROLS]
    declared = {u.variable.name: {known.name for known in u.dependencies} for u in description.outputs}
    derivatives = {u.variable.name: {known.name for known in u.dependencies} for u in description.derivatives}
    initial = {u.variable.name: {known.name for known in u.dependencies} for u in description.initialUnknowns}
    groups = dynamics_description().groups
    for group, (_, slopes) in (("derivatives", core.jacobian(x, u)), ("outputs", core.outputs_jacobian(x, u))):
        for variable, row in zip(groups[group], (slopes != 0).any(axis=0), strict=True):
            used = {known for known, is_used in zip(knowns, row, strict=True) if is_used}
            assert used <= declared[variable.name]
            assert used <= derivatives.get(variable.name, declared[variable.name])
            limits = {
                f"{c.replace('control', 'limits')}.{end}" for c in used & set(knowns[12:]) for end in ("lower", "upper")
            }
            assert used | limits <= initial[variable.name]


class TestArchive:
    def test_equal_sources_give_equal_bytes(self, fmu, fmi, tmp_path, monkeypatch):
        monkeypatch.setattr(compiler, "_OBJECTS", {})
        assert build({2: "dynamics-native", 3: "dynamics-native3"}[fmi], tmp_path).read_bytes() == fmu.read_bytes()

    def test_nothing_of_this_machine_is_inside(self, fmu):
        for name, content in members(fmu).items():
            for place in (str(Path(__file__).parents[2]), str(Path.home()) + "/", "/tmp/gtm_fmu_"):
                assert place.encode() not in content, name

    def test_contents(self, fmu, fmi, description):
        content = members(fmu)
        page = content["documentation/index.html"].decode()
        for variable in description.modelVariables:
            assert f"<code>{variable.name}</code>" in page
        assert "compiled C" in page
        assert "needsExecutionTool" not in page
        assert b"Apache License" in content["documentation/licenses/gtm-fmu-LICENSE.txt"]
        assert b"2-Clause BSD License" in content["documentation/licenses/FMI-headers-LICENSE.txt"]
        icon = "model.png" if fmi == 2 else "terminalsAndIcons/icon.png"
        assert content[icon].startswith(b"\x89PNG")
        assert len([name for name in content if name.startswith("binaries/")]) == 1

    def test_libraries_that_a_binary_needs(self, fmu, tmp_path):
        if shutil.which("readelf") is None:
            pytest.skip("readelf is not installed")
        fmpy.extract(fmu, tmp_path)
        (library,) = (tmp_path / "binaries").rglob("*.so")
        read = subprocess.run(["readelf", "-d", library], capture_output=True, text=True, check=True).stdout
        assert set(re.findall(r"NEEDED.*\[(.*)\]", read)) <= {"libc.so.6", "libm.so.6"}
        assert "RPATH" not in read
        assert "RUNPATH" not in read


def test_fmpy_compiles_the_sources(fmu, fmi, description, tmp_path):
    """The binary from the sources alone, built with other flags, steps as ours does."""
    if shutil.which("cmake") is None and shutil.which(str(Path(sys.executable).with_name("cmake"))) is None:
        pytest.skip("cmake is not installed")
    bare = tmp_path / fmu.name
    with zipfile.ZipFile(bare, "w") as archive:
        for name, content in members(fmu).items():
            if not name.startswith("binaries/"):
                archive.writestr(name, content)
    run = subprocess.run(
        [sys.executable, "-m", "fmpy", "compile", bare],
        capture_output=True,
        text=True,
        env={"PATH": f"{Path(sys.executable).parent}:/usr/bin:/bin"},
    )
    assert run.returncode == 0, run.stdout + run.stderr
    results = [
        fmpy.simulate_fmu(str(path), stop_time=1.0, output_interval=0.1, start_values={"control.elevator": 0.05})
        for path in (fmu, bare)
    ]
    for name in results[0].dtype.names:
        np.testing.assert_allclose(results[1][name], results[0][name], rtol=1e-12, atol=1e-12)


class TestBadInput:
    def test_no_compiler(self, tmp_path, monkeypatch):
        monkeypatch.setenv("CC", "no-such-compiler")
        with pytest.raises(InputError, match=r"needs a C compiler .* the extra `gtm-fmu\[cross\]`"):
            build("dynamics-native", tmp_path)
        assert list(tmp_path.iterdir()) == []

    def test_compiler_that_fails(self, tmp_path, monkeypatch):
        monkeypatch.setenv("CC", "cc -no-such-option")
        with pytest.raises(InputError, match=r"The compiler cc -no-such-option failed \(.*error"):
            build("dynamics-native", tmp_path)

    def test_compiler_that_hangs(self, tmp_path, monkeypatch):
        """It is ended with what it has started."""
        script = tmp_path / "hangs"
        script.write_text(f"#!/bin/sh\necho $$ >> {tmp_path}/started\nsleep 1000\nexit 0\n")
        script.chmod(0o755)
        monkeypatch.setenv("CC", str(script))
        monkeypatch.setattr(compiler, "LONGEST_S", 0.5)
        monkeypatch.setattr(compiler.os, "cpu_count", lambda: 2)
        monkeypatch.setattr(compiler, "_OBJECTS", {})
        with pytest.raises(InputError, match=r"hangs had not finished after 0.5 s and was stopped: try another one"):
            build("thrust-map-native", tmp_path / "fmu")
        started = [int(line) for line in (tmp_path / "started").read_text().split()]
        assert started
        assert not [number for number in started if psutil.pid_exists(number)]
        assert not [p for p in psutil.process_iter(["cmdline"]) if p.info["cmdline"] == ["sleep", "1000"]]

    @pytest.mark.parametrize("name", ["dynamics-native", "envelope"])
    def test_full_temporary_folder(self, name, tmp_path, monkeypatch):
        def is_full(self, content):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

        monkeypatch.setattr(Path, "write_bytes", is_full)
        with pytest.raises(InputError, match=r"There is no room in the temporary folder '.*TMPDIR"):
            build(name, tmp_path)

    def test_no_generated_core(self, tmp_path, monkeypatch):
        monkeypatch.setattr(native_sources, "CORE", tmp_path)
        with pytest.raises(InputError, match="install the package first"):
            build("dynamics-native", tmp_path)

    def test_unknown_platform(self, tmp_path, monkeypatch):
        monkeypatch.setattr(compiler, "platform_folder", lambda: "riscv64-linux")
        with pytest.raises(InputError, match="FMUs are not built for riscv64-linux: build on one of"):
            build("dynamics-native", tmp_path)

    def test_networks(self, tmp_path):
        with pytest.raises(InputError, match="uses none"):
            build("dynamics-native", tmp_path, networks=["net.json"])

    def test_all_platforms_without_zig(self, tmp_path, monkeypatch):
        monkeypatch.setattr(compiler, "find_spec", lambda name: None)
        with pytest.raises(InputError, match=r"install the extra `gtm-fmu\[cross\]`"):
            build("dynamics-native", tmp_path, all_platforms=True)

    def test_all_platforms_of_a_python_fmu(self, tmp_path):
        with pytest.raises(InputError, match="runs in Python"):
            build("dynamics", tmp_path, all_platforms=True)
