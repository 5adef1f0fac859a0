"""Rows that are held back make outputs safe: which rows, what they promise, and what too few cannot."""

from dataclasses import replace

import numpy as np
import pytest

from gtm_fmu.errors import InputError
from surrogate import LocalModelNetwork, Network, Variable, load_model
from surrogate.models.safety import Safety
from surrogate.rudder.names import NETWORK, SPEEDS_FILE
from surrogate.training.model_training import Calibration, train_calibrated, train_model
from surrogate.training.samples import Samples

INPUTS, OUTPUTS = (Variable("span", "mm"), Variable("alpha", "deg")), (Variable("lift", "N"), Variable("drag", ""))
NEVER = {"lift": "high", "drag": "low"}


def samples(n: int, seed: int) -> Samples:
    """Lift and drag of a wing with errors of the measurement, whose tails are heavy."""
    rng = np.random.default_rng(seed)
    X = rng.uniform((500, -5), (2000, 12), (n, 2))
    lift = 0.07 * X[:, 0] * np.tanh((X[:, 1] + 2) / 8)
    Y = np.column_stack([lift, 1 + (lift / 50) ** 2]) + rng.standard_t(3, (n, 2)) * (1.0, 0.02)
    return Samples(INPUTS, OUTPUTS, X, Y, left_out=0)


def trained(given: Samples, calibration: Calibration, seed: int = 0) -> LocalModelNetwork:
    return train_calibrated(given, "lolimot", calibration, seed=seed, splits=1, hidden=(1,))


@pytest.fixture(scope="module")
def calibrated() -> LocalModelNetwork:
    """Of 2000 rows 1000 set the margins, at 0.01."""
    return trained(samples(2000, 1), Calibration(0.5, NEVER, 0.01))


@pytest.mark.slow
def test_the_promise_holds_in_new_rows(calibrated):
    """Of 20 000 others 1 % may be broken. Over the draw of 1000 rows the share is Beta(10, 991) distributed.

    Mean k / (n + 1) = 10 / 1001, standard deviation sqrt(k) / n = 0.0032.
    """
    others = samples(20_000, 2)
    safe = calibrated.predict_safe(others.X)
    for broken in (safe[:, 0] > others.Y[:, 0], safe[:, 1] < others.Y[:, 1]):
        assert 0.001 < broken.mean() < 0.01 + 4 * 0.0032
    plain = calibrated.predict(others.X)
    assert np.ptp(safe - plain, axis=0).max() < 1e-9  # a constant margin
    assert (safe - plain)[0, 0] < 0 < (safe - plain)[0, 1]
    assert calibrated.metrics["safe_shift lift [N]"] == pytest.approx((safe - plain)[0, 0])


@pytest.mark.slow
def test_no_training_saw_the_rows(calibrated):
    """The model is the one of the rows that are left; a row that stands twice is held back or left as a whole."""
    given = samples(2000, 1)
    assert calibrated.provenance["rows"] == 1000
    assert (calibrated.safe.cases, calibrated.provenance["calibration_rows"]) == (1000, 1000)
    errors = calibrated.predict(given.X) - given.Y
    margin = calibrated.safe.margins[0]
    at_margin = np.isclose(errors[:, 0], margin, rtol=0, atol=1e-12)
    assert at_margin.sum() == 1  # a score of one of the rows
    twice = replace(given, X=np.tile(given.X, (2, 1)), Y=np.tile(given.Y, (2, 1)))
    doubled = trained(twice, Calibration(0.5, NEVER, 0.01))
    assert (doubled.safe.cases, doubled.provenance["rows"], doubled.provenance["rows_repeated"]) == (1000, 2000, 1000)
    assert np.array_equal(trained(given, Calibration(1000, NEVER, 0.01)).safe.margins, calibrated.safe.margins)


def test_a_file_holds_the_margins(calibrated, tmp_path):
    calibrated.save(tmp_path / "model.json")
    again = load_model(tmp_path / "model.json")
    X = samples(10, 3).X
    assert again.predict_safe(X).tobytes() == calibrated.predict_safe(X).tobytes()
    assert again.safe.about("lift").startswith(
        "not above the true one with a probability of at least 0.99, over the 1000"
    )
    again.save(tmp_path / "again.json")
    assert (tmp_path / "again.json").read_bytes() == (tmp_path / "model.json").read_bytes()


def test_a_file_of_before():
    """Those of the package were written when models had no margins."""
    text = (NETWORK / SPEEDS_FILE).read_text()
    assert '"safe"' not in text
    network = Network.load(NETWORK / SPEEDS_FILE)
    assert network.safe is None
    with pytest.raises(ValueError, match="was not calibrated"):
        network.predict_safe([[10000.0, 0.0, 0.0, 0.0]])


@pytest.mark.parametrize(
    ("rows", "never", "epsilon", "sentence"),
    [
        (0.3, NEVER, 0.001, r"0\.3 holds 600 of 2000 different rows back, but epsilon = 0\.001 needs 999"),
        (998, NEVER, 0.001, "998 holds 998 of 2000 different rows back"),
        (2000, NEVER, 0.1, "leaves none of 2000 different rows to train on"),
        (0, NEVER, 0.1, "is no share or number of rows"),
        (float("nan"), NEVER, 0.1, "is no share or number of rows"),
        (0.5, NEVER, 1.5, "it is a probability"),
        (0.5, {}, 0.1, "No output was named that must be safe: name some of lift, drag"),
        (0.5, {"thrust": "low"}, 0.1, "'thrust' is no output: name some of lift, drag"),
    ],
)
def test_refused(rows, never, epsilon, sentence):
    """Before anything is trained."""
    with pytest.raises(InputError, match=sentence):
        trained(samples(2000, 1), Calibration(rows, never, epsilon))


def test_a_column_with_the_name_of_a_safe_value():
    given = samples(2000, 1)
    named = replace(given, inputs=(Variable("lift_safe", "mm"), INPUTS[1]))
    with pytest.raises(InputError, match="'lift_safe' is what a model calls the safe value of 'lift': rename"):
        trained(named, Calibration(0.5, NEVER, 0.01))
    assert train_model(named, "lolimot", splits=1, hidden=(1,), seed=0).safe is None


@pytest.mark.parametrize(
    "wrong",
    [
        {"outputs": ()},
        {"never": ("low",)},
        {"never": ("low", "down")},
        {"margins": [1.0, -1.0]},
        {"margins": [1.0]},
        {"cases": 98},
    ],
)
def test_margins_that_do_not_fit_together(wrong):
    right = {"outputs": ("lift", "drag"), "never": ("high", "low"), "margins": [1.0, 2.0], "epsilon": 0.01, "cases": 99}
    Safety(**right)
    with pytest.raises(ValueError, match=r"safe outputs must"):
        Safety(**right | wrong)
