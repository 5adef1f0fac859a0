"""Networks that stand in for an expensive function: training, selection and evaluation.

Only training needs torch; it is imported when a training starts. The figures are in `surrogate.plots`.
"""

from surrogate.bayesian_regularization import History, Schedule
from surrogate.evaluation import Variable
from surrogate.local_models import LocalModelNetwork
from surrogate.network import Network
from surrogate.protocol import Selection, Split, select_network, split_samples
from surrogate.storage import load_model
from surrogate.training import train_networks

__all__ = [
    "History",
    "LocalModelNetwork",
    "Network",
    "Schedule",
    "Selection",
    "Split",
    "Variable",
    "load_model",
    "select_network",
    "split_samples",
    "train_networks",
]
