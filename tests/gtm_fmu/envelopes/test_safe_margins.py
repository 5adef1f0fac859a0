"""Safe speeds of a thrust map: margins by hand, where nothing is promised, and the promise on known errors."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import binom

from gtm_fmu.core.map_layout import GROUPS
from gtm_fmu.datasets import calibration
from gtm_fmu.envelopes.safe_margins import EPSILONS, SafeMargins
from gtm_fmu.envelopes.thrust_map import THRUST_MAPS, ThrustMap
from gtm_fmu.errors import InputError

EXACT = Path(__file__).with_name("safe_margins.npz")
"""Cases of the seed that no map was calibrated on, with their exact ends."""
LEVEL = EPSILONS.index(0.001)
JAM, RANGE, FOLDED_JAM, FOLDED_RANGE = range(len(GROUPS))
CASES = np.array([[10000.0, 0.0, 7.0, 7.0], [10000.0, 0.0, -5.0, 12.0], [20000.0, -3.0, -30.0, 30.0]])


@pytest.fixture(scope="module")
def plain() -> ThrustMap:
    """The rudder's with every twelfth deflection and every fourth speed, which is quick; not calibrated."""
    shipped = ThrustMap.load()
    table = shipped.table[:, :, ::12][..., [0, 1, *range(2, shipped.table.shape[-1], 4)]]
    return replace(shipped, deflection_deg=shipped.deflection_deg[::12], table=table, safe=None)


def with_margins(thrust_map: ThrustMap, margins) -> ThrustMap:
    """With the same margins (groups, 2) at all levels."""
    cases = [100_000] * len(GROUPS)
    return replace(thrust_map, safe=SafeMargins(np.tile(margins, (len(EPSILONS), 1, 1)), cases))


def folds(thrust_map: ThrustMap) -> np.ndarray:
    """Cases at folds of the map (n, 4)."""
    cases = np.random.default_rng(5).uniform((0, -5, -30, -30), (36089, 5, 30, 30), (20_000, 4))
    cases[:, 2:].sort(axis=1)
    cases[::2, 3] = cases[::2, 2]
    return cases[thrust_map.predict(cases).fold]


def test_margins_are_the_largest_scores_but_a_few():
    """Of 1999 scores k/1000 - 1 the second largest at 0.001, the largest at 0.0005; fewer carry no stricter level."""
    scores = np.random.default_rng(0).permutation(1999) / 1000 - 1
    found = SafeMargins.of_scores(np.column_stack([scores, -scores]), np.zeros(1999, dtype=int))
    assert found.cases.tolist() == [1999, 0, 0, 0]
    assert found.margins[LEVEL, JAM] == pytest.approx([0.997, 0.999])
    assert found.margins[LEVEL + 1, JAM] == pytest.approx([0.998, 1.0])
    assert np.isinf(found.margins[LEVEL + 2 :, JAM]).all()
    assert np.isinf(found.margins[:, RANGE:]).all()


def test_margins_are_never_negative():
    """A prediction that errs on the safe side only is not moved outwards."""
    assert SafeMargins.of_scores(np.full((100, 2), -3.0), np.zeros(100, dtype=int)).margins[0, JAM].tolist() == [0, 0]


def test_ends_move_inwards_by_deviations(plain):
    margins = np.array([[3.0, 2.0], [1.0, 4.0], [0.5, 0.25], [0.125, 0.75]])
    cases = np.concatenate([CASES, folds(plain)])
    group = plain.groups(cases)
    assert group[:3].tolist() == [JAM, RANGE, RANGE]
    assert {FOLDED_JAM, FOLDED_RANGE, -1} <= set(group.tolist())
    found = with_margins(plain, margins).predict(cases)
    v_min = found.v_min_kt + margins[group, 0] * found.v_min_std_kt
    v_max = found.v_max_kt - margins[group, 1] * found.v_max_std_kt
    promised = (group >= 0) & (v_min <= v_max)
    assert found.feasible_safe.tolist() == promised.tolist()
    np.testing.assert_allclose(found.v_min_safe_kt, np.where(promised, v_min, np.nan), rtol=1e-14)
    np.testing.assert_allclose(found.v_max_safe_kt, np.where(promised, v_max, np.nan), rtol=1e-14)


def test_where_nothing_is_promised(plain):
    """With too little thrust to spare, outside the map, with margins that meet, or none."""
    nothing = with_margins(plain, np.zeros((4, 2)))
    edges = folds(plain)
    spare = plain.predict(edges).spare_thrust_lbf
    doubtful = edges[(spare >= 0) & (spare < plain.tolerances.thrust_lbf)]
    assert len(doubtful) > 3
    assert plain.predict(doubtful).feasible.all()
    outside = np.array([[10000.0, 7.0, 0.0, 0.0]])
    for thrust_map, cases in (
        (nothing, np.concatenate([doubtful, outside])),
        (with_margins(plain, np.full((4, 2), 1e6)), CASES),
        (plain, CASES),
    ):
        found = thrust_map.predict(cases)
        assert found.feasible.all()
        assert not found.feasible_safe.any()
        assert np.isnan([found.v_min_safe_kt, found.v_max_safe_kt]).all()
    assert nothing.predict(CASES).feasible_safe.all()


def test_epsilon(plain):
    """Between two levels the stricter one; what the calibration cannot carry is refused with what it would need."""
    margins = np.arange(1.0, len(EPSILONS) + 1)[:, None, None] * np.ones((len(GROUPS), 2))
    safe = replace(plain, safe=SafeMargins(margins, [5000, 4000, 10, 0]))
    assert [safe.margins(epsilon)[0, 0] for epsilon in (0.2, 0.1, 0.09, 0.001, 0.0009)] == [1, 1, 2, 7, 8]
    assert safe.predict_one(10000.0, 0.0, (7.0, 7.0))["v_min_safe_kt"] == pytest.approx(
        safe.predict(CASES[:1], 0.001).v_min_safe_kt[0], abs=0
    )
    for epsilon, needed in ((0.0001, 9999), (0.00001, 99999)):
        with pytest.raises(InputError, match=rf"needs {needed} calibration cases a group.* has 5000"):
            safe.predict(CASES, epsilon)
    for thrust_map in (safe, plain):
        with pytest.raises(InputError, match="between 0 and 1"):
            thrust_map.predict(CASES, 1.5)


def test_a_file_holds_the_margins(plain, tmp_path):
    margins = np.random.default_rng(0).uniform(0, 4, (len(EPSILONS), len(GROUPS), 2))
    margins[5:, FOLDED_JAM] = np.inf
    safe = replace(plain, safe=SafeMargins(margins, [9, 8, 7, 6]))
    again = ThrustMap.load(safe.save(tmp_path / "map.npz"))
    assert again.safe is not None
    assert np.array_equal(again.safe.margins, margins)
    assert again.safe.cases.tolist() == [9, 8, 7, 6]
    assert ThrustMap.load(plain.save(tmp_path / "plain.npz")).safe is None
    for wrong in (-margins, margins[:, :3], margins * np.nan):
        with pytest.raises(InputError, match="Safe margins have margins of the shape"):
            SafeMargins(wrong, [9, 8, 7, 6])


def test_draws_are_the_first_of_each_group(plain):
    """Few at folds, so many as were asked for elsewhere, spread over the whole map."""
    many = calibration.draw(plain, 10**9, 20_000, seed=5)
    cases = calibration.draw(plain, 600, 20_000, seed=5)
    group = plain.groups(cases)
    counts = np.bincount(group, minlength=len(GROUPS))
    assert counts[:2].tolist() == [600, 600]
    assert (counts[2:] > 5).all()
    assert (counts[2:] < 600).all()
    for number in range(len(GROUPS)):
        assert np.array_equal(cases[group == number], many[plain.groups(many) == number][:600])
    altitude, gamma, lower, upper = many.T
    assert ((lower == upper) == (plain.groups(many) % 2 == JAM)).all()
    for values, ends in ((gamma, (-5, 5)), (altitude, plain.altitude_ft), (lower, (-30, 30)), (upper, (-30, 30))):
        assert np.quantile(values, (0.0, 1.0)) == pytest.approx(ends, abs=0.05 * np.ptp(ends))


def made_up(thrust_map: ThrustMap, seed: int, share_without: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Cases of a map, and ends that err by heavy-tailed deviations; a share of those without a fold has none."""
    cases = calibration.draw(thrust_map, 10**9, 10_000, seed)
    found, rng = thrust_map.predict(cases), np.random.default_rng(seed)
    noise = rng.standard_t(3, (len(cases), 2)) * np.column_stack([found.v_min_std_kt, found.v_max_std_kt])
    ends = np.column_stack([found.v_min_kt, found.v_max_kt]) + noise
    ends[rng.random(len(cases)) < share_without] = np.nan
    return cases, ends


@pytest.mark.slow
def test_the_promise_holds_on_errors_of_any_kind(plain):
    """Some 8000 new cases, Student's t with 3 degrees of freedom: broken by 0.1 % at most, within four deviations.

    Without the margins 2.5 % of Student's t lie beyond 3.18 deviations (tables); the margins are those at 0.1 %, 10.2.
    """
    safe = calibration.calibrated(plain, *made_up(plain, 1), seed=1)
    assert safe.safe is not None
    assert safe.provenance[calibration.SAFE]["cases"]["jams"] == safe.safe.cases[JAM] > 2500
    assert safe.safe.margins[LEVEL, :2] == pytest.approx(10.2, rel=0.5)
    checked = calibration.check(safe, *made_up(plain, 2))
    for group in GROUPS[:2]:
        found = checked[group]
        assert found["safe"] > 2500
        assert found["no_envelope"] == 0
        for end in ("v_min", "v_max"):
            assert found[f"broken_{end}"] <= 0.001 * found["safe"] + 4 * np.sqrt(2 * 0.001 * found["safe"])
            assert found[f"price_{end}_kt"] > 0


@pytest.mark.slow
def test_what_does_not_exist_is_a_broken_promise(plain):
    """Where one case in a hundred has no envelope nothing is promised at 0.1 %, and something at 5 %."""
    safe = calibration.calibrated(plain, *made_up(plain, 1, share_without=0.01))
    assert not safe.predict(CASES).feasible_safe.any()
    assert safe.predict(CASES, 0.05).feasible_safe.all()
    checked = calibration.check(safe, *made_up(plain, 2, share_without=0.01), epsilon=0.05)["ranges"]
    for name, share in (("no_envelope", 0.01), ("broken_v_min", 0.05)):
        expected = share * checked["safe"]
        assert abs(checked[name] - expected) < 4 * np.sqrt(2 * expected)  # both samples vary


@pytest.mark.parametrize("control", THRUST_MAPS)
def test_the_maps_of_the_package_keep_their_promise(control):
    """Exact cases of another seed, first of each group: no more broken promises than chance allows in 1 of 10 000."""
    shipped = ThrustMap.load(THRUST_MAPS[control])
    with np.load(EXACT) as content:
        cases, exact = content[f"{control}_cases"], content[f"{control}_ends_kt"]
    assert len(cases) >= 400
    for epsilon in (0.1, 0.01, 0.001):
        for found in calibration.check(shipped, cases, exact, epsilon).values():
            most = binom.ppf(0.9999, found["safe"], epsilon)
            assert max(found["broken_v_min"], found["broken_v_max"], found["no_envelope"]) <= most
    found = calibration.check(shipped, cases, exact)
    for group in GROUPS[:2]:
        assert found[group]["safe"] > 0.9 * found[group]["cases"] > 150
        assert 0 < found[group]["price_v_max_kt"] < 2


def test_the_rudder_s_map_promises_at_folds_too():
    """10^5 exact cases set its margins; at its folds, which are flagged, safe speeds are told with wide ones."""
    safe = ThrustMap.load().safe
    assert safe.cases.sum() >= 100_000
    assert np.isfinite(safe.at(0.001)).all()
    assert (safe.at(0.0001)[:2] < 20).all()
