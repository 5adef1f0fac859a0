"""Native FMUs where numbers trap, stacks are small, or numbers are written with a comma: a process each."""

import json
import os
import platform
import shutil
import subprocess
import sys
from pathlib import Path

import fmpy
import pytest

pytestmark = pytest.mark.slow

HOST = """
import ctypes, json, locale, math, sys, threading
from ctypes import byref, c_size_t, c_ubyte, c_void_p
from tests.fmu_src.native_session import ERROR, OK, SESSIONS

TRAPS, STACK = 1 | 4 | 8, 256 * 1024  # FE_INVALID, FE_DIVBYZERO, FE_OVERFLOW of x86-64


def live(session):
    variables = session.description.modelVariables
    computed = [v.name for v in variables if v.causality == "output" and v.type in ("Real", "Float64")]
    flags = [v.name for v in variables if v.type == "Boolean"]
    inputs = [v for v in variables if v.causality == "input" and v.type != "Boolean"]
    starts = [session.starts[v.name] for v in inputs]
    session.initialize(is_exited=False)
    tell(session.get_named(*computed))
    assert session.call("ExitInitializationMode") == OK
    if session.kind == "me":
        assert session.call("EnterContinuousTimeMode") == OK
    state, size = c_void_p(), c_size_t()
    assert session.call(session.state_functions[0], byref(state)) == OK
    time = 0.0
    for share in (0.0, 0.3, 1.0, -0.7, 0.0):
        values = [start + share * (start or 0.1) for start in starts]
        values = [5.0 * (share == 1) if v.name == "damage.case" else x for x, v in zip(values, inputs)]
        allowed = [min(max(x, v.min), v.max) for x, v in zip(values, map(bounds, inputs))]
        session.set([v.valueReference for v in inputs], allowed)
        if session.kind == "cs":
            session.step(time, 0.05)
            time = session.get_named("time")[0]
        else:
            session.handle_event()
            session.continuous(session.derivatives_function, [0.0] * len(session.states))
        tell(session.get([session.names[name] for name in computed])[1])
        tell(session.get_flags(*flags))
        if is_smooth:
            tell(session.directional([session.names[computed[0]]], [inputs[0].valueReference], [1.0])[1])
    for bad in (math.nan, math.inf, -math.inf):
        session.set([inputs[0].valueReference], [bad])
        if session.kind == "cs":
            session.step(bad, 0.05), session.step(time, bad)
        session.set([inputs[0].valueReference], starts[:1])
    session.step(0.25, 1e-320) if session.kind == "cs" else None
    session.call(session.serialize_functions[0], state, byref(size))
    content = (c_ubyte * size.value)()
    assert session.call(session.serialize_functions[1], state, content, size) == OK
    copy = c_void_p()
    assert session.call(session.serialize_functions[2], content, size, byref(copy)) == OK
    assert session.call(session.state_functions[1], copy) == OK
    assert session.call(session.state_functions[2], byref(copy)) == OK
    assert session.call(session.state_functions[2], byref(state)) == OK
    tell(session.texts())


class bounds:
    def __init__(self, variable):
        self.min = -1e9 if variable.min is None else float(variable.min)
        self.max = 1e9 if variable.max is None else float(variable.max)


told = []
tell = told.append
locale.setlocale(locale.LC_ALL, "")
decimal_point = locale.localeconv()["decimal_point"]
fmi, kinds, folder, is_trapped = json.loads(sys.argv[1])
for kind in kinds:
    session = SESSIONS[fmi](folder, kind)
    is_smooth = session.description.coSimulation.providesDirectionalDerivative
    session.states = [v for v in session.description.modelVariables if v.derivative]

    def work():
        if is_trapped:
            assert ctypes.CDLL("libm.so.6").feenableexcept(TRAPS) >= 0
        live(session)
        told.append("alive")

    if is_trapped:
        threading.stack_size(STACK)
    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    session.free()
print(json.dumps([decimal_point, told]))
"""
NAMES = ("dynamics", "aircraft", "envelope", "manoeuvre", "surrogate", "thrust-map")
MODELS = [f"{name}-native{fmi}" for name in NAMES for fmi in ("", 3)]


def told_by(folder: Path, model: str, is_trapped: bool, **environment: str) -> tuple[str, list]:
    """Decimal point of the process, and all that the FMU gave and logged in its kinds."""
    kinds = ["cs"] if model.startswith("aircraft") else ["cs", "me"]
    given = json.dumps([3 if model.endswith("3") else 2, kinds, str(folder), is_trapped])
    run = subprocess.run(
        [sys.executable, "-c", HOST, given],
        capture_output=True,
        text=True,
        env={**os.environ, **environment},
        cwd=Path(__file__).parents[2],
    )
    assert run.returncode == 0, run.stderr[-3000:]
    point, told = json.loads(run.stdout)
    assert told.count("alive") == len(kinds), run.stderr[-3000:]
    return point, told


@pytest.fixture(scope="module")
def folder_of(built, networks, tmp_path_factory):
    def unpacked(model: str) -> Path:
        path = built(model, networks[2] if model.startswith("surrogate") else ())
        return Path(fmpy.extract(path, tmp_path_factory.mktemp(model)))

    return unpacked


@pytest.mark.skipif((sys.platform, platform.machine()) != ("linux", "x86_64"), reason="glibc traps, by its numbers")
@pytest.mark.parametrize("model", MODELS)
def test_traps_and_a_small_stack(model, folder_of):
    told_by(folder_of(model), model, is_trapped=True)


@pytest.fixture(scope="module")
def german(tmp_path_factory) -> Path:
    """A folder with the locale de_DE.UTF-8, made here."""
    folder = tmp_path_factory.mktemp("locales")
    command = ["localedef", "-i", "de_DE", "-f", "UTF-8", str(folder / "de_DE.UTF-8")]
    if shutil.which("localedef") is None or subprocess.run(command, capture_output=True).returncode:
        pytest.skip("localedef cannot make de_DE here")
    return folder


@pytest.mark.parametrize("model", ["dynamics-native", "aircraft-native3", "thrust-map-native3"])
def test_locale_changes_nothing(model, folder_of, german):
    """Neither numbers nor messages."""
    folder = folder_of(model)
    point, expected = told_by(folder, model, is_trapped=False, LC_ALL="C.UTF-8")
    assert point == "."
    assert any("0.25" in text for told in expected for text in told if isinstance(text, str))
    point, told = told_by(folder, model, is_trapped=False, LC_ALL="de_DE.UTF-8", LOCPATH=str(german))
    assert point == ","
    assert told == expected
