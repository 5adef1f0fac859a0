"""Flight dynamics, trims and flight envelopes of the NASA Generic Transport Model (GTM-T2).

The public names of the package. Each is imported from its module when it is first asked for: ``import gtm_fmu`` takes
no time, and a program that keeps to these names does not see where a module lies.
"""

import sys
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from gtm_fmu.axes import choices, levels, limits_span, span
    from gtm_fmu.cases import CaseTable, GivenCases, Sampling
    from gtm_fmu.client import FmuClient, FmuError
    from gtm_fmu.distribution import compute
    from gtm_fmu.envelope import Envelope, FlightCondition, envelope
    from gtm_fmu.envelope_slopes import EnvelopeSlopes, envelope_slopes
    from gtm_fmu.equilibrium import Equilibrium, equilibrium
    from gtm_fmu.errors import InputError
    from gtm_fmu.failures import ControlLimits, Failure, RateLimits
    from gtm_fmu.linearization import LinearModel, linearize
    from gtm_fmu.manoeuvre import Trim
    from gtm_fmu.steady import trim
    from gtm_fmu.thrust_map import ThrustMap
    from gtm_fmu.trim import FmuTrimmer

    __version__: str

__all__ = [
    "CaseTable",
    "ControlLimits",
    "Envelope",
    "EnvelopeSlopes",
    "Equilibrium",
    "Failure",
    "FlightCondition",
    "FmuClient",
    "FmuError",
    "FmuTrimmer",
    "GivenCases",
    "InputError",
    "LinearModel",
    "RateLimits",
    "Sampling",
    "ThrustMap",
    "Trim",
    "__version__",
    "choices",
    "compute",
    "envelope",
    "envelope_slopes",
    "equilibrium",
    "levels",
    "limits_span",
    "linearize",
    "span",
    "trim",
]

_NAMES = {
    "axes": ("choices", "levels", "limits_span", "span"),
    "cases": ("CaseTable", "GivenCases", "Sampling"),
    "client": ("FmuClient", "FmuError"),
    "distribution": ("compute",),
    "envelope": ("Envelope", "FlightCondition", "envelope"),
    "envelope_slopes": ("EnvelopeSlopes", "envelope_slopes"),
    "equilibrium": ("Equilibrium", "equilibrium"),
    "errors": ("InputError",),
    "failures": ("ControlLimits", "Failure", "RateLimits"),
    "linearization": ("LinearModel", "linearize"),
    "manoeuvre": ("Trim",),
    "steady": ("trim",),
    "thrust_map": ("ThrustMap",),
    "trim": ("FmuTrimmer",),
}
_HOMES = {name: home for home, names in _NAMES.items() for name in names}


def __getattr__(name: str) -> Any:
    if name == "__version__":
        from importlib.metadata import version

        return version("gtm-fmu")
    if name not in _HOMES:
        raise AttributeError(f"module 'gtm_fmu' has no attribute '{name}'")
    return getattr(import_module(f"gtm_fmu.{_HOMES[name]}"), name)


def __dir__() -> list[str]:
    return sorted(__all__)


class _Package(ModuleType):
    """This package: ``gtm_fmu.envelope`` is the function, also once the module of that name has been imported.

    Python binds an imported module to its package. Here the public name wins; ``from gtm_fmu.envelope import`` finds
    the module all the same.
    """

    def __setattr__(self, name: str, value: Any) -> None:
        if not (name in _HOMES and isinstance(value, ModuleType)):
            super().__setattr__(name, value)


sys.modules[__name__].__class__ = _Package
