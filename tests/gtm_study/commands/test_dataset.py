"""The command `gtm-fmu dataset`: the options that become cases, what it prints, what it refuses."""

import json
import sys
from itertools import product

import numpy as np
import pandas as pd
import pytest
from distributed import LocalCluster

from gtm_fmu.aircraft.failures import Failure
from gtm_fmu.aircraft.limits import ControlLimits
from gtm_fmu.core.configuration import Configuration
from gtm_fmu.datasets.results import limit_names
from gtm_fmu.datasets.store import open_cases
from gtm_fmu.envelopes.envelope import envelope
from gtm_study.paper import lattice as paper_lattice
from gtm_study.paper import published

pytestmark = pytest.mark.slow

TWO_CONDITIONS = "--sampling lattice --altitude-ft 0 10000 --altitude-levels 2 --gamma-deg 1 1"
DATASETS = "gtm_fmu.datasets"
JAM = "--rudder-deg 5 5"


@pytest.fixture(scope="module")
def address():
    with LocalCluster(1, 2, processes=False, protocol="tcp://", dashboard_address=":0") as cluster:
        yield cluster.scheduler_address


@pytest.fixture
def dataset(ask, tmp_path, address):
    """The command on a store named a.zarr, over a cluster in this process."""

    def run(options: str):
        return ask("dataset", tmp_path / "a.zarr", "--scheduler", address, *options.split())

    return run


class TestCases:
    def test_values_are_the_envelopes(self, dataset, tmp_path):
        answer = dataset(f"{TWO_CONDITIONS} {JAM} --held-aileron-deg -10 15 --phi-deg -20 30 --json")
        assert answer.code == 0
        summary = json.loads(answer.out)
        assert {name: summary[name] for name in ("cases", "computed", "feasible")} == dict(
            cases=2, computed=2, feasible=2
        )
        data = open_cases(tmp_path / "a.zarr").load()
        assert data.attrs["phi_deg"] == [-20, 30]
        for k, altitude_ft in enumerate((0.0, 10000.0)):
            limits = ControlLimits(aileron_deg=(-10, 15), rudder_deg=(5, 5))
            exact = envelope(altitude_ft, 1.0, limits, phi_deg=(-20.0, 30.0))
            assert (data.v_min[k], data.v_max[k]) == (exact.v_min_kt, exact.v_max_kt)

    def test_again_computes_nothing(self, dataset):
        command = f"{TWO_CONDITIONS} {JAM}"
        assert "computed │ 2" in dataset(command).out
        assert "computed │ 0" in dataset(command).out

    def test_every_axis_of_a_lattice(self, dataset, tmp_path, monkeypatch):
        monkeypatch.setattr(f"{DATASETS}.distribution.compute", lambda store, table, *_, **__: made.append(table) or 0)
        monkeypatch.setattr(f"{DATASETS}.store.slices", lambda *_: [])
        made: list = []
        controls = " ".join(
            f"--{name} {low} {high} --{name.split('-')[0]}-levels 2"
            for name, low, high in (
                ("elevator-deg", -1, 1), ("aileron-deg", -2, 2), ("rudder-deg", -3, 3), ("throttle-pct", 10, 90)
            )
        )  # fmt: skip
        assert dataset(f"{TWO_CONDITIONS} {controls}").code == 0
        (table,) = made
        assert len(table) == 2 * 3**4
        rows = table.rows(0, len(table))
        np.testing.assert_array_equal(rows.min(axis=0), [0, 1, -1, -1, -2, -2, -3, -3, 10, 10])
        np.testing.assert_array_equal(rows.max(axis=0), [10000, 1, 1, 1, 2, 2, 3, 3, 90, 90])

    def test_failures_of_every_kind(self, dataset, tmp_path):
        """Damage, engines that are out, one weak throttle, a setting and a rate vary; each case is its own envelope."""
        options = (
            "--sampling lattice --altitude-ft 3000 3000 --gamma-deg -3 -3 --damage-case 0 --damage-case 4 "
            "--engine-out none --engine-out right --stabilizer-deg -1 0 --stabilizer-levels 2 "
            f"--held-throttle-left-pct 0 70 --rudder-rate-deg-s 50 50 {JAM} --export {tmp_path / 'a.csv'}"
        )
        assert dataset(options).code == 0
        data = open_cases(tmp_path / "a.zarr").load()
        assert (data.rudder_rate == 50).all()
        varied = product((0, 4), ((True, True), (True, False)), (-1.0, 0.0))
        for k, (damage_case, running, stabilizer_deg) in enumerate(varied):
            configuration = Configuration(
                damage_case=damage_case, engine_running=running, stabilizer_deg=stabilizer_deg
            )
            failure = Failure(ControlLimits(rudder_deg=(5, 5)), configuration, throttle_left_pct=(0, 70))
            exact = envelope(3000.0, -3.0, failure)
            assert exact.at_v_max
            assert (data.v_min[k], data.v_max[k]) == (exact.v_min_kt, exact.v_max_kt)
            for name in ("throttle", "throttle_left", "throttle_right"):
                value = getattr(exact.at_v_max, f"{name}_pct")
                np.testing.assert_equal(float(data[f"{name}_at_v_max"][k]), np.nan if value is None else value)
            assert limit_names(int(data.limits_at_v_max[k])) == exact.at_v_max.limits_hit
        table = pd.read_csv(tmp_path / "a.csv", keep_default_na=False)
        assert table.damage_case.tolist() == ["none"] * 4 + ["25_percent_of_the_left_wing_off"] * 4
        assert table.engine_out.tolist() == ["none", "none", "right", "right"] * 2
        assert table.rudder_rate_deg_s.tolist() == [50.0] * 8
        assert table.throttle_left_upper_pct.tolist() == [70.0] * 8
        assert set(table.throttle_left_at_v_max_pct.map(lambda text: text == "")) == {True, False}

    @pytest.mark.parametrize(
        ("options", "described"),
        [
            (
                "--damage-case 5 --damage-case 2 --fuel-used-lb 0 8 --throttle-right-pct 0 60",
                {
                    "axis_damage_case": "one of [5, 2]",
                    "axis_fuel_used": "uniform in [0.0, 8.0]",
                    "axis_throttle_right": "pairs uniform in [0.0, 60.0], share of jams 0.0",
                },
            ),
            ("--engine-out left", {"axis_engine_out": "held at [1]"}),
            ("", {"sampling": "sobol", "cases": 1000, "seed": 0, "axis_altitude": "uniform in [0.0, 30000.0]"}),
            ("--cases 7 --seed 5 --sampling random", {"sampling": "random", "cases": 7, "seed": 5}),
            ("--gamma-deg -1 2", {"axis_gamma": "uniform in [-1.0, 2.0]"}),
            ("--altitude-ft 5 5", {"axis_gamma": "uniform in [-5.0, 5.0]", "axis_altitude": "held at [5.0]"}),
            ("--throttle-pct 0 50", {"axis_throttle": "pairs uniform in [0.0, 50.0], share of jams 0.0"}),
            (
                "--elevator-deg -9 9 --rudder-deg -30 30 --jam-share 0.5 --sampling latin-hypercube",
                {
                    "sampling": "latin-hypercube",
                    "axis_elevator": "pairs uniform in [-9.0, 9.0], share of jams 0.5",
                    "axis_rudder": "pairs uniform in [-30.0, 30.0], share of jams 0.5",
                    "axis_aileron": "held at [[-20.0, 20.0]]",
                },
            ),
        ],
    )  # fmt: skip
    def test_samples(self, dataset, monkeypatch, options, described):
        monkeypatch.setattr(f"{DATASETS}.distribution.compute", lambda store, table, *_, **__: made.append(table) or 0)
        monkeypatch.setattr(f"{DATASETS}.store.slices", lambda *_: [])
        made: list = []
        assert dataset(options).code == 0
        assert described.items() <= made[0].describe().items()


class TestPaper:
    def test_counts_beside(self, dataset, monkeypatch, tmp_path):
        monkeypatch.setattr(f"{DATASETS}.distribution.compute", lambda store, table, *_, **__: made.append(table) or 0)
        monkeypatch.setattr(f"{DATASETS}.store.slices", lambda *_: [])
        counts = [
            {"data_set": k, "cases": 10 * k, "feasible": 5 * k, "paper": n}
            for k, n in published.TRAINING_SAMPLES.items()
        ]
        monkeypatch.setattr(paper_lattice, "counts", lambda store: counts)
        made: list = []
        answer = dataset("--presets paper --json")
        assert len(made[0]) == 1232
        assert json.loads(answer.out)["counts"] == counts
        assert "contradict each other" in json.loads(answer.out)["note"]
        answer = dataset("--presets paper")
        assert "│ 4        │ 40    │ 20       │ 71    │" in answer.out
        assert paper_lattice.contradiction() in answer.out


class TestExport:
    def test_csv(self, dataset, tmp_path):
        answer = dataset(f"{TWO_CONDITIONS} {JAM} --export {tmp_path / 'a.csv'} --json")
        assert json.loads(answer.out)["export"] == str(tmp_path / "a.csv")
        assert len((tmp_path / "a.csv").read_text().splitlines()) == 3

    def test_refused_before_any_work(self, dataset, tmp_path, monkeypatch):
        monkeypatch.setitem(sys.modules, "pyarrow", None)
        for name in ("a.xls", "a.parquet"):
            assert dataset(f"{TWO_CONDITIONS} {JAM} --export {tmp_path / name}").code == 2
        assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ("--presets paper --seed 1", "The paper's lattice fixes every axis"),
        ("--presets paper --rudder-levels 3", "The paper's lattice fixes every axis"),
        ("--presets thesis", "'thesis' is not one of 'paper'"),
        ("--sampling dice", "'dice' is not one of"),
        ("--sampling lattice", "A lattice needs the number of levels of altitude; give --altitude-levels."),
        (f"{TWO_CONDITIONS} --cases 5", "leave --cases, --seed and --jam-share out"),
        (f"{TWO_CONDITIONS} --gamma-levels 2", "2 levels of gamma do not span 1 .. 1"),
        (f"{TWO_CONDITIONS} --rudder-deg -30 30", "give --rudder-levels."),
        (f"{TWO_CONDITIONS} --rudder-deg -30 30 --rudder-levels 1", "1 levels of rudder do not span -30 .. 30"),
        (f"{TWO_CONDITIONS} --rudder-deg -30 30 --rudder-levels 0", "The lattice is empty: 0 levels of rudder"),
        (f"{TWO_CONDITIONS} --rudder-deg -30 30 --rudder-levels -2", "The lattice is empty: -2 levels of rudder"),
        (f"{TWO_CONDITIONS} --rudder-deg 30 -30 --rudder-levels 3", "rudder in deg 30 -30 are reversed"),
        (f"{TWO_CONDITIONS} --rudder-levels 3", "--rudder-levels has no range"),
        (f"{TWO_CONDITIONS} --rudder-deg -30 30 --rudder-levels 10000", "50005000 levels or pairs of levels of rudder"),
        (f"{TWO_CONDITIONS} --rudder-deg -30 30 --rudder-levels 500000", "500000 levels or pairs of levels of rudder"),
        (
            f"{TWO_CONDITIONS} --rudder-deg -30 30 --rudder-levels {10**20}",
            "levels or pairs of levels of rudder are too",
        ),
        (
            f"{TWO_CONDITIONS} --flaps-deg 0 9 --flaps-levels 10000000000",
            "10000000000 levels or pairs of levels of flaps",
        ),
        ("--cases 1000000000000 --sampling random", "A data set of 1000000000000 cases is too large; take up to 1000"),
        (f"--cases {10**400}", "cases is too large; take up to 100000000."),
        ("--workers 99999999", "99999999 workers were asked for; ask for 1 to 1024."),
        ("--scheduler tls://127.0.0.1:1", "No dask worker at tls://127.0.0.1:1 (dask has no certificates for TLS"),
        ("--altitude-levels 3", "--altitude-levels is for a lattice"),
        ("--rudder-deg -30 30 --held-rudder-deg 0 5", "The limits of the rudder are either held or varied"),
        ("--held-elevator-deg 5 0", "elevator in deg 5 0 are reversed"),
        ("--jam-share 0.5", "--jam-share has no failure to share in"),
        ("--rudder-deg -30 30 --jam-share nan", "Share of jams nan is outside 0 .. 1"),
        ("--altitude-ft nan 3", "altitude in ft nan is outside"),
        ("--gamma-deg 5 -5", "gamma in deg 5 -5 are reversed"),
        ("--cases 0", "0 cases were asked for"),
        ("--altitude-ft 0 0 --gamma-deg 0 0", "Every input is held at one value"),
        ("--alpha-deg 5 0", "alpha in deg 5 0 are reversed"),
        ("--damage-case 7", "damage case 7 does not exist; give a whole number from 0 to 6."),
        ("--damage-case 1 --damage-case 1", "damage case 1 was given twice"),
        ("--engine-out middle", "'middle' is not one of 'none', 'left', 'right', 'both'"),
        ("--fuel-used-lb 0 21", "fuel used in lb 21 is outside 0 .. 20"),
        ("--gear 1 0", "gear 1 0 are reversed"),
        ("--flaps-deg 0 nan", "flaps in deg nan is outside"),
        ("--throttle-left-pct 60 40", "throttle left in % 60 40 are reversed"),
        ("--rudder-rate-deg-s 0 301", "rudder rate in deg/s 301 is outside 0 .. 300"),
        ("--fuel-used-levels 2", "--fuel-used-levels is for a lattice"),
        ("--presets paper --damage-case 1", "The paper's lattice fixes every axis"),
        ("--workers 0", "0 workers were asked for"),
    ],
)
def test_one_sentence_and_nothing_written(dataset, tmp_path, options, sentence):
    answer = dataset(options)
    assert (answer.code, answer.out) == (2, "")
    line = answer.err.splitlines()[-1]
    assert line.startswith("gtm-fmu: ")
    assert sentence in line
    assert not list(tmp_path.iterdir())
