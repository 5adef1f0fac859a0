"""The co-simulation of aircraft, envelope and autopilot in three tools, and what the protection is worth."""

import zipfile
from contextlib import nullcontext
from importlib.util import find_spec

import numpy as np
import pytest
from fmpy.ssp.ssd import read_ssd

from examples.envelope_protection import run
from examples.envelope_protection.figure import draw, until_ground
from examples.envelope_protection.system import JAM_S, STEP_S
from gtm_fmu.units import M_S_PER_KT, RAD_PER_DEG

pytestmark = pytest.mark.slow

PROTECTED, UNPROTECTED = run.FLIGHTS
SLOWED_S, COMPARED_S = 88.0, 40.0


@pytest.fixture(scope="module")
def archives(tmp_path_factory):
    return run.build(tmp_path_factory.mktemp("envelope_protection"))


@pytest.fixture(scope="module")
def flights(archives):
    """Both flights, beyond the jam and the order to slow down."""
    return {name: run.fly("FMPy", ssp, SLOWED_S) for name, ssp in archives.items()}


@pytest.mark.parametrize("flight", run.FLIGHTS)
def test_archives_follow_the_schema(archives, flight, tmp_path):
    """FMPy holds SystemStructure.ssd against the XSD of SSP 1.0; a damaged one fails."""
    assert [part.name for part in read_ssd(str(archives[flight])).system.elements] == [
        "aircraft",
        "envelope",
        "autopilot",
    ]
    with zipfile.ZipFile(archives[flight]) as archive, zipfile.ZipFile(tmp_path / "damaged.ssp", "w") as damaged:
        text = archive.read("SystemStructure.ssd").replace(b"startElement", b"start")
        damaged.writestr("SystemStructure.ssd", text)
    with pytest.raises(Exception, match="start"):
        read_ssd(str(tmp_path / "damaged.ssp"))


@pytest.mark.parametrize("tool", ["ecospy", "libcosimpy"])
def test_tools_agree(archives, flights, tool):
    """Through the jam, to 1e-9 of FMPy."""
    if find_spec(run.PACKAGES[tool]) is None:
        pytest.skip(f"{tool} is not installed")
    try:
        found = run.fly(tool, archives[PROTECTED], COMPARED_S)
    except RuntimeError as error:
        if "libtbb" in str(error):
            pytest.skip("ecospy needs libtbb12")
        raise
    assert found["time"][-1] == pytest.approx(COMPARED_S)
    assert COMPARED_S > JAM_S + 5
    assert run.difference(flights[PROTECTED], found) < 1e-9


def after_jam(flight):
    """From when the envelope that is left is known; a second later the autopilot has asked for it again."""
    return flight[flight["time"] > JAM_S + 2 * STEP_S]


def test_with_protection_the_airspeed_stays_inside(flights):
    """The plan's 64 kn are inside the envelope of the whole rudder, but not of the jammed one."""
    before = flights[PROTECTED][round((JAM_S - 1) / STEP_S)]
    assert before["autopilot.known_v_min"] < 64 * M_S_PER_KT
    flight = after_jam(flights[PROTECTED])
    assert flight["autopilot.tas_planned"].min() == pytest.approx(64 * M_S_PER_KT)
    assert (flight["autopilot.known_v_min"] > 64 * M_S_PER_KT).all()
    assert (flight["aircraft.air.tas"] > flight["autopilot.known_v_min"] + 3 * M_S_PER_KT).all()
    assert (flight["aircraft.air.tas"] < flight["autopilot.known_v_max"] - 3 * M_S_PER_KT).all()
    settled = flight[flight["time"] > 70]
    assert np.abs(settled["aircraft.state.phi"] / RAD_PER_DEG - 20).max() < 2
    assert np.abs(settled["aircraft.path.gamma"] / RAD_PER_DEG - 3).max() < 0.5
    assert settled["aircraft.surface.aileron"].min() > -19.5 * RAD_PER_DEG


def test_without_it_the_ailerons_are_not_enough(flights):
    """Once below V_min the ailerons are at the end of their travel and the aircraft rolls over."""
    flight = after_jam(flights[UNPROTECTED])
    is_below = flight["aircraft.air.tas"] < flight["autopilot.known_v_min"]
    first = int(np.argmax(is_below))
    assert is_below.any()
    assert flight["aircraft.air.tas"][:first].min() > 67 * M_S_PER_KT
    assert np.abs(flight["aircraft.state.phi"][:first][-500:]).max() < 30 * RAD_PER_DEG
    lost = flight[first : first + round(8 / STEP_S)]
    assert lost["aircraft.surface.aileron"].min() == pytest.approx(-20 * RAD_PER_DEG, rel=1e-9)
    assert lost["aircraft.state.phi"].min() < -90 * RAD_PER_DEG
    assert len(until_ground(flights[UNPROTECTED])) < len(flights[UNPROTECTED])


def test_jam_and_fuel_are_the_aircrafts(flights):
    flight = after_jam(flights[PROTECTED])
    assert flight["aircraft.surface.rudder"][round(1 / STEP_S) :] == pytest.approx(20 * RAD_PER_DEG, rel=1e-9)
    assert 0.3 < flight["aircraft.fuel.used"][-1] < 1.0  # kg; SPEC 10.3: about 0.3 lb/min an engine


def test_figure(flights, tmp_path):
    path = draw(flights, tmp_path / "figure.png")
    assert 20_000 < path.stat().st_size < 150_000


def test_goes_on_without_a_tool(archives, capsys, monkeypatch, tmp_path):
    """A tool that fails, and one that is not installed, are named and left out."""
    flown = np.zeros(2, [("time", float)])

    def fly(tool, ssp):
        if tool == "ecospy":
            raise RuntimeError("ecospy cannot fly: no libtbb")
        return flown

    monkeypatch.setattr(run, "fly", fly)
    monkeypatch.setattr(run, "find_spec", lambda name: None if name == "libcosimpy" else name)
    found = run.compare(archives, ["ecospy", "libcosimpy", "FMPy"], lambda name: nullcontext())
    assert list(found) == list(archives)
    printed = capsys.readouterr().out
    for flight in archives:
        assert f"{flight}: left out, ecospy cannot fly: no libtbb" in printed
        assert f"{flight}: libcosimpy is not installed" in printed
        assert f"{flight}: flown by FMPy" in printed


def test_without_any_tool(archives, capsys, monkeypatch, tmp_path):
    monkeypatch.setattr(run, "build", lambda *_: archives)
    monkeypatch.setattr(run, "find_spec", lambda name: None)
    monkeypatch.setattr("sys.argv", ["run.py", "--output", str(tmp_path)])
    assert run.main() == 3
    assert "No tool has flown both archives" in capsys.readouterr().err
