"""GtmAircraft and GtmAircraftNative against the simulation in this process; their switches, failures and states."""

import ctypes
import re

import fmpy
import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from fmpy.validation import validate_fmu

from fmu_src.description.aircraft_variables import USAGE, aircraft_description
from fmu_src.slaves.gtm_aircraft import ALL_FAULTS
from gtm_fmu.aircraft.client import FmuClient, FmuError
from gtm_fmu.airframe.names import CONTROLS, SIMULATION_INPUTS, SIMULATION_SETTINGS, STATES
from gtm_fmu.core import library_path
from gtm_fmu.core.simulation import DEFAULTS, FAULTS, Simulation, memory_size
from gtm_fmu.trims.fmu_trimmer import FmuTrimmer
from gtm_fmu.trims.steady import trim
from tests.fmu_src.conftest import AIRCRAFT
from tests.fmu_src.native_session import DISCARD, ERROR, OK, SESSIONS

pytestmark = pytest.mark.slow

GROUPS = aircraft_description().groups
NAMES = {group: [variable.name for variable in variables] for group, variables in GROUPS.items()}
SI = {group: np.array([variable.scale for variable in variables]) for group, variables in GROUPS.items()}
START = {group: np.array([v.start or 0 for v in GROUPS[group]], float) / SI[group] for group in ("states", "controls")}
SWITCHES = {variable.name for variable in GROUPS["settings"] if variable.boolean}

STEP_S, SUBSTEP_S = 0.02, 0.005


@pytest.fixture(scope="module")
def paths(aircraft_fmus):
    return aircraft_fmus


def flight_settings() -> dict[str, float]:
    """Every setting away from its default, in the simulation's units."""
    rng = np.random.default_rng(3)
    settings = {
        name: value + rng.uniform(0.5, 2) * (-1 if name.endswith("upper") else 1) for name, value in DEFAULTS.items()
    }
    settings |= {f"{name}_rate": rng.uniform(20, 80) for name in ("elevator", "aileron", "rudder")}
    settings |= {"failure_time": 0.713, "damage_case": 4, "engine_left_running": 0, "engine_right_running": 1}
    settings |= {"has_shear": 0, "has_stall_asymmetry": 1, "has_servos": 1, "has_dead_band": 1, "has_throttle_lag": 1}
    return settings | {"command_delay": 0.012, "surface_delay": 0.0331, "has_fuel_burn": 1, "runway_altitude": 700}


def commands(i: int) -> np.ndarray:
    """Inputs over a step, in the simulation's units."""
    u = START["controls"].copy()
    u[: len(u)] += np.sin(0.1 * i + np.arange(len(u))) * (3, 6, 8, 20, 5, 9, 0.9, 9, 9, 3, 2, 2, 2) * (i > 3)
    return u


def expected(settings: dict[str, float], count: int) -> tuple[np.ndarray, np.ndarray]:
    simulation = Simulation(START["states"], settings)
    for i in range(count):
        simulation.advance(commands(i), STEP_S, SUBSTEP_S)
    return simulation.x, simulation.evaluate(commands(count - 1))[1]


def fmu_settings(settings: dict[str, float]) -> tuple[dict[str, float], dict[str, bool]]:
    """Settings under the names of the FMU in SI, and its switches."""
    values = [settings[name] for name in SIMULATION_SETTINGS] * SI["settings"]
    named = dict(zip(NAMES["settings"], values, strict=True))
    return {n: float(v) for n, v in named.items() if n not in SWITCHES}, {n: bool(named[n]) for n in SWITCHES}


def set_switches(fmu: FmuClient, switches: dict[str, bool]) -> None:
    references = {v.name: v.valueReference for v in fmu.description.modelVariables}
    fmu.instance.setBoolean([references[name] for name in switches], list(switches.values()))


@pytest.mark.parametrize("name", AIRCRAFT)
def test_descriptions_are_valid(paths, name):
    assert validate_fmu(paths[name]) == []
    assert len(NAMES["controls"]) == len(SIMULATION_INPUTS)


def test_limit_of_changes_on_their_way():
    """What the documentation and both messages say is what the core has."""
    header = (library_path().parent / "gtm_simulation.h").read_text()
    (limit,) = re.findall(r"GTM_RECORDS = (\d+)", header)
    for text in (" ".join(USAGE), ALL_FAULTS[9], FAULTS[9]):
        assert f" {limit} " in text


@pytest.mark.parametrize("name", AIRCRAFT[:2])
def test_a_flight_with_everything(paths, name):
    """Every input moves and every setting is its own: to rounding of the simulation in this process."""
    reals, switches = fmu_settings(flight_settings())
    x, y = expected(flight_settings(), 60)
    with FmuClient(paths[name], start_values=reals) as fmu:
        set_switches(fmu, switches)
        for i in range(60):
            fmu.set(NAMES["controls"], commands(i) * SI["controls"])
            fmu.step(STEP_S)
        np.testing.assert_allclose(fmu.get(NAMES["states"]) / SI["states"], x, rtol=1e-10, atol=1e-10)
        np.testing.assert_allclose(fmu.get(NAMES["outputs"]) / SI["outputs"], y, rtol=1e-10, atol=1e-10)


def test_fmi_3_through_fmpy(paths):
    reals, switches = fmu_settings(flight_settings())
    count = 60
    table = np.array([(i * STEP_S, *(commands(i) * SI["controls"])) for i in range(count + 1)])
    signals = np.array(list(map(tuple, table)), dtype=[(n, float) for n in ("time", *NAMES["controls"])])
    result = fmpy.simulate_fmu(
        str(paths["aircraft-native3"]), fmi_type="CoSimulation", stop_time=count * STEP_S, step_size=STEP_S,
        output_interval=STEP_S, start_values=reals | switches, input=signals, output=NAMES["states"],
    )  # fmt: skip
    x = [result[name][-1] for name in NAMES["states"]]
    np.testing.assert_allclose(x / SI["states"], expected(flight_settings(), count)[0], rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("name", AIRCRAFT[:2])
def test_flies_straight_out_of_the_box(paths, name):
    """The start values are a trim of SPEC 13, and the servos start at their commands."""
    with FmuClient(paths[name]) as fmu:
        start = fmu.get(NAMES["states"])
        assert fmu.get(["surface.elevator"])[0] == pytest.approx(np.radians(2.414942), rel=1e-12)
        for _ in range(500):
            fmu.step(STEP_S)
        moved = np.delete(fmu.get(NAMES["states"]) - start, [6, 7])
        np.testing.assert_allclose(moved, 0, atol=2e-4)


@pytest.mark.parametrize("name", AIRCRAFT[:2])
class TestRefusals:
    def test_one_sentence_and_nothing_moves(self, paths, name):
        cases = {
            "damage.case": (1.5, "no whole number"),
            "limits.rudder.lower": (0.5, "reversed"),
            "wind.north": (1e4, "outside its range"),
        }
        with FmuClient(paths[name], start_values={"limits.rudder.upper": 0.1}) as fmu:
            fmu.step(STEP_S)
            for variable, (value, message) in cases.items():
                good = fmu.get([variable])
                before = fmu.get(NAMES["states"])
                fmu.set([variable], [value])
                with pytest.raises(FmuError, match=message):
                    fmu.step(STEP_S)
                fmu.set([variable], good)
                np.testing.assert_array_equal(fmu.get(NAMES["states"]), before)
            fmu.step(STEP_S)

    def test_a_real_variable_is_no_boolean(self, paths, name):
        with FmuClient(paths[name]) as fmu:
            before = fmu.get(["damage.case"])
            with pytest.raises(FMICallException):
                fmu.instance.setBoolean([fmu.reference("damage.case")], [True])
            assert fmu.messages[-1].text.startswith("There is no Boolean variable with value reference")
            np.testing.assert_array_equal(fmu.get(["damage.case"]), before)

    def test_values_out_of_bounds(self, paths, name):
        with FmuClient(paths[name]) as fmu, pytest.raises(FmuError, match=r"damage\.case was given as 9, allowed is 0"):
            fmu.set(["damage.case"], [9.0])


@pytest.mark.parametrize("name", AIRCRAFT)
@pytest.mark.parametrize(
    ("delays", "step_s", "count"),
    [
        ({}, 0.0002, 200),
        ({"delay.commands": 1.0}, 0.01, 130),
        ({"delay.commands": 1.0, "delay.surfaces": 1.0}, 0.02, 130),
    ],
    ids=["short steps", "long delay", "long delays"],
)
def test_many_changes_within_the_delays(paths, name, delays, step_s, count):
    """Commands that change at each step: the flight of the simulation in this process, through FMPy."""
    settings = {"command_delay": delays.get("delay.commands"), "surface_delay": delays.get("delay.surfaces")}
    flight = Simulation(START["states"], {key: delay for key, delay in settings.items() if delay is not None})
    for i in range(count):
        flight.advance(commands(i + 4), step_s, SUBSTEP_S)
    table = [(i * step_s, *(commands(i + 4) * SI["controls"])) for i in range(count + 1)]
    result = fmpy.simulate_fmu(
        str(paths[name]), fmi_type="CoSimulation", stop_time=count * step_s, step_size=step_s, output_interval=step_s,
        start_values=delays, input=np.array(table, dtype=[(n, float) for n in ("time", *NAMES["controls"])]),
        output=NAMES["states"],
    )  # fmt: skip
    assert result["time"][-1] == pytest.approx(count * step_s)
    x = [result[name][-1] for name in NAMES["states"]]
    np.testing.assert_allclose(x / SI["states"], flight.x, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("delay_s", [0.005, 1.0])
@pytest.mark.parametrize("name", AIRCRAFT[:2])
def test_saved_states_hold_what_the_actuators_remember(paths, name, delay_s):
    """Commands under way at the time of saving arrive after restoring, also from bytes."""
    with FmuClient(paths[name], start_values={"delay.commands": delay_s}) as fmu:
        for i in range(20 if delay_s < 1 else 320):
            fmu.set(NAMES["controls"], commands(i) * SI["controls"])
            fmu.step(0.003)
        saved = fmu.instance.getFMUstate()
        stored = fmu.instance.serializeFMUState(saved)
        ends, start = [], fmu.time_s
        for state in (None, saved, fmu.instance.deSerializeFMUstate(stored)):
            if state is not None:
                fmu.instance.setFMUstate(state)
                fmu.time_s = start
            for _ in range(10):
                fmu.step(0.003)
            ends.append(fmu.get(NAMES["states"] + NAMES["outputs"]))
        np.testing.assert_array_equal(ends[0], ends[1])
        np.testing.assert_array_equal(ends[0], ends[2])


@pytest.mark.parametrize("fmi", [2, 3])
class TestNativeCalls:
    @pytest.fixture
    def folder(self, paths, fmi, tmp_path):
        return fmpy.extract(paths[AIRCRAFT[fmi - 1]], tmp_path)

    def test_no_model_exchange(self, folder, fmi):
        session = SESSIONS[fmi](folder, "me")
        assert not session.component.value
        assert session.texts() == ["The FMU has no model exchange."]

    def test_booleans(self, folder, fmi):
        """They can be set and got; a real variable is none."""
        kind = ctypes.c_int if fmi == 2 else ctypes.c_bool
        with SESSIONS[fmi](folder, "cs") as session:
            session.initialize()
            count = [ctypes.c_size_t(1)] * (1 if fmi == 2 else 2)

            def call(function, name, value):
                reference, flag = (ctypes.c_uint * 1)(session.names[name]), (kind * 1)(value)
                sizes = (count[0], flag) if fmi == 2 else (count[0], flag, count[1])
                return session.call(function, reference, *sizes), bool(flag[0])

            assert call("GetBoolean", "fuel.burn", True) == (OK, False)
            assert call("SetBoolean", "fuel.burn", True)[0] == OK
            assert call("GetBoolean", "fuel.burn", False) == (OK, True)
            assert call("SetBoolean", "damage.case", True)[0] == ERROR
            assert session.texts()[0].startswith("There is no Boolean variable")
            assert DISCARD not in {status for status, _, _ in session.messages}


@pytest.mark.parametrize("name", AIRCRAFT[:2])
def test_a_trim_over_it_has_no_actuators(paths, name):
    """Before the first step they have settled, so that it is the trim of the bare airframe."""
    places = {
        "states": [f"state.{state}" for state in STATES],
        "derivatives": [f"der(state.{state})" for state in STATES],
        "controls": [f"control.{control}" for control in CONTROLS],
    }
    with FmuClient(paths[name], **places) as fmu:
        found = FmuTrimmer(fmu).trim(altitude_ft=10000, tas_kt=118.5, turn_rate_deg_s=2)
    np.testing.assert_allclose(found.unknowns, trim(10000, 118.5, 0, 2).unknowns, rtol=1e-9, atol=1e-9)


def test_damaged_bytes_of_a_state(paths):
    """Whatever the memory of the actuators is made to hold: a sentence in the log, or finite values."""
    with FmuClient(paths["aircraft-native"]) as fmu:
        fmu.step(STEP_S)
        stored = fmu.instance.serializeFMUstate(fmu.instance.getFMUstate())
        refused = 0
        for place in range(24):  # flags, clock, positions, lag, number of records and the first of them
            for value in (np.nan, -1.0, 0.5, 65.0, 1e300):
                memory = np.frombuffer(stored, dtype=np.uint8).copy()
                begin = len(stored) - 8 * (memory_size() - place)
                memory[begin : begin + 8] = np.frombuffer(np.float64(value).tobytes(), np.uint8)
                fmu.time_s = STEP_S
                try:
                    fmu.instance.setFMUstate(fmu.instance.deSerializeFMUstate(memory.tobytes()))
                    fmu.step(STEP_S)
                    assert np.isfinite(fmu.get(NAMES["states"] + NAMES["outputs"])).all()
                except (FMICallException, FmuError):
                    refused += 1
        assert refused > 24
        assert fmu.messages[-1].text
        fmu.instance.setFMUstate(fmu.instance.deSerializeFMUstate(stored))
        fmu.time_s = STEP_S
        fmu.step(STEP_S)
