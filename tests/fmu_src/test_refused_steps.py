"""A refused step ends a simulation (FMI 2.0.5, 4.2.2): Discard alone would have an importer try for ever."""

import math
from ctypes import byref, c_double, c_int, c_void_p
from time import process_time

import fmpy
import pytest

from gtm_fmu.aircraft.client import FmuClient, FmuError
from tests.fmu_src.conftest import sessions
from tests.fmu_src.native_session import DISCARD, OK, Session

pytestmark = pytest.mark.slow

LAST_SUCCESSFUL_TIME, TERMINATED = 2, 3
FLIGHTS = ("dynamics", "aircraft", "dynamics-native", "aircraft-native")
INPUTS = {
    "dynamics-native": "control.rudder",
    "aircraft-native": "control.rudder",
    "envelope-native": "tas",
    "surrogate-native": "tas",
    "thrust-map-native": "tas",
}
"""An input of each native FMU of FMI 2.0."""


@pytest.mark.parametrize("model", FLIGHTS)
def test_a_flight_that_cannot_go_on_ends(built, model):
    """FMPy stops where the airspeed is lost, at the last time that the FMU has reached, and the log says what to do."""
    start = {"state.u": 5.0, "state.w": 0.0, "state.theta": 1.5, "solver.substep": 0.001}
    messages: list[str] = []
    result = fmpy.simulate_fmu(
        str(built(model)), fmi_type="CoSimulation", stop_time=10, output_interval=0.02, start_values=start,
        output=["state.theta"], debug_logging=True, logger=lambda *message: messages.append(message[-1].decode()),
    )  # fmt: skip
    assert 0 < result["time"][-1] < 10
    assert abs(result["state.theta"][-1]) < math.pi / 2
    place = f"The step at {float(result['time'][-1])!r} s is refused and the FMU stays there: "
    assert place + "give other inputs or parameters, go back to a saved state, or end the simulation." in messages[-1]


SUBSTEPS = 1_000_000
"""Most of one step: more would keep an importer waiting that cannot stop it."""
TOO_LONG = "The step takes more than 1000000 parts of solver.substep: take shorter steps, or a longer solver.substep."


@pytest.mark.parametrize("model", ["dynamics", "aircraft"])
class TestLongSteps:
    """A day in one step is refused at once, in each kind of FMU."""

    def test_native(self, built, tmp_path, model, fmi):
        folder = fmpy.extract(built(f"{model}-native" if fmi == 2 else f"{model}-native3"), tmp_path)
        for start in sessions(folder, fmi):
            session, begin = start(), process_time()
            for duration in (1e5, 1.000001 * SUBSTEPS * 0.005, 1e300):
                assert session.step(0.0, duration) == DISCARD
                (text,) = session.texts()
                assert text.startswith(TOO_LONG + " The step at 0 s is refused")
            assert process_time() - begin < 0.5
            assert session.step(0.0, 0.1) == OK

    def test_python(self, built, model):
        with FmuClient(built(model)) as fmu:
            begin = process_time()
            with pytest.raises(FmuError, match=TOO_LONG):
                fmu.step(1e5)
            assert process_time() - begin < 0.5


def status(session: Session) -> tuple[bool, float]:
    """Whether the FMU asks to stop, and the time that it has reached."""
    stopped, time = c_int(), c_double()
    assert session.call("GetBooleanStatus", TERMINATED, byref(stopped)) == OK
    assert session.call("GetRealStatus", LAST_SUCCESSFUL_TIME, byref(time)) == OK
    return bool(stopped.value), time.value


@pytest.mark.parametrize("model", INPUTS)
def test_status_of_native_fmus(built, networks, tmp_path, model):
    """A good step, a good value and a saved state take the wish to stop back."""
    path = built(model, networks[2] if model.startswith("surrogate") else ())
    for start in sessions(fmpy.extract(path, tmp_path), 2):
        session = start()
        place, saved = session.names[INPUTS[model]], c_void_p()
        (good,) = session.get_named(INPUTS[model])
        assert session.step(0.0, 0.1) == OK
        assert status(session) == (False, 0.1)
        assert session.call("GetFMUstate", byref(saved)) == OK
        assert session.step(0.1, -1.0) == DISCARD
        assert status(session) == (True, 0.1)
        assert session.set([place], [math.nan]) == DISCARD
        assert session.step(0.1, 0.1) == DISCARD
        assert status(session) == (True, 0.1)
        assert session.set([place], [good]) == OK
        assert session.step(0.1, 0.1) == OK
        assert status(session) == (False, 0.2)
        assert session.step(0.2, -1.0) == DISCARD
        assert session.call("SetFMUstate", saved) == OK
        assert status(session) == (False, 0.1)
        assert session.call("FreeFMUstate", byref(saved)) == OK


def test_time_of_a_python_fmu_after_a_saved_state(built, tmp_path):
    """The time that it has reached is that of the refused step, not that of the last one before the state came back."""
    folder = fmpy.extract(str(built("dynamics")), str(tmp_path))
    description = fmpy.read_model_description(folder)
    instance = fmpy.instantiate_fmu(folder, description, fmi_type="CoSimulation")
    instance.setupExperiment(startTime=0.0)
    instance.enterInitializationMode()
    instance.exitInitializationMode()
    instance.doStep(0.0, 0.1)
    saved = instance.getFMUstate()
    instance.doStep(0.1, 0.1)
    instance.setFMUstate(saved)
    instance.freeFMUstate(saved)
    with pytest.raises(Exception, match="status 2"):
        instance.doStep(0.1, -1.0)
    assert instance.getRealStatus(LAST_SUCCESSFUL_TIME) == 0.1
    instance.terminate()
    instance.freeInstance()
