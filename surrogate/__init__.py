"""Networks that stand in for an expensive function: training, selection, evaluation and export.

Only the training of networks needs torch; it is imported when a training starts. Estimators in scikit-learn's
convention are in `surrogate.estimators`, the forms in which a model can be written in `surrogate.exports`, the figures
in `surrogate.plots`.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from surrogate.evaluation import Variable
from surrogate.local_models import LocalModelNetwork
from surrogate.network import Network
from surrogate.storage import load_model

if TYPE_CHECKING:
    from surrogate.levenberg_marquardt import History, Schedule
    from surrogate.local_training import Growth, LocalSettings
    from surrogate.protocol import Selection, Split, select_network, split_samples
    from surrogate.training import train_local_models, train_networks

_TRAINING = ("levenberg_marquardt", "local_training", "protocol", "training")

__all__ = [
    "Growth",
    "History",
    "LocalModelNetwork",
    "LocalSettings",
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


def __getattr__(name: str) -> Any:
    """What belongs to training, which is imported when it is asked for: a model loads and predicts without it."""
    if name in __all__:
        for module in (import_module(f"surrogate.{home}") for home in _TRAINING):
            if name in vars(module):
                return vars(module)[name]
    raise AttributeError(f"module 'surrogate' has no attribute '{name}'")
