"""Optional libraries, and the extra of this package that brings each."""

import re
from importlib.util import find_spec

from gtm_fmu.errors import InputError

_DISTRIBUTIONS = {"sklearn": "scikit-learn"}
"""Modules that are not named as the distribution that holds them."""


def check_installed(module: str, use: str) -> None:
    """Refuse what an optional library is needed for before it begins.

    Args:
        use: a sentence that goes on with the library, as ``Networks are trained with``.

    Raises:
        InputError: the library is not here.
    """
    if find_spec(module) is None:
        raise InputError(f"{use} {module}, which is not here; run {advice(module)}.")


def advice(module: str) -> str | None:
    """How to install a module that is missing, as ``pip install 'gtm-fmu[study]'``; None for one of no extra."""
    from importlib.metadata import requires  # a mistake may wait for it, every command that starts need not

    top = module.partition(".")[0]
    name = re.escape(_DISTRIBUTIONS.get(top, top))
    for requirement in requires("gtm-fmu") or ():
        if found := re.match(rf"{name}\b(?!-).*\bextra == ['\"](\w+)['\"]", requirement, re.IGNORECASE):
            return f"pip install 'gtm-fmu[{found[1]}]'"
    return None
