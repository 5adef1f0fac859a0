"""Tables of cases: lattices against itertools, samples against SciPy's and NumPy's own and against closed forms."""

from itertools import product

import numpy as np
import pytest
from scipy import stats
from scipy.stats import qmc

from gtm_fmu.aircraft.failures import Failure
from gtm_fmu.aircraft.inputs import CHOICES, INPUTS, LIMITED, QUANTITIES, Column, failure
from gtm_fmu.aircraft.limits import ControlLimits, RateLimits
from gtm_fmu.aircraft.ranges import WIDEST
from gtm_fmu.core import solver
from gtm_fmu.core.configuration import Configuration
from gtm_fmu.datasets import axes, results
from gtm_fmu.datasets.axes import choices, failure_levels, levels, limit_levels, limits_span, span
from gtm_fmu.datasets.cases import CaseTable, GivenCases, Sampling
from gtm_fmu.datasets.lattice import lattice
from gtm_fmu.datasets.store import CaseStore, open_cases
from gtm_fmu.errors import InputError

RANDOM = [Sampling.RANDOM, Sampling.LATIN_HYPERCUBE, Sampling.SOBOL]
NAMES = [column.name for column in INPUTS]
CONDITIONS = (span("altitude", 0, 30000), span("gamma", -5, 5))


def column(table: CaseTable, name: str) -> np.ndarray:
    return table.rows(0, len(table))[:, NAMES.index(name)]


def sampled(*varied, sampling=Sampling.SOBOL, cases=1000, seed=3) -> CaseTable:
    return CaseTable.sampled([*CONDITIONS, *varied], sampling, cases, seed)


class TestColumns:
    def test_names_carry_the_unit(self):
        labels = [column.label for column in INPUTS]
        assert labels[:4] == ["altitude_ft", "gamma_deg", "elevator_lower_deg", "elevator_upper_deg"]
        assert labels[-2:] == ["throttle_lower_pct", "throttle_upper_pct"]

    def test_every_control_has_limits(self):
        assert len(INPUTS) == 2 + 2 * len(WIDEST)


class TestFailures:
    """What further columns mean."""

    def test_every_input(self):
        values = {
            "damage_case": 3.0,
            "engine_out": 2.0,
            "stabilizer": -2.0,
            "flaps": 20.0,
            "spoilers": 5.0,
            "gear": 0.5,
        }
        values |= {"fuel_used": 6.0, "elevator_rate": 100.0, "rudder_rate": 0.0}
        values |= {
            "aileron_lower": -3.0,
            "aileron_upper": 4.0,
            "throttle_right_lower": 10.0,
            "throttle_right_upper": 60.0,
        }
        assert failure(values) == Failure(
            ControlLimits(aileron_deg=(-3, 4)),
            Configuration(
                damage_case=3,
                engine_running=(True, False),
                stabilizer_deg=-2,
                flap_deg=(20,) * 4,
                spoiler_deg=(5,) * 4,
                gear=0.5,
                fuel_used_lb=6,
            ),
            throttle_right_pct=(10, 60),
            rate_limits=RateLimits(elevator_deg_s=100, rudder_deg_s=0),
        )

    def test_single_panels(self):
        """Left aileron jammed at 4 deg, upper rudder at half, flaps at 10 deg but for the left outboard one."""
        found = failure({"AILL_gain": 0.0, "AILL_offset": 4.0, "RUDU_gain": 0.5, "flaps": 10.0, "FLAPLOB": 0.0})
        assert found.configuration == Configuration(
            surface_gain=(1, 1, 1, 1, 0, 1, 0.5, 1),
            surface_offset_deg=(0, 0, 0, 0, 4, 0, 0, 0),
            flap_deg=(10, 0, 10, 10),
        )

    def test_nothing_is_the_undamaged_aircraft(self):
        assert failure({"altitude": 0.0, "gamma": 0.0}) == Failure()
        assert failure(dict(zip(NAMES, sampled().rows(0, 1)[0], strict=True))).airframe == solver.STUDY

    def test_every_axis_has_its_columns(self):
        """An axis on every input: columns in the order of their failures, the flight condition and airframe first."""
        varied = [limits_span(control, 0, 1) for control in reversed(LIMITED)]
        varied += [span(name, 0, 1) for name in QUANTITIES] + [choices(name, [0, 1, 3]) for name in CHOICES]
        table = CaseTable.sampled(varied, Sampling.SOBOL, 64)
        names = [column.name for column in table.columns]
        assert names[:4] == ["altitude", "gamma", "damage_case", "engine_out"]
        assert names[-3:] == ["elevator_rate", "aileron_rate", "rudder_rate"]
        assert len(set(names)) == len(names) == len(QUANTITIES) + len(CHOICES) + 2 * len(LIMITED)
        for row in table.rows(0, 64):
            value = dict(zip(names, row, strict=True))
            found = failure(value)
            assert value["damage_case"] == found.configuration.damage_case in (0, 1, 3)
            assert (value["throttle_left_lower"], value["throttle_left_upper"]) == found.throttle_left_pct
            assert (value["elevator_lower"], value["elevator_upper"]) == found.limits.elevator_deg
            assert value["aileron_rate"] == found.rate_limits.aileron_deg_s

    def test_cases_of_one_airframe_lie_together(self):
        varied = [levels("altitude", [0, 1]), levels("gamma", [0]), choices("damage_case", [0, 5])]
        table = CaseTable.lattice([failure_levels("rudder", [0, 1]), *varied])
        np.testing.assert_array_equal(
            table.rows(0, 12)[:, :3], np.repeat([[0, 0, 0], [0, 0, 5], [1, 0, 0], [1, 0, 5]], 3, 0)
        )


class TestLattice:
    def test_rows_are_the_product_with_the_last_axis_fastest(self):
        altitudes, gammas, jams = (0.0, 5000.0, 20000.0), (-2.0, 3.0), [(-5.0, -5.0), (0.0, 10.0), (2.0, 2.0)]
        table = CaseTable.lattice(
            [limit_levels("rudder", jams), levels("gamma", gammas), levels("altitude", altitudes)]
        )
        expected = [
            (h, gamma, -30, 30, -20, 20, lower, upper, 0, 100)
            for h, gamma, (lower, upper) in product(altitudes, gammas, jams)
        ]
        np.testing.assert_array_equal(table.rows(0, len(table)), expected)

    def test_failures_are_all_pairs_in_order(self):
        """28 pairs of the paper's seven levels: 7 jams and 21 restrictions (Table 3)."""
        pairs = failure_levels("rudder", [30, -30, 0, -20, -10, 10, 20]).values
        assert len(set(pairs)) == 28
        assert sum(lower == upper for lower, upper in pairs) == 7
        assert all(lower <= upper for lower, upper in pairs)

    def test_any_slice_of_a_lattice_too_large_for_memory(self):
        positions = np.linspace(0, 30000, 100)
        jams = [(x, x) for x in np.linspace(-20, 20, 100)]
        failing = [limit_levels(control, jams) for control in ("elevator", "aileron", "rudder")]
        table = CaseTable.lattice([levels("altitude", positions), levels("gamma", [0]), *failing])
        assert len(table) == 10**8
        last = table.rows(10**8 - 2, 10**8 + 5)
        np.testing.assert_array_equal(last[:, NAMES.index("rudder_lower")], [jams[-2][0], 20])
        np.testing.assert_array_equal(last[1], [30000, 0, 20, 20, 20, 20, 20, 20, 0, 100])


class TestGiven:
    """Cases row by row, as the points of a design are."""

    COLUMNS = (*INPUTS[:2], *INPUTS[6:8])
    ROWS = ((0.0, 1.0, -5.0, 5.0), (30000.0, -5.0, 30.0, 30.0), (1.0, 0.0, -30.0, 0.5))

    def test_rows_are_those_given(self):
        table = GivenCases(self.COLUMNS, np.array(self.ROWS))
        assert len(table) == 3
        np.testing.assert_array_equal(table.rows(1, 9), self.ROWS[1:])
        assert table.describe() != GivenCases(self.COLUMNS, np.array(self.ROWS[::-1])).describe()

    def test_a_store_of_them(self, tmp_path):
        """What the solver finds, in the order that was given."""
        table = GivenCases(self.COLUMNS, np.array(self.ROWS))
        names, options = [column.name for column in self.COLUMNS], {"alpha_deg": [-5.0, 10.5]}
        found = results.evaluate(table.rows(0, 3), inputs=names)
        store = CaseStore(tmp_path / "given.zarr", table, options)
        for cases in store.unfinished():
            store.write(cases, found)
        kept = open_cases(tmp_path / "given.zarr")
        np.testing.assert_array_equal(kept.rudder_upper, [5.0, 30.0, 0.5])
        np.testing.assert_array_equal(kept.v_max, found["v_max"])
        with pytest.raises(InputError, match="with other options"):
            CaseStore(tmp_path / "given.zarr", GivenCases(self.COLUMNS, np.array(self.ROWS[::-1])), options)

    @pytest.mark.parametrize(
        ("columns", "rows", "message"),
        [
            (COLUMNS, ROWS[0], "give one each"),
            (COLUMNS, (), "give one each"),
            (COLUMNS[:3], ROWS, "give one each"),
            ((*COLUMNS[:3], COLUMNS[2]), ROWS, "given twice"),
            ((*COLUMNS[:3], Column("weather", "")), ROWS, "no input 'weather'"),
            ((*COLUMNS[:3], Column("rudder", "deg")), ROWS, "no input 'rudder'"),
            ((*COLUMNS[1:], INPUTS[2]), ROWS, "No altitude was given"),
            (COLUMNS, (*ROWS, (0.0, 0.0, np.nan, 0.0)), "Case 3 lacks a number"),
        ],
    )
    def test_what_is_no_table(self, columns, rows, message):
        with pytest.raises(InputError, match=message):
            GivenCases(columns, np.array(rows))


class TestBlocks:
    def test_paper_lattice_is_cut_between_flight_conditions(self):
        """28 failures at each of 11 flight-path angles and 4 altitudes."""
        failures = failure_levels("rudder", range(-30, 31, 10))
        table = CaseTable.lattice([levels("altitude", range(4)), levels("gamma", range(11)), failures])
        assert [table.block(largest) for largest in (27, 32, 64, 1024, 5000)] == [27, 28, 56, 3 * 308, 4 * 1232]
        conditions = table.rows(0, len(table))[:, :2]
        for start in range(0, len(table), table.block(32)):
            assert len(np.unique(conditions[start : start + table.block(32)], axis=0)) == 1

    def test_samples_are_cut_anywhere(self):
        assert sampled().block(32) == 32


class TestSamples:
    @pytest.mark.parametrize("sampling", RANDOM)
    def test_the_same_in_any_slices(self, sampling):
        table = sampled(limits_span("rudder", -30, 30, 0.3), sampling=sampling, cases=1003)
        again = sampled(limits_span("rudder", -30, 30, 0.3), sampling=sampling, cases=1003)
        last_first = [again.rows(start, start + 17) for start in reversed(range(0, 1003, 17))]
        np.testing.assert_array_equal(table.rows(0, 1003), np.concatenate(last_first[::-1]))
        np.testing.assert_array_equal(table.rows(500, 520), again.rows(0, 1003)[500:520])

    @pytest.mark.parametrize("sampling", RANDOM)
    def test_another_seed_gives_other_cases(self, sampling):
        one, other = (column(sampled(sampling=sampling, seed=seed), "altitude") for seed in (0, 1))
        assert not np.isin(one, other).any()

    def test_random_is_numpys_default_stream(self):
        table = sampled(limits_span("elevator", -30, 30, 1.0), sampling=Sampling.RANDOM, cases=200, seed=7)
        unit = np.random.default_rng(7).random((200, 4))
        np.testing.assert_array_equal(column(table, "altitude"), 30000 * unit[:, 0])
        np.testing.assert_array_equal(column(table, "elevator_upper"), -30 + unit[:, 3] * 60)

    @pytest.mark.filterwarnings("ignore:The balance properties")
    def test_sobol_is_scipys_sequence(self):
        unit = qmc.Sobol(2, rng=3).random(777)
        np.testing.assert_array_equal(column(sampled(cases=777), "gamma"), -5 + unit[:, 1] * 10)

    def test_latin_hypercube_has_one_case_in_each_layer(self):
        table = sampled(sampling=Sampling.LATIN_HYPERCUBE, cases=500)
        for name, lower, width in (("altitude", 0, 30000), ("gamma", -5, 10)):
            layer = np.floor((column(table, name) - lower) / width * 500)
            np.testing.assert_array_equal(np.sort(layer), np.arange(500))

    def test_levels_are_drawn_equally_often(self):
        table = CaseTable.sampled([levels("altitude", [0, 100, 200, 300]), CONDITIONS[1]], Sampling.SOBOL, 1024)
        values, count = np.unique(column(table, "altitude"), return_counts=True)
        np.testing.assert_array_equal(values, [0, 100, 200, 300])
        np.testing.assert_array_equal(count, 256)

    def test_what_is_held_or_not_given(self):
        table = sampled(limit_levels("rudder", [(-10, 20)]), limits_span("aileron", 5, 5))
        expected = {"rudder_lower": -10, "rudder_upper": 20, "aileron_lower": 5, "aileron_upper": 5}
        for name, value in (expected | {"elevator_lower": -30, "throttle_upper": 100}).items():
            np.testing.assert_array_equal(column(table, name), value)


class TestLimits:
    """Pairs uniform over the triangle a <= lower <= upper <= b: closed forms on [-30, 30]."""

    def limits(self, jam_share: float, sampling=Sampling.RANDOM, cases=20000) -> tuple[np.ndarray, np.ndarray]:
        table = sampled(limits_span("rudder", -30, 30, jam_share), sampling=sampling, cases=cases)
        return column(table, "rudder_lower"), column(table, "rudder_upper")

    def test_density_is_uniform_on_the_triangle(self):
        lower, upper = self.limits(0.0)
        assert (lower <= upper).all()
        assert (lower >= -30).all()
        assert (upper <= 30).all()
        # The marginals are 1 - (1 - a)^2 and b^2, the width has 1 - (1 - w)^2, and the covariance is 60^2 / 36.
        for values, cdf in (
            ((lower + 30) / 60, lambda a: 1 - (1 - a) ** 2),
            ((upper + 30) / 60, lambda b: b**2),
            ((upper - lower) / 60, lambda w: 1 - (1 - w) ** 2),
        ):
            assert stats.kstest(values, cdf).pvalue > 0.01
        assert np.cov(lower, upper)[0, 1] == pytest.approx(100, rel=0.03)

    @pytest.mark.parametrize("sampling", [Sampling.LATIN_HYPERCUBE, Sampling.SOBOL])
    def test_share_of_jams(self, sampling):
        lower, upper = self.limits(0.25, sampling, 4096)
        assert (lower == upper).sum() == pytest.approx(1024, abs=1)
        jams, rest = lower[lower == upper], lower[lower < upper]
        assert stats.kstest((jams + 30) / 60, "uniform").pvalue > 0.01
        assert stats.kstest((rest + 30) / 60, lambda a: 1 - (1 - a) ** 2).pvalue > 0.01

    def test_nothing_but_jams(self):
        lower, upper = self.limits(1.0, cases=2000)
        np.testing.assert_array_equal(lower, upper)
        assert stats.kstest((lower + 30) / 60, "uniform").pvalue > 0.01

    def test_upper_bound_is_kept_in_rounding(self):
        axis = limits_span("throttle", 0.1, 0.3)
        assert axis.at(np.array([[np.nextafter(1, 0), np.nextafter(1, 0)]])).max() <= 0.3


class TestDescription:
    def test_equal_tables_have_equal_words_and_others_do_not(self):
        def table(sampling=Sampling.SOBOL, cases=10, seed=0, top=20000, share=0.1, rudder=30):
            varied = [span("altitude", 0, top), levels("gamma", [0, 1]), limits_span("rudder", -30, rudder, share)]
            return CaseTable.sampled(varied, sampling, cases, seed)

        made = table().describe()
        assert made == table().describe()
        changes = ({"sampling": Sampling.RANDOM}, {"cases": 11}, {"seed": 1}, {"top": 1}, {"share": 0.2}, {"rudder": 1})
        for change in changes:
            differs = table(**change).describe()
            assert sum(made[name] != differs[name] for name in made) == 1

    def test_words(self):
        made = CaseTable.lattice([levels("altitude", [0]), levels("gamma", [-1, 1]), failure_levels("rudder", [1, 2])])
        assert made.describe() == {
            "sampling": "lattice",
            "cases": 6,
            "axis_altitude": "held at [0.0]",
            "axis_gamma": "one of [-1.0, 1.0]",
            "axis_elevator": "held at [[-30.0, 30.0]]",
            "axis_aileron": "held at [[-20.0, 20.0]]",
            "axis_rudder": "one of [[1.0, 1.0], [1.0, 2.0], [2.0, 2.0]]",
            "axis_throttle": "held at [[0.0, 100.0]]",
        }


class TestBadInput:
    @pytest.mark.parametrize(
        ("make", "sentence"),
        [
            (lambda: span("altitude", 5, 1), "altitude in ft 5 1 are reversed; give the lower one first."),
            (lambda: span("gamma", np.nan, 1), "gamma in deg nan is outside -45 .. 45"),
            (lambda: span("altitude", 0, np.inf), "altitude in ft inf is outside 0 .. 36089"),
            (lambda: levels("altitude", []), "The lattice is empty: no level of altitude"),
            (lambda: levels("gamma", [0, "x"]), "gamma in deg 'x' is not a number"),
            (lambda: failure_levels("rudder", []), "The lattice is empty: no level of rudder"),
            (lambda: failure_levels("aileron", [0, 21]), "aileron in deg 21 is outside -20 .. 20"),
            (lambda: limit_levels("rudder", [(0, 1), (2, 1)]), "rudder in deg 2 1 are reversed"),
            (lambda: limits_span("throttle", 100, 0), "throttle in % 100 0 are reversed"),
            (lambda: limits_span("rudder", -30, 30, 1.1), "Share of jams 1.1 is outside 0 .. 1"),
            (lambda: limits_span("rudder", -30, 30, np.nan), "Share of jams nan is outside 0 .. 1"),
            (lambda: span("fuel_used", 0, 21), "fuel used in lb 21 is outside 0 .. 20"),
            (lambda: levels("gear", [2]), "gear 2 is outside 0 .. 1"),
            (lambda: choices("damage_case", [7]), "damage case 7 does not exist; give a whole number from 0 to 6."),
            (lambda: choices("engine_out", [0.5]), "engine out 0.5 does not exist"),
            (lambda: choices("damage_case", []), "The lattice is empty: no level of damage_case"),
            (lambda: choices("damage_case", [1, 1]), "damage case 1 was given twice"),
            (lambda: levels("rudder", [1]), "There is no such input as 'rudder' here; choose one of altitude, gamma,"),
            (lambda: limits_span("flap", 0, 1), "There is no such input as 'flap' here; choose one of elevator,"),
            (lambda: sampled(cases=0), "0 cases were asked for; ask for at least one."),
            (lambda: sampled(seed=-1), "The seed -1 is negative; give 0 or more."),
            (lambda: sampled(CONDITIONS[0]), "altitude was given twice"),
            (lambda: CaseTable.sampled([CONDITIONS[0]], Sampling.SOBOL, 5), "No gamma was given"),
            (lambda: CaseTable.lattice(CONDITIONS), "altitude has no levels"),
            (
                lambda: CaseTable.sampled([levels("altitude", [0]), levels("gamma", [0])], Sampling.RANDOM, 5),
                "Every input is held at one value",
            ),
            (lambda: sampled(sampling=Sampling.LATIN_HYPERCUBE, cases=10**7 + 1), "take up to 10000000, or sobol."),
            (lambda: sampled(cases=10**8 + 1), "A data set of 100000001 cases is too large; take up to 100000000"),
            (lambda: sampled(Sampling.RANDOM, cases=10**12), "A data set of 1000000000000 cases is too large"),
            (lambda: failure_levels("rudder", np.linspace(-30, 30, 10**5)), "5000050000 levels or pairs of levels of"),
            (lambda: levels("altitude", np.zeros(250_001)), "250001 levels or pairs of levels of altitude are too"),
            (
                lambda: CaseTable.lattice([levels("altitude", np.zeros(10_001)), levels("gamma", np.zeros(10_000))]),
                "A data set of 100010000 cases is too large; take up to 100000000",
            ),
        ],
    )
    def test_one_sentence(self, make, sentence):
        with pytest.raises(InputError) as refused:
            make()
        assert sentence in str(refused.value)
        assert "\n" not in str(refused.value)

    def test_widest_ranges_are_taken(self):
        for control, (lower, upper) in zip(("elevator", "aileron", "rudder", "throttle"), WIDEST.values(), strict=True):
            assert axes.limits_span(control, lower, upper).dimensions == 2


def test_lattice_of_pairs_is_that_of_their_levels():
    """All pairs of the levels, given one by one: the same cases in the same order."""
    pairs = lattice((0.0, 20000.0), (3.0,), [(-10.0, -10.0), (-10.0, 0.0), (0.0, 0.0)])
    table = CaseTable.lattice(
        [levels("altitude", [0, 20000]), levels("gamma", [3]), failure_levels("rudder", [-10, 0])]
    )
    np.testing.assert_array_equal(pairs.rows(0, len(pairs)), table.rows(0, len(table)))
