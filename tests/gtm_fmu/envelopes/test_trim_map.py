"""The trim map against linear programs, exact envelopes, and its own promises."""

import json

import numpy as np
import pytest
from scipy.optimize import linprog

from gtm_fmu.aircraft.failures import Failure
from gtm_fmu.aircraft.limits import ControlLimits
from gtm_fmu.airframe.atmosphere import atmosphere
from gtm_fmu.airframe.names import CONTROLS
from gtm_fmu.envelopes.envelope import envelope
from gtm_fmu.envelopes.trim_map import SURFACES, TrimMap, TrimNodes
from gtm_fmu.errors import InputError
from tests.reference import spec_values

WIDEST = {"elevator": (-30.0, 30.0), "aileron": (-20.0, 20.0), "rudder": (-30.0, 30.0)}  # SPEC 9, deg
WIDE = 1e-9  # kt: rounding


@pytest.fixture(scope="module")
def solved() -> TrimMap:
    return TrimMap.solve()


# Value = constant + slopes . (alpha, bank, rudder), all in deg; loading in 1/kn^2, drag in lbf/kn^2.
LINEAR = {
    "loading": (5e-5, (2.4e-5, 2e-7, -3e-7)),
    "drag": (6e-4, (6e-5, 3e-6, 4e-6)),
    "elevator": (4.0, (-0.6, 0.03, 0.02)),
    "aileron": (0.5, (0.2, 0.4, -0.7)),
}


def linear_map() -> TrimMap:
    """A map whose values are linear, so that interpolation loses nothing."""
    nodes = TrimNodes((0.0,), (0.0,), (0.0, 2.0, 5.0, 10.5), (-30.0, -10.0, 30.0), (-30.0, 0.0, 7.0, 30.0))
    axes = tuple(np.array(axis, dtype=float) for axis in ((1.0,), *nodes[1:]))
    grid = np.meshgrid(*axes[2:], indexing="ij")
    values = [constant + sum(k * x for k, x in zip(slopes, grid, strict=True)) for constant, slopes in LINEAR.values()]
    return TrimMap(nodes, axes, np.stack(values, axis=-1)[None, None].astype(np.float32))


def by_linear_program(limits: dict, thrust_lbf: tuple[float, float]) -> tuple[float, float] | None:
    """Slowest and fastest speed of the linear map: 1 / V^2 is extreme under linear limits."""
    rows, ends = [], []

    def add(constant, slopes, upper):
        rows.append(slopes)
        ends.append(upper - constant)

    for name in ("elevator", "aileron"):
        constant, slopes = LINEAR[name]
        add(constant, np.array(slopes), limits[name][1])
        add(-constant, -np.array(slopes), -limits[name][0])
    (loading, by_loading), (drag, by_drag) = LINEAR["loading"], LINEAR["drag"]
    for sign, thrust in ((1, thrust_lbf[1]), (-1, thrust_lbf[0])):  # sign (drag - thrust loading) <= 0
        add(sign * (drag - thrust * loading), sign * (np.array(by_drag) - thrust * np.array(by_loading)), 0.0)
    bounds = [(0.0, 10.5), (-30.0, 30.0), limits["rudder"]]
    scaled = np.array(rows) * 1e3, np.array(ends) * 1e3
    found = [linprog(sign * np.array(by_loading) * 1e5, *scaled, bounds=bounds) for sign in (-1, 1)]
    if found[0].status == 2:
        return None
    slow, fast = (loading + float(np.dot(by_loading, end.x)) for end in found)
    return slow**-0.5, fast**-0.5


@pytest.mark.parametrize("seed", range(6))
def test_a_linear_map_has_the_extremes_of_linear_programs(seed):
    """Jams and ranges by chance of all controls, 40 a seed; full thrust and idle are those of the specification."""
    rng, found_any, none = np.random.default_rng(seed), 0, 0
    full = 2 * next(float(row.thrust[2]) for row in spec_values.ATMOSPHERE if row.h == 0)
    linear = linear_map()
    for _ in range(40):
        limits = {}
        for name, (least, most) in (("elevator", (-3.0, 5.0)), ("aileron", (-20, 20)), ("rudder", (-30, 30))):
            limits[name] = tuple(np.sort(rng.uniform(least, most, 2)).tolist())
            if rng.random() < 0.3:
                limits[name] = (limits[name][0],) * 2
        case = [0.0, 0.0, *(end for name in WIDEST for end in limits[name])]
        mapped = linear.predict([case], list(WIDEST))
        expected = by_linear_program(limits, (1.755, full))
        assert mapped.feasible[0] == (expected is not None)
        if expected is None:
            none += 1
            continue
        found_any += 1
        assert (mapped.v_min_kt[0], mapped.v_max_kt[0]) == pytest.approx(expected, rel=3e-4)
    assert found_any >= 5
    assert none >= 3


def random_cases(number: int, seed: int, jam_share: float) -> np.ndarray:
    """Altitude, gamma and limits of elevator, aileron and rudder; the elevator where it leaves something."""
    rng = np.random.default_rng(seed)
    columns = [rng.uniform((0, -5), (30000, 5), (number, 2))]
    for least, most in ((-6.0, 5.0), (-20.0, 20.0), (-30.0, 30.0)):
        ends = np.sort(rng.uniform(least, most, (number, 2)))
        jams = rng.random(number) < jam_share
        ends[jams, 1] = ends[jams, 0]
        columns.append(ends)
    return np.hstack(columns)


@pytest.mark.parametrize("controls", [("rudder", "aileron"), SURFACES, ("elevator",)], ids=["two", "three", "one"])
def test_it_agrees_with_exact_envelopes(solved, controls):
    """Ranges and jams of one, two and three controls: half of the errors below 0.2 kn, all but one below 2 kn."""
    cases = random_cases(14, 3, 0.3)
    ordered = [name for name in CONTROLS if name in controls]
    places = [k for name in ordered for k in (2 + 2 * CONTROLS.index(name), 3 + 2 * CONTROLS.index(name))]
    asked = cases[:, [0, 1, *places]]
    found = solved.predict(asked, ordered)
    errors, same = [], 0
    for row, feasible, *speeds in zip(asked, found.feasible, found.v_min_kt, found.v_max_kt, strict=True):
        limits = {f"{name}_deg": tuple(row[2 + 2 * k : 4 + 2 * k]) for k, name in enumerate(ordered)}
        exact = envelope(row[0], row[1], Failure(ControlLimits(**limits)))
        same += exact.feasible == feasible
        if exact.feasible and feasible:
            errors += [abs(speeds[0] - exact.v_min_kt), abs(speeds[1] - exact.v_max_kt)]
    assert same == len(asked)
    assert len(errors) >= 8
    assert np.median(errors) < 0.2
    assert np.sort(errors)[-2] < 2.0


def test_wider_limits_never_shrink_an_envelope(solved):
    rng = np.random.default_rng(0)
    narrow = random_cases(300, 1, 0.4)
    wide = narrow.copy()
    for k, (least, most) in enumerate(WIDEST.values()):
        wide[:, 2 + 2 * k] -= rng.random(300) * (wide[:, 2 + 2 * k] - least) * (rng.random(300) < 0.5)
        wide[:, 3 + 2 * k] += rng.random(300) * (most - wide[:, 3 + 2 * k]) * (rng.random(300) < 0.5)
    inner, outer = solved.predict(narrow, SURFACES), solved.predict(wide, SURFACES)
    both = inner.feasible
    assert 30 < both.sum() < 280
    assert outer.feasible[both].all()
    assert (outer.v_min_kt[both] <= inner.v_min_kt[both] + WIDE).all()
    assert (outer.v_max_kt[both] >= inner.v_max_kt[both] - WIDE).all()


def test_order_and_company_change_nothing(solved):
    """Cases of one condition share work; controls come in any order; a free control need not be named."""
    cases = np.tile(random_cases(1, 5, 0.0), (6, 1))
    cases[3:, 0] += 1000.0
    cases[:, 2:4] = -30.0, 30.0
    whole = solved.predict(cases, SURFACES)
    assert whole.v_min_kt[0] == whole.v_min_kt[2] != whole.v_min_kt[3] == whole.v_min_kt[5]
    swapped = solved.predict(cases[:, [0, 1, 6, 7, 4, 5]], ("rudder", "aileron"))
    assert np.array_equal(swapped.v_max_kt, whole.v_max_kt)
    one = solved.predict_one(
        *cases[0, :2], ControlLimits(aileron_deg=tuple(cases[0, 4:6]), rudder_deg=tuple(cases[0, 6:]))
    )
    assert json.loads(json.dumps(one)) == {name: column[0] for name, column in whole._asdict().items()}


def test_less_thrust_and_less_bank(solved):
    """With both engines at idle no level flight is left, a glide is; a smaller bank leaves no more."""
    idle = solved.predict([[0.0, 0.0, 0.0, 0.0], [0.0, -5.0, 0.0, 30.0]], ("throttle",))
    assert idle.feasible.tolist() == [False, True]
    case, names = [[5000.0, 0.0, 8.0, 12.0]], ("rudder",)
    wide, level = solved.predict(case, names), solved.predict(case, names, phi_deg=(-5.0, 5.0))
    assert level.v_min_kt[0] >= wide.v_min_kt[0]
    assert level.v_max_kt[0] <= wide.v_max_kt[0]


def test_domain(solved):
    found = solved.predict([[36089.0, 5.0], [0.0, 5.01]], ())
    assert found.in_domain.tolist() == [True, False]
    assert float(atmosphere(36089.0).density) > 0  # the map reaches the tropopause


@pytest.mark.parametrize(
    ("case", "controls", "said"),
    [
        ([-1.0, 0.0, 0.0, 0.0], ("rudder",), "altitude in ft"),
        ([0.0, np.nan, 0.0, 0.0], ("rudder",), "gamma in deg"),
        ([0.0, 0.0, 0.0, 31.0], ("rudder",), "rudder in deg"),
        ([0.0, 0.0, 5.0, 4.0], ("aileron",), "aileron: limits are reversed"),
        ([0.0, 0.0, 0.0], ("rudder",), "lower and upper limit of each"),
        ([0.0, 0.0, 0.0, 0.0], ("flaps",), "give some of elevator, aileron, rudder, throttle"),
        ([0.0, 0.0, 0.0, 0.0, 0.0, 0.0], ("rudder", "rudder"), "each once"),
    ],
)
def test_bad_cases_are_refused(solved, case, controls, said):
    with pytest.raises(InputError, match=said):
        solved.predict([case], controls)


@pytest.mark.parametrize("nodes", [{"banks_deg": (0.0,)}, {"rudders_deg": (30.0, -30.0)}, {"gammas_deg": (5.0, 0.0)}])
def test_bad_nodes_are_refused(nodes):
    with pytest.raises(InputError, match="must rise"):
        TrimMap.solve(TrimNodes()._replace(**nodes))
