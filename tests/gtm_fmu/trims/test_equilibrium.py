"""Equilibria of FMUs: closed forms of an oscillator that is not ours, and trims of our aircraft under other names."""

import shutil

import numpy as np
import pytest

from examples.foreign_fmus.build import renamed, van_der_pol
from fmu_src.fmus import build_fmu
from gtm_fmu.aircraft.client import FmuClient, FmuError
from gtm_fmu.aircraft.evaluation import FmuAirframe
from gtm_fmu.aircraft.limits import ControlLimits
from gtm_fmu.airframe.names import CONTROLS, STATES
from gtm_fmu.errors import InputError
from gtm_fmu.trims import steady
from gtm_fmu.trims.equilibrium import equilibrium
from gtm_fmu.trims.fmu_trimmer import FmuTrimmer
from gtm_fmu.units import KT_PER_FT_S

pytestmark = pytest.mark.slow

ANYWHERE = (-np.inf, np.inf)


@pytest.fixture(scope="module", params=[True, False], ids=["directional derivatives", "differences"])
def oscillator(request, tmp_path_factory):
    if shutil.which("cc") is None:
        pytest.skip("no C compiler: install gcc")
    with FmuClient(van_der_pol(tmp_path_factory.mktemp("foreign"), request.param)) as client:
        assert (client.jacobian is not None) == request.param
        yield client


class TestOscillator:
    """x'' = mu (1 - x^2) x' - x + force rests where x' = 0 and x = force."""

    @pytest.fixture(autouse=True)
    def from_its_start(self, oscillator):
        oscillator.reset()

    def test_rest(self, oscillator):
        found = equilibrium(oscillator, {"position": (-5, 5), "velocity": ANYWHERE})
        assert found.found
        assert found.values == pytest.approx({"position": 0.0, "velocity": 0.0, "force": 0.0}, abs=1e-9)

    def test_held_force(self, oscillator):
        found = equilibrium(oscillator, {"position": ANYWHERE, "velocity": ANYWHERE}, held={"force": 0.75})
        assert found.found
        assert found.values["position"] == pytest.approx(0.75, abs=1e-9)
        assert found.derivatives == pytest.approx({"der(position)": 0.0, "der(velocity)": 0.0}, abs=1e-9)

    def test_nearest_of_many(self, oscillator):
        """All points x = force, x' = 0 rest; with the force's nominal value of 10 the nearest to x = 2 is 2/1.01."""
        found = equilibrium(oscillator, {"position": ANYWHERE, "velocity": ANYWHERE, "force": ANYWHERE})
        assert found.found
        # d/dx of (x - 2)^2 + (x / 10)^2 vanishes at x = 2 / 1.01
        assert found.values["position"] == pytest.approx(2 / 1.01, abs=1e-7)
        assert found.values["force"] == pytest.approx(found.values["position"], abs=1e-8)

    def test_a_bound_stops_it(self, oscillator):
        """With x >= 1 and x' held at 0, no force leaves an acceleration of -1 at least."""
        found = equilibrium(oscillator, {"position": (1.0, 5.0), "velocity": (0.0, 0.0)})
        assert not found.found
        assert found.values["position"] == pytest.approx(1.0, abs=1e-6)
        assert found.residual == pytest.approx(1.0, abs=1e-6)

    def test_only_the_chosen_derivatives(self, oscillator):
        """x'' = 0 at x = 2, force = 0, mu = 1: -3 x' - 2 = 0."""
        found = equilibrium(oscillator, {"velocity": ANYWHERE}, held={"position": 2.0}, steady=["der(velocity)"])
        assert found.found
        assert found.values["velocity"] == pytest.approx(-2 / 3, abs=1e-9)
        assert found.derivatives["der(position)"] == pytest.approx(-2 / 3, abs=1e-9)

    def test_it_takes_no_steps(self, oscillator):
        with pytest.raises(FmuError, match="VanDerPol is for model exchange only"):
            oscillator.step(0.1)

    @pytest.mark.parametrize(
        ("question", "sentence"),
        [
            ({"free": {"speed": (0, 1)}}, "'speed' is no state or input of this FMU: it has position, velocity"),
            ({"free": {"velocity": (0, 1)}, "steady": ["velocity"]}, "'velocity' is no derivative"),
            ({"free": {"velocity": (0, 1)}, "held": {"weight": 1}}, "'weight' is no state or input"),
            ({"free": {"velocity": (1, 0)}}, "each lower bound first"),
            ({"free": {"velocity": (np.nan, 0)}}, "each lower bound first"),
            ({"free": {"velocity": (0,)}}, "a lower and an upper bound"),
            ({"free": {"velocity": (0, 1)}, "held": {"velocity": 1}}, "do not hold it too"),
            ({"free": {}}, "needs a free variable"),
            ({"free": {"velocity": (0, 1)}, "steady": []}, "and a steady derivative"),
        ],
    )
    def test_bad_question(self, oscillator, question, sentence):
        with pytest.raises(InputError, match=sentence):
            equilibrium(oscillator, **question)


QUESTIONS = [(10000.0, 118.5, 0.0, 2.0, ControlLimits(rudder_deg=(10, 10))), (5000.0, 100.0, -2.0, 0.0, None)]


@pytest.fixture(scope="module")
def aircraft(tmp_path_factory):
    """The native aircraft with variables named x.0, x.1 .. and c.0 .."""
    folder = tmp_path_factory.mktemp("renamed")
    names = {f"state.{name}": f"x.{k}" for k, name in enumerate(STATES)}
    names |= {f"der(state.{name})": f"der(x.{k})" for k, name in enumerate(STATES)}
    names |= {f"control.{name}": f"c.{k}" for k, name in enumerate(CONTROLS)}
    states, rates, controls = ([new for new in names.values() if new.startswith(p)] for p in ("x.", "der", "c."))
    path = renamed(build_fmu("dynamics-native", folder), folder / "Renamed.fmu", names)
    with FmuClient(path, states=states, derivatives=rates, controls=controls) as client:
        yield client


class TestAircraftUnderOtherNames:
    @pytest.mark.parametrize("question", QUESTIONS)
    def test_trim(self, aircraft, question):
        found, core = FmuTrimmer(aircraft).trim(*question), steady.trim(*question)
        assert found.feasible
        np.testing.assert_allclose(found.unknowns, core.unknowns, atol=1e-8)

    def test_equilibrium_is_the_trim_too(self, aircraft):
        """Level flight without sideslip, posed without knowing what an aircraft is; one freedom is left, the speed."""
        aircraft.reset()
        moving = {0: (30.0, 90.0), 2: (0.0, 20.0), STATES.index("theta"): (-0.5, 0.5), STATES.index("phi"): (-0.5, 0.5)}
        free = {f"x.{k}": bounds for k, bounds in moving.items()}
        free |= {f"c.{k}": (-0.5, 0.5) for k in range(3)} | {"c.3": (0.0, 1.0)}
        held = {f"x.{STATES.index('altitude')}": 3048.0, "x.1": 0.0}
        rates = [f"der(x.{k})" for k in (*range(6), STATES.index("altitude"))]
        found = equilibrium(aircraft, free, held, steady=rates)
        assert found.found
        tas_kt = np.hypot(found.values["x.0"], found.values["x.2"]) / 0.3048 * KT_PER_FT_S
        elevator_deg, aileron_deg, rudder_deg, throttle_pct = steady.trim(10000.0, tas_kt).unknowns[5:]
        surfaces = np.degrees([found.values[f"c.{k}"] for k in range(3)])
        np.testing.assert_allclose(surfaces, [elevator_deg, aileron_deg, rudder_deg], atol=1e-5)
        assert 100 * found.values["c.3"] == pytest.approx(throttle_pct, abs=1e-5)


class InFeet:
    """An evaluator in ft, ft/s, rad, deg and %: what a foreign FMU may declare."""

    def __init__(self, fmu):
        self._fmu = fmu
        metres = [0.3048 if name in ("u", "v", "w", "altitude") else 1.0 for name in STATES]
        self._x, self._u = np.array(metres), np.array([np.pi / 180] * 3 + [0.01])

    def si_factors(self):
        return self._x, self._u, self._x

    def evaluate(self, x, u):
        return self._fmu.evaluate(x * self._x, u * self._u) / self._x


def test_declared_units_are_honoured(tmp_path):
    with FmuClient(build_fmu("dynamics", tmp_path)) as fmu:
        found = FmuTrimmer(InFeet(fmu)).trim(*QUESTIONS[0])
    assert found.feasible
    np.testing.assert_allclose(found.unknowns, steady.trim(*QUESTIONS[0]).unknowns, atol=1e-8)


class Heavier:
    """An aircraft that is not ours: it falls faster by 1 m/s^2 along its z axis."""

    def __init__(self, fmu):
        self._fmu = fmu

    def evaluate(self, x, u):
        return self._fmu.evaluate(x, u) + np.where(np.array(STATES) == "w", 1.0, 0.0)


def test_another_aircraft_is_held_to_its_own_dynamics(tmp_path):
    question = (10000.0, 118.5)
    with FmuClient(build_fmu("dynamics", tmp_path)) as fmu:
        heavier = Heavier(fmu)
        found = FmuTrimmer(heavier).trim(*question)
        x, u = found.state_and_controls
        rates = FmuAirframe(heavier).derivatives(x, u)[:6]
    assert found.feasible
    assert np.abs(rates).max() == pytest.approx(found.residual, abs=1e-12)
    # a tenth more to carry at the same speed: about a tenth more lift
    assert found.alpha_deg > steady.trim(*question).alpha_deg + 0.3


def test_factors_of_declared_units(tmp_path):
    """Ours are all SI; one that declares deg is asked for as such."""
    with FmuClient(build_fmu("dynamics", tmp_path)) as fmu:
        assert all(np.all(factors == 1.0) for factors in fmu.si_factors())
        unit = next(unit for unit in fmu.description.unitDefinitions if unit.name == "rad")
        unit.baseUnit.factor = np.pi / 180
        states = dict(zip(fmu.states, fmu.si_factors()[0], strict=True))
    assert states["state.phi"] == np.pi / 180
    assert states["state.u"] == 1.0
