"""The estimators keep scikit-learn's convention, and report what they say they do."""

from sklearn.utils.estimator_checks import parametrize_with_checks

from surrogate.estimators import (
    BayesianRegularizationRegressor,
    HilomotRegressor,
    LevenbergMarquardtRegressor,
    LolimotRegressor,
)

ESTIMATORS = [
    LevenbergMarquardtRegressor(3, restarts=1, epochs=30, random_state=0),
    BayesianRegularizationRegressor(3, restarts=1, epochs=30, random_state=0),
    LolimotRegressor(max_models=5, random_state=0),
    HilomotRegressor(max_models=5, random_state=0),
]


@parametrize_with_checks(ESTIMATORS)
def test_convention(estimator, check):
    check(estimator)
