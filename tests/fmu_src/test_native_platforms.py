"""One FMU for all platforms: built by Zig, run where something here can run it, equal to this platform's own."""

import logging
import os
import re
import shutil
import subprocess
import sys
import zipfile
from importlib.util import find_spec
from pathlib import Path

import fmpy
import numpy as np
import pytest

from fmu_src import build
from fmu_src.packing import compiler
from fmu_src.packing.native_sources import standard_headers
from gtm_fmu.airframe.names import FAILURE
from gtm_fmu.errors import InputError
from tests.fmu_src.native_flight import NU, U, X

pytestmark = pytest.mark.slow

HOST = Path(__file__).with_name("fmu_host.c")
HAS_ZIG = find_spec("ziglang") is not None
needs_zig = pytest.mark.skipif(not HAS_ZIG, reason="ziglang (the extra `cross`) is not installed")
STEPS = 100
FLIGHT = [
    command
    for n in range(STEPS)
    for command in (
        *(f"s {U[k]} {0.05 * (k + 1) * ((n // 10 + k) % 3 - 1) + 0.5 * (k == 3)!r}" for k in range(NU)),
        f"d {n * 0.02!r} 0.02",
    )
] + [f"g {place}" for place in X]
CONDITIONS = ((3000.0, 0.0, -0.5, 0.5), (8000.0, -0.08, 0.2, 0.2), (500.0, 0.03, -0.1, 0.3))  # SI
ENVELOPES = [
    command
    for condition in CONDITIONS
    for command in (*(f"s {k} {value!r}" for k, value in enumerate(condition)), "g 5", "g 6")
]
FAILURES = [*ENVELOPES, f"s {14 + FAILURE.index('damage_case')} 5", "g 5", "g 6"]
MANOEUVRES = [
    *(f"s {place} {value!r}" for place, value in enumerate((3000.0, -0.05, 45.0, 0.08))),
    *(f"g {place}" for place in range(34, 61)),
]
"""What the host is told: two seconds with moving controls, then the states; V_min and V_max of some conditions, and
without the left elevator; a manoeuvre, its margins, its trim and the ends of its turns.
"""


def zig(folder: Path, target: str, output: str, *words: str | Path) -> None:
    command = [sys.executable, "-m", "ziglang", "cc", "-target", target, "-O2", *words, "-o", output]
    subprocess.run(command, cwd=folder, check=True, capture_output=True)


@pytest.fixture(scope="module")
def all_platforms(tmp_path_factory) -> Path:
    return build("dynamics-native", tmp_path_factory.mktemp("all"), all_platforms=True)


@pytest.fixture(scope="module")
def unpacked(all_platforms, tmp_path_factory) -> Path:
    return Path(fmpy.extract(all_platforms, tmp_path_factory.mktemp("unpacked")))


@pytest.fixture(scope="module")
def hosts(tmp_path_factory) -> Path:
    """A folder with the host's source, the headers, and the host of this platform."""
    if shutil.which("cc") is None or sys.platform != "linux":
        pytest.skip("the host is built with cc on Linux")
    folder = tmp_path_factory.mktemp("hosts")
    for name, content in (standard_headers(2) | {HOST.name: HOST.read_bytes()}).items():
        (folder / name).write_bytes(content)
    subprocess.run(["cc", "-O2", "-I.", HOST.name, "-o", "host", "-ldl"], cwd=folder, check=True)
    return folder


def answers(command: list, library: Path, orders: list[str], **environment) -> np.ndarray:
    """What the host prints."""
    token = fmpy.read_model_description(library.parents[2], validate=False).guid
    run = subprocess.run(
        [*command, library, token],
        input="\n".join(orders),
        capture_output=True,
        text=True,
        timeout=300,
        env=os.environ | environment,
    )
    assert run.returncode == 0, run.stderr
    return np.array([float(line) for line in run.stdout.split()])


@pytest.fixture(scope="module")
def own_answers(built, hosts, tmp_path_factory):
    """What a native FMU with this platform's own library answers, in a host without Python."""

    def answered(name: str, orders: list[str], networks=()) -> np.ndarray:
        folder = Path(fmpy.extract(built(name, networks), tmp_path_factory.mktemp("own")))
        (library,) = (folder / "binaries").rglob("*.so")
        return answers([hosts / "host"], library, orders)

    return answered


@pytest.fixture(scope="module")
def expected(own_answers) -> np.ndarray:
    return own_answers("dynamics-native", FLIGHT)


@pytest.fixture(scope="module")
def expected_envelopes(own_answers) -> np.ndarray:
    return own_answers("envelope-native", FAILURES)


@pytest.fixture(scope="module")
def expected_manoeuvres(own_answers) -> np.ndarray:
    return own_answers("manoeuvre-native", MANOEUVRES)


@pytest.fixture(scope="module")
def expected_surrogates(own_answers, networks) -> np.ndarray:
    return own_answers("surrogate-native", ENVELOPES, networks[2])


@pytest.fixture(scope="module")
def expected_by_map(own_answers) -> np.ndarray:
    return own_answers("thrust-map-native", ENVELOPES)


def built_for(target: str, name: str, networks: list[Path], folder: Path, monkeypatch) -> Path:
    """The library of an FMU that is built for one platform only."""
    monkeypatch.setattr(compiler, "PLATFORMS", [p for p in compiler.PLATFORMS if p.target.startswith(target)])
    built = build(name, folder, networks, all_platforms=True)
    (library,) = Path(fmpy.extract(built, folder / name), "binaries").glob("*/*")
    return library


def test_host_without_python(expected, expected_envelopes):
    assert np.isfinite(expected).all()
    assert abs(expected[9]) > 0.01  # rad: the controls have moved the aircraft
    v_min, v_max = expected_envelopes.reshape(-1, 2).T
    assert v_max[-1] < v_max[-2]  # of the last condition, without the left elevator
    assert (v_min > 0).all()
    assert (v_min < v_max).all()


@needs_zig
class TestAllPlatforms:
    def test_a_binary_for_each(self, all_platforms):
        with zipfile.ZipFile(all_platforms) as archive:
            heads = {
                name.split("/")[1]: archive.read(name)[:20]
                for name in archive.namelist()
                if name.startswith("binaries/")
            }
        kinds = {
            "linux64": (b"\x7fELF", b"\x3e"),
            "aarch64-linux": (b"\x7fELF", b"\xb7"),
            "win64": (b"MZ", b""),
            "darwin64": (b"\xcf\xfa\xed\xfe\x07\x00\x00\x01", b""),
            "aarch64-darwin": (b"\xcf\xfa\xed\xfe\x0c\x00\x00\x01", b""),
        }
        assert heads.keys() == kinds.keys()
        for platform, (magic, machine) in kinds.items():
            assert heads[platform].startswith(magic)
            assert heads[platform][18:19] == machine or not machine

    def test_equal_sources_give_equal_bytes(self, all_platforms, tmp_path):
        assert build("dynamics-native", tmp_path, all_platforms=True).read_bytes() == all_platforms.read_bytes()

    def test_linux(self, unpacked, hosts, expected):
        library = unpacked / "binaries" / "linux64" / "GtmDynamicsNative.so"
        np.testing.assert_allclose(answers([hosts / "host"], library, FLIGHT), expected, rtol=1e-12, atol=1e-12)

    def test_old_glibc(self, unpacked):
        if shutil.which("readelf") is None:
            pytest.skip("readelf is not installed")
        library = unpacked / "binaries" / "linux64" / "GtmDynamicsNative.so"
        symbols = subprocess.run(["readelf", "-V", library], capture_output=True, text=True, check=True).stdout
        versions = {word.removeprefix("GLIBC_") for word in symbols.split() if word.startswith("GLIBC_")}
        assert versions
        assert all(tuple(map(int, version.split("."))) <= (2, 17) for version in versions)

    def test_windows_has_all_that_it_asks_for(self, unpacked):
        library = unpacked / "binaries" / "win64" / "GtmDynamicsNative.dll"
        named = set(re.findall(rb"[\w.-]+\.dll(?=\0)", library.read_bytes(), re.IGNORECASE))
        assert named - {library.name.encode()} == {b"ucrtbase.dll"}

    def test_windows_under_wine(self, unpacked, hosts, expected, expected_surrogates, networks, tmp_path, monkeypatch):
        names = ("wine64", "wine", "/usr/lib/wine/wine64")
        wine = next((path for name in names if (path := shutil.which(name))), None)
        if wine is None:
            pytest.skip("wine64 is not installed")
        objects = {"host.o": HOST, "windows.o": Path(compiler.__file__).with_name("windows.c")}
        for name, source in objects.items():
            zig(hosts, "x86_64-windows-gnu", name, "-I.", "-c", source)
        linked = ("-nostdlib", "-rtlib=compiler-rt", "-Wl,-e,start", *objects, "-lucrtbase", "-lkernel32")
        zig(hosts, "x86_64-windows-gnu", "host.exe", *linked)
        library = unpacked / "binaries" / "win64" / "GtmDynamicsNative.dll"
        environment = {
            "WINEPREFIX": str(tmp_path / "wine"),
            "WINEDEBUG": "-all",
            "WINEDLLOVERRIDES": "mscoree=;mshtml=",
        }
        got = answers([wine, hosts / "host.exe"], library, FLIGHT, **environment)
        np.testing.assert_allclose(got, expected, rtol=1e-12, atol=1e-12)
        library = built_for("x86_64-windows", "surrogate-native", networks[2], tmp_path, monkeypatch)
        got = answers([wine, hosts / "host.exe"], library, ENVELOPES, **environment)
        np.testing.assert_allclose(got, expected_surrogates, rtol=1e-12)

    def test_aarch64_under_qemu(
        self,
        unpacked,
        hosts,
        expected,
        expected_envelopes,
        expected_manoeuvres,
        expected_surrogates,
        expected_by_map,
        networks,
        tmp_path,
        monkeypatch,
    ):
        emulator = next((p for n in ("qemu-aarch64", "qemu-aarch64-static") if (p := shutil.which(n))), None)
        root = Path("/usr/aarch64-linux-gnu")
        if emulator is None or not root.exists():
            pytest.skip("qemu-user or libc6-arm64-cross is not installed")
        zig(hosts, "aarch64-linux-gnu.2.34", "host.aarch64", "-I.", HOST.name)
        host, place = [emulator, "-L", root, hosts / "host.aarch64"], Path("binaries", "aarch64-linux")
        got = answers(host, unpacked / place / "GtmDynamicsNative.so", FLIGHT)
        np.testing.assert_allclose(got, expected, rtol=1e-12, atol=1e-12)
        others = (
            ("envelope-native", [], FAILURES, expected_envelopes),
            ("manoeuvre-native", [], MANOEUVRES, expected_manoeuvres),
            ("surrogate-native", networks[2], ENVELOPES, expected_surrogates),
            ("thrust-map-native", [], ENVELOPES, expected_by_map),
        )
        for name, files, orders, values in others:
            library = built_for("aarch64-linux", name, files, tmp_path, monkeypatch)
            np.testing.assert_allclose(answers(host, library, orders), values, rtol=1e-12, atol=1e-14)


class TestPlatformThatCannotBeBuilt:
    """The compiler is replaced by one that knows some targets only."""

    @pytest.fixture
    def failing(self, monkeypatch):
        def compile_some(command, platform, name, sources):
            if "linux" not in platform.target:
                raise InputError("The compiler zig failed (no such target).")
            return platform.target.encode()

        monkeypatch.setattr(compiler, "find_spec", lambda name: True)
        monkeypatch.setattr(compiler, "_compile", compile_some)
        return compile_some

    def test_the_rest_is_built(self, failing, tmp_path, caplog):
        with caplog.at_level(logging.WARNING):
            path = build("dynamics-native", tmp_path, all_platforms=True)
        with zipfile.ZipFile(path) as archive:
            built = [name.split("/")[1] for name in archive.namelist() if name.startswith("binaries/")]
        assert built == ["aarch64-linux", "linux64"]
        texts = [record.getMessage() for record in caplog.records]
        assert "x86_64-windows-gnu is left out: The compiler zig failed (no such target)." in texts
        assert "x86_64-linux-musl is left out: FMI 2.0 has no name for it." in texts

    def test_none(self, monkeypatch, tmp_path):
        def fail(*_):
            raise InputError("The compiler zig failed (no such target).")

        monkeypatch.setattr(compiler, "find_spec", lambda name: True)
        monkeypatch.setattr(compiler, "_compile", fail)
        with pytest.raises(InputError, match=r"No platform could be built, the last one because: The compiler zig"):
            build("dynamics-native", tmp_path, all_platforms=True)
        assert list(tmp_path.iterdir()) == []
