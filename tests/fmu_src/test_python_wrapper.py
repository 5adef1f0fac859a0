"""The binary of the FMUs in Python against what importers and users give it: it refuses, and its host lives on."""

import ctypes
import gc
import json
import math
import os
import shutil
import signal
import subprocess
import sys
import sysconfig
from ctypes import byref, c_char_p, c_double, c_int, c_size_t, c_uint, c_void_p
from pathlib import Path
from urllib.parse import quote

import fmpy
import numpy as np
import pytest

from gtm_fmu.aircraft.client import FmuClient

MODELS = ("dynamics", "aircraft", "envelope", "surrogate")
OK, DISCARD, ERROR = 0, 2, 3
LAST_SUCCESSFUL_TIME, TERMINATED = 2, 3
"""Of fmi2StatusKind."""
pytestmark = [pytest.mark.skipif(sys.platform == "win32", reason="there the binary is pythonfmu's"), pytest.mark.slow]

Logger = ctypes.CFUNCTYPE(None, c_void_p, c_char_p, c_int, c_char_p, c_char_p)


class Callbacks(ctypes.Structure):
    _fields_ = (("logger", Logger), *((name, c_void_p) for name in ("allocate", "free", "finished", "environment")))


class Host:
    """The FMI functions of an unpacked FMU as C calls them; ``instance`` is None where there is none."""

    def __init__(self, folder: Path, uri: bytes | None = None, guid: bytes | None = None, name=b"one", kind=1):
        self.description = description = fmpy.read_model_description(str(folder))
        self.messages: list[str] = []
        self._callbacks = Callbacks(Logger(lambda *given: self.messages.append(given[-1].decode())))
        (binary,) = (folder / "binaries").glob("*/*.so")
        self.library = ctypes.CDLL(str(binary))
        self.library.fmi2Instantiate.restype = c_void_p
        guid = description.guid.encode() if guid is None else guid
        address = self.library.fmi2Instantiate(name, kind, guid, uri, byref(self._callbacks), 0, 1)
        self.instance = c_void_p(address) if address else None
        self.variables = description.modelVariables

    def call(self, function: str, *arguments) -> int:
        return getattr(self.library, f"fmi2{function}")(self.instance, *arguments)

    def initialize(self) -> "Host":
        assert self.call("SetupExperiment", 0, c_double(0), c_double(0), 0, c_double(0)) == OK
        assert self.call("EnterInitializationMode") == OK
        assert self.call("ExitInitializationMode") == OK
        return self

    def step(self, time: float, duration: float) -> int:
        return self.call("DoStep", c_double(time), c_double(duration), 1)

    def access(self, function: str, references, values) -> int:
        references = (c_uint * len(references))(*references)
        return self.call(function, references, c_size_t(len(references)), values)

    def reals(self) -> list[float]:
        places = [variable.valueReference for variable in self.variables if variable.type == "Real"]
        values = (c_double * len(places))()
        assert self.access("GetReal", places, values) == OK
        return list(values)

    def state(self) -> c_void_p:
        state = c_void_p()
        assert self.call("GetFMUstate", byref(state)) == OK
        return state

    def bytes(self, state: c_void_p) -> bytes:
        size = c_size_t()
        assert self.call("SerializedFMUstateSize", state, byref(size)) == OK
        content = ctypes.create_string_buffer(size.value)
        assert self.call("SerializeFMUstate", state, content, size) == OK
        return content.raw

    def from_bytes(self, content: bytes) -> tuple[int, c_void_p]:
        state = c_void_p()
        return self.call("DeSerializeFMUstate", content, c_size_t(len(content)), byref(state)), state

    def free(self) -> None:
        if self.instance:
            self.library.fmi2FreeInstance(self.instance)
            self.instance = None


@pytest.fixture(scope="module")
def folders(built, surrogate_fmu, tmp_path_factory) -> dict[str, Path]:
    """The four FMUs, unpacked."""
    place = tmp_path_factory.mktemp("unpacked")
    fmus = {name: surrogate_fmu if name == "surrogate" else built(name) for name in MODELS}
    return {name: Path(fmpy.extract(path, place / name)) for name, path in fmus.items()}


def uri(folder: Path) -> bytes:
    return (folder / "resources").as_uri().encode()


@pytest.fixture(params=MODELS)
def host(request, folders):
    host = Host(folders[request.param], uri(folders[request.param])).initialize()
    yield host
    host.free()


NAMES = ("two words", "Übung", "日本", "a#b", "a+b", "100%", "a%41", "{x}", "it's", "a?b", 'say "so"', "a;b&c=d")
FORMS = {
    "standard": lambda path: f"file://{quote(path)}",
    "as Java writes it": lambda path: f"file:{quote(path)}",
    "with a host": lambda path: f"file://localhost{quote(path)}",
    "in capitals": lambda path: f"FILE://LOCALHOST{quote(path)}/",
    "not encoded": lambda path: f"file://{path}",
    "without a scheme": lambda path: path,
}


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("form", FORMS.values(), ids=FORMS)
def test_folders_by_any_name(folders, tmp_path, name, form):
    (tmp_path / name).symlink_to(folders["dynamics"])
    host = Host(folders["dynamics"], form(str(tmp_path / name / "resources")).encode())
    assert host.instance, host.messages
    host.free()


LOCATIONS = (None, b"", b"file:", b"file://", b"http://localhost/resources", b"file://elsewhere/tmp", b"resources")
LOCATIONS += (b"file:///no/such/folder", b"file:///%00", b"file:///%zz", b"file:///\xff", b"file:///" + b"a" * 10000)


@pytest.mark.parametrize("location", LOCATIONS, ids=range(len(LOCATIONS)))
def test_no_instance_without_resources(folders, location):
    host = Host(folders["dynamics"], location)
    assert host.instance is None
    (message,) = host.messages
    assert message.startswith(("There is no location", "The resources are at no", "The folder of the resources does"))


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        ({"guid": b"{no}"}, "The GUID is not that of this FMU"),
        ({"name": None}, "An instance needs a name"),
        ({"kind": 0}, "The FMU is for co-simulation only"),
    ],
)
def test_no_instance_of_another_kind(folders, given, sentence):
    host = Host(folders["dynamics"], uri(folders["dynamics"]), **given)
    assert host.instance is None
    assert host.messages[0].startswith(sentence)


def test_null_pointers(folders):
    host = Host(folders["dynamics"], uri(folders["dynamics"])).initialize()
    for function in ("GetReal", "SetReal", "GetBoolean", "GetInteger", "SetString"):
        assert host.access(function, [0], None) == ERROR
    for function in ("GetFMUstate", "FreeFMUstate", "SetFMUstate"):
        assert host.call(function, None) == ERROR
    assert host.call("DeSerializeFMUstate", None, c_size_t(3), byref(c_void_p())) == ERROR
    assert host.step(0, 0.1) == OK
    host.free()
    assert host.library.fmi2DoStep(None, c_double(0), c_double(0), 1) == ERROR
    host.library.fmi2FreeInstance(None)


def test_value_references(host):
    """4294967295 once was the last variable, from behind."""
    before, number = host.reals(), len(host.variables)
    types = {"Real": c_double, "Boolean": c_int, "Integer": c_int, "String": c_char_p}
    kinds = {variable.valueReference: variable.type for variable in host.variables}
    for reference in (*range(number), number, 2**31 - 1, 2**31, 2**32 - number, 2**32 - 1):
        for kind, c_type in types.items():
            if kinds.get(reference) != kind:
                assert host.access(f"Get{kind}", [reference], (c_type * 1)()) == ERROR
                assert host.access(f"Set{kind}", [0, reference], (c_type * 2)()) == ERROR
                named = {"Real": "real", "Integer": "enumeration"}.get(kind, kind)
                assert f"There is no {named} variable" in host.messages[-1]
    assert host.reals() == before
    assert host.step(0, 0.01) == OK


def test_outputs_are_not_set(host):
    before = host.reals()
    computed = [v.valueReference for v in host.variables if v.type == "Real" and v.initial == "calculated"]
    assert host.access("SetReal", computed, (c_double * len(computed))()) == ERROR
    assert host.reals() == before


def test_foreign_states(host, folders):
    """Bytes that are not ours, ours with a byte changed, cut or longer: refused, and nothing is changed."""
    assert host.step(0, 0.01) == OK
    before, own = host.reals(), host.bytes(host.state())
    assert host.from_bytes(own)[0] == OK
    rng = np.random.default_rng(28)
    foreign = [b"", b"{}", b"null", b"[]", b'"values"', b"1" + b"0" * 400, b"\xff", own[:-1], own[1:], own + b" "]
    foreign += [own[:40], json.dumps({"values": [math.nan] * len(host.variables), "refused": {}}).encode()]
    for name, folder in folders.items():
        other = Host(folder, uri(folder)).initialize()
        if host.variables[0].name != other.variables[0].name or len(host.variables) != len(other.variables):
            foreign.append(other.bytes(other.state()))
            state = other.state()
            assert host.call("SetFMUstate", state) == ERROR, name
            assert host.call("FreeFMUstate", byref(state)) == ERROR
        other.free()
    for place in rng.integers(len(own), size=300):
        changed = bytearray(own)
        changed[place] ^= 1 << rng.integers(8)
        foreign.append(bytes(changed))
    for content in foreign:
        status, state = host.from_bytes(content)
        assert (status, state.value) == (ERROR, None)
        assert host.messages[-1] == "The bytes are no state of this FMU."
    assert host.reals() == before
    assert host.step(0.01, 0.01) == OK


def test_own_state_comes_back(host):
    assert host.step(0, 0.01) == OK
    before, state = host.reals(), host.state()
    status, copy = host.from_bytes(host.bytes(state))
    assert status == OK
    assert host.step(0.01, 0.5) == OK
    for saved in (state, copy):
        assert host.call("SetFMUstate", saved) == OK
        assert host.reals() == before
        assert host.call("FreeFMUstate", byref(saved)) == OK
        assert saved.value is None


def test_a_refused_step_asks_to_stop(folders):
    """FMI 2.0.5, 4.2.2: Discard alone would have an importer try for ever."""
    host = Host(folders["dynamics"], uri(folders["dynamics"])).initialize()
    stopped, time = c_int(), c_double()
    assert host.step(0, 0.5) == OK
    assert host.call("GetBooleanStatus", TERMINATED, byref(stopped)) == OK
    assert not stopped.value
    assert host.step(0.5, -1.0) == DISCARD
    assert host.call("GetBooleanStatus", TERMINATED, byref(stopped)) == OK
    assert host.call("GetRealStatus", LAST_SUCCESSFUL_TIME, byref(time)) == OK
    assert (stopped.value, time.value) == (1, 0.5)
    host.free()


def test_declared_log_categories(host):
    declared = [category.name for category in host.description.logCategories]
    assert "logAll" in declared
    for category in declared:
        assert host.call("SetDebugLogging", 1, c_size_t(1), (c_char_p * 1)(category.encode())) == OK
    assert host.call("SetDebugLogging", 1, c_size_t(1), (c_char_p * 1)(b"logEverything")) == ERROR


def test_only_named_categories_are_logged(folders):
    host = Host(folders["dynamics"], uri(folders["dynamics"])).initialize()
    for category, count in ((b"logStatusWarning", 0), (b"logStatusDiscard", 1), (b"logAll", 1)):
        host.messages.clear()
        assert host.call("SetDebugLogging", 1, c_size_t(1), (c_char_p * 1)(category)) == OK
        assert host.step(0, -1.0) == DISCARD
        assert len(host.messages) == count
    host.free()


HOST = """
import atexit, ctypes, sys, threading, time
from fmpy.fmi2 import FMU2Slave
folder, guid, end = sys.argv[1:]
fmu = FMU2Slave(guid=guid, unzipDirectory=folder, modelIdentifier="GtmDynamics", instanceName="one")
fmu.instantiate()
fmu.setupExperiment()
fmu.enterInitializationMode()
fmu.exitInitializationMode()
fmu.doStep(0, 0.1)
class Holder:
    def __del__(self, free=fmu.dll.fmi2FreeInstance, one=fmu.component):
        free(one)
def steps():
    while True:
        fmu.doStep(0, 0.01)
if end == "freed at exit":
    atexit.register(fmu.freeInstance)
if end == "freed by the last collection":
    sys.modules["fmpy"].holder = Holder()
if end == "stepping in a thread":
    threading.Thread(target=steps, daemon=True).start()
    time.sleep(0.1)
"""
ENDS = ("not freed", "freed at exit", "freed by the last collection", "stepping in a thread")


@pytest.mark.parametrize("end", ENDS)
def test_ends_with_its_host(folders, end):
    folder = folders["dynamics"]
    guid = fmpy.read_model_description(str(folder)).guid
    for _ in range(2):
        run = subprocess.run([sys.executable, "-c", HOST, folder, guid, end], capture_output=True, text=True)
        assert (run.returncode, run.stderr) == (0, "")


INTERRUPTED = """
import os, signal, sys
from gtm_fmu import FmuClient
signal.signal(signal.SIGINT, signal.default_int_handler)
with FmuClient(sys.argv[1]) as fmu:
    library, component = fmu.instance.dll, fmu._component
    fmu.step(0.01)
    caught = 0
    for _ in range(30):
        signal.setitimer(signal.ITIMER_REAL, 0.003)
        signal.signal(signal.SIGALRM, lambda *_: signal.raise_signal(signal.SIGINT))
        try:
            while True:
                library.fmi2DoStep(component, 0.0, 0.01, 0)
        except KeyboardInterrupt:
            caught += 1
    fmu.reset()
    fmu.step(0.1)
    print(caught)
"""


def test_control_c_inside_a_call_is_the_hosts(built):
    command = [sys.executable, "-c", INTERRUPTED, built("dynamics")]
    run = subprocess.run(command, capture_output=True, text=True, timeout=60)
    assert (run.returncode, run.stdout, run.stderr) == (0, "30\n", "")


@pytest.fixture(scope="module")
def command(folders, tmp_path_factory):
    if shutil.which("cc") is None:
        pytest.skip("there is no C compiler")
    folder, program = folders["dynamics"], tmp_path_factory.mktemp("host") / "host"
    headers = Path(fmpy.__file__).with_name("c-code")
    source = Path(__file__).with_name("fmu_host.c")
    subprocess.run(["cc", source, f"-I{headers}", "-o", program, "-ldl"], check=True)
    (binary,) = (folder / "binaries").glob("*/*.so")
    return [program, binary, fmpy.read_model_description(str(folder)).guid, uri(folder)]


@pytest.fixture(scope="module")
def environment():
    libraries = Path(sysconfig.get_config_var("LIBDIR") or "")
    if not (libraries / (sysconfig.get_config_var("INSTSONAME") or "none")).is_file():
        pytest.skip("this Python has no shared library")
    return os.environ | {"LD_LIBRARY_PATH": str(libraries), "PYTHONHOME": sys.base_prefix}


class TestHostInC:
    """A host that brings no Python: the FMU finds that of the system."""

    def test_flies_and_ends(self, command, environment, built):
        with FmuClient(built("dynamics")) as fmu:
            fmu.set(["state.u"], [51.0])
            fmu.step(1.0)
            expected = fmu.get(["state.u"])[0]
        for end in ("", "l"):
            given = f"s 0 51\nd 0 1\ng 0\n{end}"
            run = subprocess.run(command, input=given, capture_output=True, text=True, env=environment)
            assert (run.returncode, float(run.stdout), run.stderr) == (0, expected, "")

    def test_control_c_ends_it(self, command, environment):
        """Python's own handler would only remember it, while the host waits for what to do next."""
        with subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            env=environment,
            preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),  # a job in the background ignores it
        ) as running:
            running.stdin.write("g 0\n")
            running.stdin.flush()
            running.stdout.readline()
            running.send_signal(signal.SIGINT)
            assert running.wait(timeout=30) == -signal.SIGINT


@pytest.mark.skipif(not Path("/proc/self/maps").exists(), reason="the system does not tell what is mapped")
def test_a_client_opened_again_and_again_keeps_nothing(built):
    """Once 0.145 MB of memory an opening, and the files of each on the disk until the process ended."""

    def opened(count: int) -> tuple[int, int]:
        for _ in range(count):
            with FmuClient(built("dynamics")) as fmu:
                fmu.step(0.01)
        gc.collect()
        pages = int(Path("/proc/self/statm").read_text().split()[1])
        gone = {line.split()[5] for line in Path("/proc/self/maps").read_text().splitlines() if "(deleted)" in line}
        return pages * os.sysconf("SC_PAGE_SIZE"), len([name for name in gone if "gtm_fmu_" in name])

    before, files = opened(40)
    after, files_after = opened(40)
    assert after - before < 4e6
    assert files_after == files
