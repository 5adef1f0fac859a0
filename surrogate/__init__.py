"""Networks that stand in for an expensive function: training, selection, evaluation and export.

Only the training of networks needs torch; it is imported when a training starts. What belongs to training, and the
estimators in scikit-learn's convention, are imported when they are first asked for. The forms in which a model can be
written are in `surrogate.exports.forms`, the figures in `surrogate.plots`.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from surrogate.estimators import (
        BayesianRegularizationRegressor,
        HilomotRegressor,
        LevenbergMarquardtRegressor,
        LolimotRegressor,
    )
    from surrogate.models.evaluation import Variable
    from surrogate.models.load import load_model
    from surrogate.models.local_models import LocalModelNetwork
    from surrogate.models.network import Network
    from surrogate.training.least_squares import History, Schedule
    from surrogate.training.local_training import Growth, LocalSettings
    from surrogate.training.selection import Selection, Split, select_network, split_samples
    from surrogate.training.train import train_local_models, train_networks

__all__ = [
    "BayesianRegularizationRegressor",
    "Growth",
    "HilomotRegressor",
    "History",
    "LevenbergMarquardtRegressor",
    "LocalModelNetwork",
    "LocalSettings",
    "LolimotRegressor",
    "Network",
    "Schedule",
    "Selection",
    "Split",
    "Variable",
    "load_model",
    "select_network",
    "split_samples",
    "train_local_models",
    "train_networks",
]


_NAMES = {
    "estimators": (
        "BayesianRegularizationRegressor",
        "HilomotRegressor",
        "LevenbergMarquardtRegressor",
        "LolimotRegressor",
    ),
    "models.evaluation": ("Variable",),
    "models.load": ("load_model",),
    "models.local_models": ("LocalModelNetwork",),
    "models.network": ("Network",),
    "training.least_squares": ("History", "Schedule"),
    "training.local_training": ("Growth", "LocalSettings"),
    "training.selection": ("Selection", "Split", "select_network", "split_samples"),
    "training.train": ("train_local_models", "train_networks"),
}
_HOMES = {name: home for home, names in _NAMES.items() for name in names}


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'surrogate' has no attribute '{name}'")
    return getattr(import_module(f"surrogate.{_HOMES[name]}"), name)


def __dir__() -> list[str]:
    return sorted(__all__)
