"""The estimators keep scikit-learn's convention, and report what they say they do."""

import pickle

import numpy as np
import pytest
from sklearn.base import clone
from sklearn.utils.estimator_checks import parametrize_with_checks

from surrogate.estimators import (
    BayesianRegularizationRegressor,
    HilomotRegressor,
    LevenbergMarquardtRegressor,
    LolimotRegressor,
)

ESTIMATORS = [
    LevenbergMarquardtRegressor(3, restarts=1, epochs=10, random_state=0),
    BayesianRegularizationRegressor(3, restarts=1, epochs=10, random_state=0),
    LolimotRegressor(max_models=5, random_state=0),
    HilomotRegressor(max_models=5, random_state=0),
]


@parametrize_with_checks(ESTIMATORS)
def test_convention(estimator, check):
    check(estimator)


def friedman(n: int, seed: int):
    """Friedman's function (1991) on five inputs, noise of variance 1."""
    rng = np.random.default_rng(seed)
    X = rng.uniform(size=(n, 5))
    y = 10 * np.sin(np.pi * X[:, 0] * X[:, 1]) + 20 * (X[:, 2] - 0.5) ** 2 + 10 * X[:, 3] + 5 * X[:, 4]
    return X, y, y + rng.normal(size=n)


@pytest.fixture(scope="module")
def bayesian():
    X, _, y = friedman(400, seed=0)
    return BayesianRegularizationRegressor(8, restarts=4, epochs=200, random_state=0).fit(X, y)


def test_bayesian_regularisation_finds_the_noise_of_friedmans_function(bayesian):
    """A variance of 1 beside a signal of variance 23.8; its own intervals hold the share of new samples they say."""
    X, truth, y = friedman(4000, seed=1)
    mean, std = bayesian.predict(X, return_std=True)
    assert np.mean((mean - truth) ** 2) < 0.3
    half_range = np.ptp(bayesian.network_.target_ranges[0]) / 2
    assert half_range**2 / (2 * bayesian.beta_) == pytest.approx(1.0, rel=0.15)
    assert np.mean(np.abs(y - mean) < 1.96 * std) == pytest.approx(0.95, abs=0.02)


def test_the_restart_with_the_greatest_evidence_is_kept(bayesian):
    evidences = [network.provenance["log_evidence"] for network in bayesian.networks_]
    assert bayesian.log_evidence_ == max(evidences)
    assert len(set(evidences)) == 4
    assert bayesian.network_ is bayesian.networks_[bayesian.best_restart_]
    assert 0 < bayesian.effective_parameters_ < 8 * 6 + 9
    assert bayesian.alpha_ == bayesian.history_.alpha[-1]


def test_levenberg_marquardt_keeps_the_least_validation_error():
    X, truth, _ = friedman(300, seed=2)
    model = LevenbergMarquardtRegressor(8, restarts=3, random_state=0).fit(X, truth)
    least = [history.validation_sse.min() for history in model.histories_]
    assert model.history_.validation_sse.min() == min(least)
    new, expected, _ = friedman(1000, seed=3)
    assert model.score(new, expected) > 0.995


@pytest.mark.parametrize("estimator", ESTIMATORS, ids=lambda e: type(e).__name__)
def test_a_pickle_and_a_file_predict_the_same(estimator, tmp_path):
    X, truth, _ = friedman(120, seed=4)
    Y = np.column_stack([truth, -2 * truth + X[:, 0]])
    fitted = clone(estimator).fit(X, Y)
    again = pickle.loads(pickle.dumps(fitted))
    np.testing.assert_array_equal(again.predict(X), fitted.predict(X))
    fitted.network_.save(tmp_path / "model.json")
    loaded = type(fitted.network_).load(tmp_path / "model.json")
    np.testing.assert_array_equal(loaded.predict(X), fitted.predict(X))
    assert fitted.predict(X).shape == (120, 2)


@pytest.mark.parametrize("regressor", [LolimotRegressor, HilomotRegressor])
@pytest.mark.parametrize("criterion", ["validation", "aicc"])
def test_local_models_learn_friedmans_function(regressor, criterion):
    X, truth, _ = friedman(600, seed=5)
    model = regressor("sparse_quadratic", criterion=criterion, max_models=12, random_state=0).fit(X, truth)
    new, expected, _ = friedman(1000, seed=6)
    assert model.score(new, expected) > 0.9
    np.testing.assert_allclose(model.validity(new).sum(axis=1), 1.0, rtol=1e-12)
    assert model.tree().count("model ") == model.n_models_ > 2


@pytest.mark.parametrize(
    ("estimator", "message"),
    [
        (BayesianRegularizationRegressor(restarts=0), "at least 1"),
        (LevenbergMarquardtRegressor(validation_fraction=1.5), "between 0 and 1"),
        (LevenbergMarquardtRegressor(validation_fraction=0.999), "leaves none for training"),
        (LevenbergMarquardtRegressor(mu_increase=1.0), "mu_increase is 1.0, but must be above 1"),
        (BayesianRegularizationRegressor(mu_max=float("inf")), "mu_max is inf"),
        (LolimotRegressor("cubic"), "choose 'linear'"),
        (LolimotRegressor(criterion="bic"), "choose validation, aicc, size"),
        (LolimotRegressor(max_models=0), "max_models is 0, but must be at least 1"),
        (HilomotRegressor(smoothness=-1.0), "smoothness is -1.0, but must be positive"),
    ],
)
def test_wrong_parameters_are_refused(estimator, message):
    X, truth, _ = friedman(30, seed=7)
    with pytest.raises(ValueError, match=message):
        estimator.fit(X, truth)


def test_names_of_a_table_become_those_of_the_network():
    from xarray import Dataset

    X, truth, _ = friedman(60, seed=8)
    frame = Dataset({f"u{j}": ("n", X[:, j]) for j in range(5)}).to_dataframe()
    model = LolimotRegressor(max_models=2, random_state=0).fit(frame, truth)
    assert [variable.name for variable in model.network_.inputs] == ["u0", "u1", "u2", "u3", "u4"]
    assert "u3" in model.tree()
