"""Flight dynamics, trims and flight envelopes of the NASA Generic Transport Model (GTM-T2).

The public names of the package. Each is imported from its module when it is first asked for: ``import gtm_fmu`` takes
no time, and a program that keeps to these names does not see where a module lies.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from gtm_fmu.aircraft.client import FmuClient, FmuError
    from gtm_fmu.aircraft.failures import Failure
    from gtm_fmu.aircraft.limits import ControlLimits, RateLimits
    from gtm_fmu.core.configuration import Configuration
    from gtm_fmu.datasets.axes import choices, levels, limits_span, span
    from gtm_fmu.datasets.cases import CaseTable, GivenCases, Sampling
    from gtm_fmu.datasets.distribution import compute
    from gtm_fmu.envelopes.envelope import Envelope, FlightCondition, envelope
    from gtm_fmu.envelopes.manoeuvres import Manoeuvres, manoeuvres
    from gtm_fmu.envelopes.performance import Performance, performance
    from gtm_fmu.envelopes.remedies import Remedy, remedies
    from gtm_fmu.envelopes.sections import Section, climb_interval, speed_interval, turn_rate_interval
    from gtm_fmu.envelopes.slopes import EnvelopeSlopes, envelope_slopes
    from gtm_fmu.envelopes.thrust_map import ThrustMap
    from gtm_fmu.envelopes.tolerances import Tolerances
    from gtm_fmu.envelopes.tolerant_envelope import TolerantEnvelope, tolerant_envelope
    from gtm_fmu.envelopes.tolerant_manoeuvres import TolerantManoeuvres, tolerant_manoeuvres
    from gtm_fmu.envelopes.trim_map import TrimMap
    from gtm_fmu.errors import InputError
    from gtm_fmu.trims.equilibrium import Equilibrium, equilibrium
    from gtm_fmu.trims.fmu_trimmer import FmuTrimmer
    from gtm_fmu.trims.linearization import LinearModel, linearize
    from gtm_fmu.trims.manoeuvre import Trim
    from gtm_fmu.trims.steady import trim

    __version__: str

__all__ = [
    "CaseTable",
    "Configuration",
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
    "Manoeuvres",
    "Performance",
    "RateLimits",
    "Remedy",
    "Sampling",
    "Section",
    "ThrustMap",
    "Tolerances",
    "TolerantEnvelope",
    "TolerantManoeuvres",
    "Trim",
    "TrimMap",
    "__version__",
    "choices",
    "climb_interval",
    "compute",
    "envelope",
    "envelope_slopes",
    "equilibrium",
    "levels",
    "limits_span",
    "linearize",
    "manoeuvres",
    "performance",
    "remedies",
    "span",
    "speed_interval",
    "tolerant_envelope",
    "tolerant_manoeuvres",
    "trim",
    "turn_rate_interval",
]

_NAMES = {
    "datasets.axes": ("choices", "levels", "limits_span", "span"),
    "datasets.cases": ("CaseTable", "GivenCases", "Sampling"),
    "aircraft.client": ("FmuClient", "FmuError"),
    "core.configuration": ("Configuration",),
    "datasets.distribution": ("compute",),
    "envelopes.envelope": ("Envelope", "FlightCondition", "envelope"),
    "envelopes.manoeuvres": ("Manoeuvres", "manoeuvres"),
    "envelopes.performance": ("Performance", "performance"),
    "envelopes.remedies": ("Remedy", "remedies"),
    "envelopes.sections": ("Section", "climb_interval", "speed_interval", "turn_rate_interval"),
    "envelopes.slopes": ("EnvelopeSlopes", "envelope_slopes"),
    "trims.equilibrium": ("Equilibrium", "equilibrium"),
    "errors": ("InputError",),
    "aircraft.failures": ("ControlLimits", "Failure", "RateLimits"),
    "trims.linearization": ("LinearModel", "linearize"),
    "trims.manoeuvre": ("Trim",),
    "trims.steady": ("trim",),
    "envelopes.thrust_map": ("ThrustMap",),
    "envelopes.tolerances": ("Tolerances",),
    "envelopes.tolerant_envelope": ("TolerantEnvelope", "tolerant_envelope"),
    "envelopes.tolerant_manoeuvres": ("TolerantManoeuvres", "tolerant_manoeuvres"),
    "envelopes.trim_map": ("TrimMap",),
    "trims.fmu_trimmer": ("FmuTrimmer",),
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
