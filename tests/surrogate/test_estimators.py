"""The estimators keep scikit-learn's convention, and report what they say they do."""

import pickle

import numpy as np
import pytest
from sklearn.base import clone
from sklearn.datasets import load_diabetes
from sklearn.linear_model import LinearRegression
from sklearn.model_selection import KFold, cross_val_score, train_test_split
from sklearn.utils.estimator_checks import parametrize_with_checks

from surrogate.estimators import (
    BayesianRegularizationRegressor,
    HilomotRegressor,
    LevenbergMarquardtRegressor,
    LolimotRegressor,
)

pytestmark = pytest.mark.slow

ESTIMATORS = [
    LevenbergMarquardtRegressor(3, restarts=1, epochs=10, random_state=0),
    BayesianRegularizationRegressor(3, restarts=1, epochs=10, random_state=0),
    LolimotRegressor(max_models=5, random_state=0),
    HilomotRegressor(max_models=5, random_state=0),
]


EXTREME = 1e-300, 1e300, float("nan"), 10**400


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
        (BayesianRegularizationRegressor(restarts=0), "restarts is 0, but must be a whole number from 1"),
        (
            LevenbergMarquardtRegressor(validation_fraction=1.5),
            "validation_fraction is 1.5, but must be a finite number above 0 to 1",
        ),
        (LevenbergMarquardtRegressor(validation_fraction=0.999), "leaves none for training"),
        (LevenbergMarquardtRegressor(mu_increase=1.0), "mu_increase is 1.0, but must be a finite number above 1"),
        (BayesianRegularizationRegressor(mu_max=float("inf")), "mu_max is inf"),
        (LolimotRegressor("cubic"), "local_model is 'cubic', but must be one of linear, sparse_quadratic, quadratic"),
        (LolimotRegressor(criterion="bic"), "criterion is 'bic', but must be one of validation, aicc, size"),
        (LolimotRegressor(max_models=0), "max_models is 0, but must be a whole number from 1"),
        (LevenbergMarquardtRegressor(2.5), "hidden_layer_sizes is 2.5, but must be a whole number from 1 to 10000"),
        (LevenbergMarquardtRegressor("4"), "hidden_layer_sizes is '4'"),
        (LevenbergMarquardtRegressor(None), "hidden_layer_sizes is None"),
        (LevenbergMarquardtRegressor(True), "hidden_layer_sizes is True"),
        (LevenbergMarquardtRegressor((4, 0)), r"hidden_layer_sizes is \(4, 0\)"),
        (LevenbergMarquardtRegressor((4,) * 201), "at most 20 hidden layers"),
        (LevenbergMarquardtRegressor(999999999), "hidden_layer_sizes is 999999999"),
        (LevenbergMarquardtRegressor(10**400), r"hidden_layer_sizes is 10+ \.\.\., but"),
        (LevenbergMarquardtRegressor(10**5000), "a number of thousands of digits"),
        (LevenbergMarquardtRegressor((10000, 10000)), "GiB for normal matrices"),
        (LevenbergMarquardtRegressor(3, epochs=None), "epochs is None, but must be a whole number from 0"),
        (LevenbergMarquardtRegressor(3, epochs=1.5), "epochs is 1.5"),
        (LevenbergMarquardtRegressor(3, device="gpu"), "torch cannot use the device 'gpu'"),
        (LevenbergMarquardtRegressor(3, device="privateuseone"), "torch cannot use the device 'privateuseone'"),
        (LevenbergMarquardtRegressor(3, device=None), "torch cannot use the device None"),
        (HilomotRegressor(smoothness=-1.0), "smoothness is -1.0, but must be a finite number from 1e-06 to 1000"),
        *(
            (kind(smoothness=value), "smoothness is")
            for kind in (LolimotRegressor, HilomotRegressor)
            for value in EXTREME
        ),
        (LevenbergMarquardtRegressor(mu=1e300), "mu is 1e.300, but must be a finite number from 1e-20 to 1e.20"),
        (LevenbergMarquardtRegressor(mu_decrease=1e-300), "mu_decrease is 1e-300"),
        (LevenbergMarquardtRegressor(mu_increase=1e300), "mu_increase is"),
        (LevenbergMarquardtRegressor(mu_max=1e-300), "mu_max is"),
        (LevenbergMarquardtRegressor(min_grad=10**400), "min_grad is"),
    ],
)
def test_wrong_parameters_are_refused(estimator, message):
    X, truth, _ = friedman(30, seed=7)
    with pytest.raises(ValueError, match=message):
        estimator.fit(X, truth)


@pytest.mark.parametrize(
    "estimator",
    [
        LolimotRegressor(random_state=0),
        LolimotRegressor(criterion="aicc", max_models=6),
        HilomotRegressor(criterion="aicc", max_models=4),
        HilomotRegressor("quadratic", criterion="size", max_models=3),
        BayesianRegularizationRegressor(3, restarts=1, epochs=15, random_state=0),
        LevenbergMarquardtRegressor((3, 2), restarts=1, epochs=15, random_state=0),
    ],
    ids=lambda estimator: type(estimator).__name__,
)
def test_a_weight_is_a_number_of_repetitions(estimator):
    """Weights 0 .. 3 against rows that stand as often in the table: the same least squares, but for rounding."""
    X, _, y = friedman(120, seed=11)
    weights = np.random.default_rng(0).integers(0, 4, len(X))
    weighted = clone(estimator).fit(X, y, sample_weight=weights)
    repeated = clone(estimator).fit(np.repeat(X, weights, axis=0), np.repeat(y, weights))
    np.testing.assert_allclose(weighted.predict(X), repeated.predict(X), rtol=1e-5)
    assert np.abs(clone(estimator).fit(X, y).predict(X) - repeated.predict(X)).max() > 0.01


@pytest.mark.parametrize("estimator", ESTIMATORS, ids=lambda e: type(e).__name__)
def test_the_order_of_the_samples_makes_no_difference(estimator):
    X, _, y = friedman(60, seed=14)
    order = np.random.default_rng(0).permutation(len(X))
    predicted = [clone(estimator).fit(X[rows], y[rows]).predict(X) for rows in (slice(None), order)]
    np.testing.assert_array_equal(*predicted)


def test_too_few_weights_are_refused():
    X, y, _ = friedman(10, seed=12)
    with pytest.raises(ValueError, match="leaves 1 samples, but at least 2"):
        LolimotRegressor().fit(X, y, sample_weight=np.eye(10)[0])


@pytest.mark.parametrize("estimator", [LolimotRegressor(), BayesianRegularizationRegressor(3, restarts=1, epochs=5)])
@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda X, y: (np.column_stack([X, np.where(y > 9, 0.1 + 0.2, 0.3)]), y), "'x6' has the value 0.3 .* rounding"),
        (lambda X, y: (X, 1e-200 * y), "squares are no numbers: take another unit"),
        (lambda X, y: (X, 1e-320 * np.arange(len(y))), "squares are no numbers"),
        (lambda X, y: (1e200 * X, y), "squares are no numbers"),
        (lambda X, y: (X, 7.0 + 1e-15 * (y > 9)), "'y' has the value 7 .* rounding"),
    ],
)
def test_rounding_noise_is_no_signal(estimator, change, message):
    X, y, _ = friedman(40, seed=13)
    with pytest.raises(ValueError, match=message):
        clone(estimator).fit(*change(X, y))


def test_names_of_a_table_become_those_of_the_network():
    from xarray import Dataset

    X, truth, _ = friedman(60, seed=8)
    frame = Dataset({f"u{j}": ("n", X[:, j]) for j in range(5)}).to_dataframe()
    model = LolimotRegressor(max_models=2, random_state=0).fit(frame, truth)
    assert [variable.name for variable in model.network_.inputs] == ["u0", "u1", "u2", "u3", "u4"]
    assert "u3" in model.tree()


def test_real_data():
    """The example of docs/surrogates.md: better than linear regression by cross validation, with honest intervals."""
    X, y = load_diabetes(return_X_y=True)
    model, folds = (
        BayesianRegularizationRegressor(3, restarts=3, random_state=0),
        KFold(5, shuffle=True, random_state=0),
    )
    linear, ours = (cross_val_score(each, X, y, cv=folds).mean() for each in (LinearRegression(), model))
    assert (round(linear, 2), round(ours, 2)) == (0.49, 0.50)
    assert ours > linear
    X_train, X_test, y_train, y_test = train_test_split(X, y, random_state=0)
    mean, std = model.fit(X_train, y_train).predict(X_test, return_std=True)
    assert 0.90 <= (np.abs(y_test - mean) < 1.96 * std).mean() <= 0.99
