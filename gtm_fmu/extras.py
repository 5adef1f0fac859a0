"""Optional libraries, and the extra of this package that brings each."""

import re

_DISTRIBUTIONS = {"sklearn": "scikit-learn"}
"""Modules that are not named as the distribution that holds them."""


def advice(module: str) -> str | None:
    """How to install a module that is missing, as ``pip install 'gtm-fmu[study]'``; None for one of no extra."""
    from importlib.metadata import requires  # a mistake may wait for it, every command that starts need not

    top = module.partition(".")[0]
    name = re.escape(_DISTRIBUTIONS.get(top, top))
    for requirement in requires("gtm-fmu") or ():
        if found := re.match(rf"{name}\b(?!-).*\bextra == ['\"](\w+)['\"]", requirement, re.IGNORECASE):
            return f"pip install 'gtm-fmu[{found[1]}]'"
    return None
