"""Neural networks and local model networks as estimators in scikit-learn's convention, for any regression problem."""

from surrogate.estimators.local_models import HilomotRegressor, LolimotRegressor
from surrogate.estimators.networks import BayesianRegularizationRegressor, LevenbergMarquardtRegressor

__all__ = [
    "BayesianRegularizationRegressor",
    "HilomotRegressor",
    "LevenbergMarquardtRegressor",
    "LolimotRegressor",
]
