"""Networks that stand in for an expensive function: training, selection and evaluation.

Only the training of networks needs torch; it is imported when a training starts. Estimators in scikit-learn's
convention are in `surrogate.estimators`, the figures in `surrogate.plots`.
"""

from surrogate.evaluation import Variable
from surrogate.levenberg_marquardt import History, Schedule
from surrogate.local_models import LocalModelNetwork
from surrogate.local_training import Growth, LocalSettings
from surrogate.network import Network
from surrogate.protocol import Selection, Split, select_network, split_samples
from surrogate.storage import load_model
from surrogate.training import train_local_models, train_networks

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
