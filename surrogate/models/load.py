"""A model file of any kind."""

from pathlib import Path

from surrogate.models.local_models import LocalModelNetwork
from surrogate.models.network import Network
from surrogate.models.storage import read_model


def load_model(path: str | Path) -> Network | LocalModelNetwork:
    """The model in a file, whichever kind it is; ValueError where it is missing, foreign, damaged or too new.

    Args:
        path: of a file that `save` or ``gtm-fmu train`` wrote.
    """
    return read_model(Path(path), Network, LocalModelNetwork)
