"""Networks that stand in for an expensive function: training, selection and evaluation.

Only training needs torch; it is imported when a training starts. The figures are in `surrogate.plots`.
"""

from surrogate.bayesian_regularization import History, Schedule
from surrogate.network import Network, Variable
from surrogate.protocol import Selection, Split, select_network, split_samples
from surrogate.training import train_networks

__all__ = [
    "History",
    "Network",
    "Schedule",
    "Selection",
    "Split",
    "Variable",
    "select_network",
    "split_samples",
    "train_networks",
]
