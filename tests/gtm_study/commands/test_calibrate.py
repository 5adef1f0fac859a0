"""`gtm-fmu calibrate`, and what `gtm-fmu predict` says of safe speeds."""

import json
from dataclasses import replace

import numpy as np
import pytest

from gtm_fmu.datasets import calibration
from gtm_fmu.envelopes.thrust_map import ThrustMap

CASE = ("--altitude-ft", 10000, "--rudder-deg", 7, 7, "--json")
SMALL = ("--cases", 1200, "--draws", 4000, "--test-cases", 600, "--test-draws", 2000, "--json")


@pytest.fixture
def coarse(tmp_path):
    """File of the rudder's map with every twelfth deflection, not calibrated."""
    shipped = ThrustMap.load()
    thinned = {"deflection_deg": shipped.deflection_deg[::12], "table": shipped.table[:, :, ::12]}
    return replace(shipped, **thinned, safe=None, provenance={}).save(tmp_path / "coarse.npz")


@pytest.fixture
def solved(monkeypatch, coarse):
    """Exact ends in the solver's place: those of the coarse map, but for three standard deviations to either side."""
    asked = []

    def solve(store, control, X, progress, workers):
        asked.append((store.name, control, len(X), workers))
        found = ThrustMap.load(coarse).predict(X)
        wrong = np.where(np.random.default_rng(len(X)).random(len(X)) < 0.1, 3.0, -3.0)  # positive: unsafe
        ends = found.v_min_kt + wrong * found.v_min_std_kt, found.v_max_kt - wrong * found.v_max_std_kt
        return np.column_stack(ends)

    monkeypatch.setattr(calibration, "solve", solve)
    return asked


def test_calibrate(ask, coarse, solved, tmp_path):
    """A tenth of the cases errs by three deviations: that is the margin at 0.1 %, and no promise is broken."""
    output = tmp_path / "safe.npz"
    answer = ask("calibrate", coarse, "--output", output, "--workers", 2, *SMALL)
    assert answer.code == 0
    assert [asked[:2] for asked in solved] == [("safe_calibration.zarr", "rudder"), ("safe_test.zarr", "rudder")]
    assert [asked[3] for asked in solved] == [2, 2]
    assert 2400 < solved[0][2] < 3000
    told = json.loads(answer.out)
    jams = told["jams"]
    assert 500 < jams["safe"] <= jams["cases"] == 600
    assert (jams["no_envelope"], jams["broken_v_min"]) == (0, 0)
    assert jams["price_v_min_kt"] > 0
    assert told["jams at folds"]["safe"] == 0  # too few to promise anything
    safe = ThrustMap.load(output)
    assert safe.provenance[calibration.SAFE]["measured"]["jams"] == jams
    found = ask("predict", *CASE, "--model", output).json
    assert found["feasible_safe"] is True
    assert found["v_min_safe_kt"] == pytest.approx(found["v_min_kt"] + 3 * found["v_min_std_kt"], abs=1e-9)
    assert found["v_max_safe_kt"] == pytest.approx(found["v_max_kt"] - 3 * found["v_max_std_kt"], abs=1e-9)
    assert "probability of at least 0.999 over the" in found["promise"]
    less = ask("predict", *CASE, "--model", output, "--epsilon", 0.05).json
    assert less["v_min_safe_kt"] == pytest.approx(
        found["v_min_safe_kt"], abs=1e-9
    )  # a tenth errs, so a twentieth does not do either
    assert "probability of at least 0.95 over the" in less["promise"]
    refused = ask("predict", *CASE, "--model", output, "--epsilon", 1e-7)
    assert (refused.code, "needs 9999999 calibration cases a group" in refused.err) == (2, True)


def test_without_calibration(ask, coarse):
    found = ask("predict", *CASE, "--model", coarse).json
    assert (found["feasible"], found["feasible_safe"], found["v_max_safe_kt"]) == (True, False, None)
    assert "was not calibrated and promises nothing" in found["promise"]


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (("predict", *CASE, "--epsilon", 2), "epsilon was given as 2; it is a probability"),
        (("predict", *CASE, "--epsilon", 0.01, "--model", "network"), "'network' promises nothing"),
        (("predict", *CASE, "--epsilon", 0.01, "--model", "trim-map"), "--epsilon is for a thrust map"),
        (("calibrate", "network"), "'network' is no thrust map"),
        (("calibrate", "oracle"), "--model was given as 'oracle': give thrust-map, network, paper, aileron"),
        (("calibrate", "--cases", 10), "10 is not in the range"),
    ],
)
def test_refused(ask, words, sentence):
    answer = ask(*words)
    assert (answer.code, answer.out) == (2, "")
    assert sentence in answer.err
