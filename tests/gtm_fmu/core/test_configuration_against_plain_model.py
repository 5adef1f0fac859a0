"""The compiled airframe in any configuration against the plain NumPy model of SPEC 10, and its exact Jacobians."""

from collections import Counter
from itertools import product

import numpy as np
import pytest

from gtm_fmu.airframe.names import STATES, TWO_THROTTLE_CONTROLS
from gtm_fmu.core import configuration as core
from gtm_fmu.core.configuration import Configuration
from tests.gtm_fmu.core.test_core_against_plain_model import STEPS, largest_difference, random_points
from tests.reference import plain_configuration, plain_model
from tests.reference.plain_configuration import DAMAGE, SIGNALS

pytestmark = pytest.mark.slow

ALTITUDE = STATES.index("altitude")
CASES = tuple(DAMAGE)
COMMANDED, SPOILERS, FLAPS = SIGNALS[:8], SIGNALS[8:12], SIGNALS[12:16]


def plain(u, configuration):
    """The same setting as the plain model takes it: the position of each surface instead of its command."""
    elevator, aileron, rudder, throttle_left, throttle_right = u
    commands = plain_configuration.allocated([elevator, aileron, rudder, 0.0])
    follows = zip(COMMANDED, configuration.surface_gain, configuration.surface_offset_deg, strict=True)
    bus = {
        **commands,
        **{name: gain * commands[name] + offset for name, gain, offset in follows},
        **dict(zip(SPOILERS, configuration.spoiler_deg, strict=True)),
        **dict(zip(FLAPS, configuration.flap_deg, strict=True)),
        **{"STAB": configuration.stabilizer_deg, "GEAR": configuration.gear},
        **{"THROTL": throttle_left, "THROTR": throttle_right},
    }
    return plain_configuration.Configuration(
        bus=bus,
        fuel_used=configuration.fuel_used_lb,
        damage_case=configuration.damage_case,
        wind=(*configuration.wind_ft_s, *configuration.gust_ft_s),
        shear=configuration.has_shear,
        h_runway=configuration.runway_altitude_ft,
        engines_on=configuration.engine_running,
        stall_asymmetry=configuration.has_stall_asymmetry,
    )


def random_states(count, seed):
    """A third around the tables, a third in every direction of flight, a third near the stall; low and high."""
    n = -(-count // 3)
    groups = [
        random_points(n, seed, alpha_deg=(-40, 100), beta_deg=(-30, 30)),
        random_points(n, seed + 1, alpha_deg=(-180, 180), beta_deg=(-85, 85)),
        random_points(n, seed + 2, alpha_deg=(11, 16), beta_deg=(-4, 4)),
    ]
    x = np.vstack([states for states, _ in groups])[:count]
    rng = np.random.default_rng(seed)
    x[:, ALTITUDE] = rng.choice([20, 1100, 40000], count) * rng.uniform(0, 1, count)
    return rng.permutation(x)


def random_surfaces(rng):
    """Each to well beyond its table, one in ten fixed at zero; the rest follow their command, in part or not at all."""
    is_moved = rng.uniform(size=16) > 0.1
    return {
        "surface_gain": is_moved[:8] * rng.choice([0.0, 1.0, rng.uniform()], 8),
        "surface_offset_deg": is_moved[:8] * rng.uniform(-1, 1, 8) * [25, 25, 25, 25, 25, 25, 45, 45],
        "spoiler_deg": is_moved[8:12] * rng.uniform(-20, 90, 4),
        "flap_deg": is_moved[12:] * rng.uniform(-10, 40, 4),
        "stabilizer_deg": rng.uniform(-18, 10),
        "gear": rng.choice([0, 0.3, 0.5, 1]),
    }


def random_configuration(rng, damage_case):
    """One in four has the surfaces of the study, one in two still air."""
    surfaces = random_surfaces(rng) if rng.uniform() > 0.25 else {}
    wind, gust = rng.choice([0, 1]) * rng.uniform(-1, 1, (2, 3)) * [[12], [4]]
    return Configuration(
        damage_case=damage_case,
        fuel_used_lb=rng.choice([0, 5, 8, 15]) * rng.uniform(0.8, 1),
        engine_running=rng.choice([False, True], 2),
        wind_ft_s=wind,
        gust_ft_s=gust,
        has_shear=rng.choice([False, True]),
        runway_altitude_ft=rng.choice([Configuration.runway_altitude_ft, -50.0, 2000.0]),
        has_stall_asymmetry=rng.choice([False, True]),
        **surfaces,
    )


def random_cases(count, seed):
    """States, controls and configurations, with the damage cases in turn."""
    rng = np.random.default_rng(seed + 3)
    u = rng.uniform([-35, -35, -35, -5, -5], [35, 35, 35, 105, 105], (count, len(TWO_THROTTLE_CONTROLS)))
    configurations = [random_configuration(rng, CASES[i % len(CASES)]) for i in range(count)]
    return list(zip(random_states(count, seed), u, configurations, strict=True))


def position(value, *edges):
    """How many of the edges lie at or below the value."""
    return int(np.searchsorted(edges, value, side="right"))


ENDS_OF_ALPHA = (-30, -10, -5, 40, 50, 60, 90)  # of the rate and damage tables, deg
ENDS_OF_RATES = {"p": 0.107, "q": 0.0075, "r": 0.112}  # either way
STUDY = Configuration()


def branches_of(x, u, configuration):
    """What SPEC 2, 3, 5, 6 and 10 distinguish, as far as this case goes into it."""
    setting = plain(u, configuration)
    case, bus = setting.damage_case, setting.bus
    air = plain_configuration.air_data(x, setting)
    alpha, beta = np.degrees([air.alpha, air.beta])
    spans = [plain_model.SPAN, plain_model.CHORD, plain_model.SPAN]
    rates = x[3:6] * spans / plain_model.rate_scale(air.tas)

    yield "case", case, position(alpha, -5, 40), position(beta, -20, 20)
    yield "stabiliser", case, position(bus["STAB"], -12, -8, 0, 4)
    yield "surfaces of the study", case, configuration.surface_gain == STUDY.surface_gain
    yield from (("lost", case, name) for name in DAMAGE[case].lost if bus[name] != 0)
    if case == 0:
        split = plain_model.kalviste_split(air.alpha, air.beta, *x[3:6])
        yield "split", split.case
        yield "rotary limit", position(plain_model.normalised_rates(split, air.tas).omega_hat, -0.5 + 1e-9, 0.5)
    else:
        yield "alpha", case, position(alpha, *ENDS_OF_ALPHA)
        ends = zip(ENDS_OF_RATES.items(), rates, strict=True)
        yield from (("rate", case, name, position(rate, -end, end)) for (name, end), rate in ends)

    gains = zip(COMMANDED, configuration.surface_gain, strict=True)
    yield from (("follows", name, position(gain, 1e-9, 1)) for name, gain in gains)
    yield from (("spoiler", name, position(bus[name], 0, 30, 65)) for name in SPOILERS)
    yield from (("flap", name, bool(bus[name])) for name in FLAPS)
    yield "rudder", bus["RUDU"] >= 0, bus["RUDL"] >= 0
    yield "gear", bus["GEAR"]
    yield "fuel", position(setting.fuel_used, 1e-9, 5.74, 11.48)
    yield "engines", setting.engines_on
    T, _, _ = plain_configuration.engines(air, setting)
    yield from (("thrust", side, bool(T[side])) for side in (0, 1) if setting.engines_on[side])
    yield "stall", setting.stall_asymmetry, bool(plain_configuration.stall_roll(alpha, beta))
    if any(setting.wind):
        yield "wind", setting.shear, position(x[ALTITUDE] - setting.h_runway, 1, 1000)


BRANCHES = {
    *product(["case"], CASES, range(3), range(3)),
    *product(["stabiliser"], CASES, range(5)),
    *product(["surfaces of the study"], CASES, (False, True)),
    *(("lost", case, name) for case in CASES for name in DAMAGE[case].lost),
    *product(["split"], (1, 2, 3)),
    *product(["rotary limit"], range(3)),
    *product(["alpha"], CASES[1:], range(len(ENDS_OF_ALPHA) + 1)),
    *product(["rate"], CASES[1:], ENDS_OF_RATES, range(3)),
    *product(["follows"], COMMANDED, range(3)),
    *product(["spoiler"], SPOILERS, range(4)),
    *product(["flap"], FLAPS, (False, True)),
    *product(["rudder"], (False, True), (False, True)),
    *product(["gear"], (0, 0.3, 0.5, 1)),
    *product(["fuel"], range(4)),
    *product(["engines"], product((False, True), repeat=2)),
    *product(["thrust"], (0, 1), (False, True)),
    *product(["stall"], (False, True), (False, True)),
    *product(["wind"], (False, True), range(3)),
}


@pytest.fixture(scope="module")
def cases():
    return random_cases(3500, seed=10)


def test_random_cases_visit_every_branch(cases):
    visits = Counter(branch for case in cases for branch in branches_of(*case))
    assert set(visits) == BRANCHES
    assert min(visits.values()) >= 5, visits.most_common()[-10:]


@pytest.mark.parametrize("name", ["derivatives", "outputs"])
def test_core_is_the_plain_model(name, cases):
    value = np.array([getattr(core, name)(*case) for case in cases])
    expected = np.array([getattr(plain_configuration, name)(x, plain(u, c)) for x, u, c in cases])
    assert largest_difference(value, expected) < 1e-10


def test_wind_and_mass_are_those_of_the_plain_model(cases):
    for x, u, configuration in cases:
        setting = plain(u, configuration)
        expected = plain_configuration.wind_body(x, setting)
        np.testing.assert_allclose(core.wind_body(x, configuration), expected, rtol=0, atol=1e-13)
        expected = plain_configuration.mass_properties(setting.fuel_used, setting.bus["GEAR"], setting.damage_case)
        for value, plain_value in zip(configuration.mass_properties, expected, strict=True):
            np.testing.assert_allclose(value, plain_value, rtol=0, atol=1e-14)


def slopes_along(step, x, u, configuration):
    """Change of the plain derivatives and outputs (27) with a step in (x, u), by central differences: whole, half."""

    def values(part):
        moved_x, moved_u = np.split(np.concatenate([x, u]) + part * step, [len(STATES)])
        setting = plain(moved_u, configuration)
        functions = plain_configuration.derivatives, plain_configuration.outputs
        return np.concatenate([function(moved_x, setting) for function in functions])

    return [(values(part) - values(-part)) / (2 * part) for part in (1, 0.5)]


def test_jacobians_are_the_differences_of_the_plain_model():
    """Along a random direction in all states and controls.

    A kink inside the step makes the differences over the whole and the half step disagree; such cases, one in a
    hundred, are left out. Richardson's rule of the two then leaves rounding: under 1e-8 of the terms that add up.
    """
    rng = np.random.default_rng(20)
    largest = 0.02 * np.append(STEPS, STEPS[-1])
    count, smooth = 700, 0
    for case in random_cases(count, seed=21):
        step = largest * rng.uniform(0.5, 1, len(largest)) * rng.choice([-1, 1], len(largest))
        dx, state_slopes = core.jacobian(*case)
        y, output_slopes = core.outputs_jacobian(*case)
        np.testing.assert_allclose(dx, core.derivatives(*case), rtol=1e-13, atol=1e-13)
        np.testing.assert_allclose(y, core.outputs(*case), rtol=1e-13, atol=1e-13)
        slopes = np.vstack([state_slopes, output_slopes])
        terms = np.abs(slopes) @ np.abs(step)
        whole, half = slopes_along(step, *case)
        if np.all(np.abs(whole - half) <= 1e-6 * terms):
            smooth += 1
            assert np.all(np.abs(slopes @ step - (4 * half - whole) / 3) <= 2e-8 * terms)
    assert smooth > 0.97 * count
