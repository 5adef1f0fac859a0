"""The variables of GtmEnvelope: the interface of GtmSurrogate, with the exact V_min and V_max behind it."""

from dataclasses import replace
from functools import cache

from fmu_src.description.model_description import ModelDescription
from fmu_src.description.surrogate_variables import CASE, ENVELOPE, FLAGS, MARGINS, SPEED
from gtm_fmu import units
from gtm_fmu.aircraft.failures import Failure
from gtm_fmu.trims.manoeuvre import bounds

REVERSED = "The rudder limits are reversed: rudder.lower is above rudder.upper."
ENVELOPE_FAULTS = ("", "The outputs are not finite.", REVERSED)
"""By fault, as in envelope_model.c."""

MEMORY = 1 + len(CASE) + 3
"""Numbers that envelope_model.c keeps (its ``Place``)."""

USAGE = (
    "V_min and V_max are the slowest and fastest true airspeed of a steady turn or straight flight at this altitude "
    "and flight-path angle with the rudder between rudder.lower and rudder.upper; equal limits are a jam. They are "
    "exact: found among the trims of the aerodynamic tables themselves, not by a network. margin.slow and margin.fast "
    "say how far tas is inside.",
    "The interface is that of GtmSurrogate, so that one can take the other's place: the standard deviations are zero, "
    "and in_domain is always true. Where feasible is false there is no envelope, and both speeds are zero.",
    "Outputs follow the inputs at once, also in Initialization Mode, and are found anew only when altitude, gamma or a "
    "limit of the rudder has changed. That takes some milliseconds for a jam, and some tens of them for a wide range.",
    "Values that are not finite or outside their bounds and reversed rudder limits are logged in one sentence; the "
    "step is discarded and all values stay as before it. No output is ever NaN.",
)


@cache
def envelope_description() -> ModelDescription:
    """The description of GtmEnvelope; computed in the core's units (ft, ft/s, rad; surfaces in deg)."""
    altitude, gamma, *rudder = (replace(variable, bounded=True) for variable in CASE)
    speed, *speeds = (replace(variable, scale=units.M_PER_FT) for variable in (SPEED, *ENVELOPE, *MARGINS))
    envelope, margins = speeds[: len(ENVELOPE)], speeds[len(ENVELOPE) :]
    feasible, in_domain = FLAGS
    always = replace(in_domain, description="True: the exact envelope has no training data")
    lower, upper = bounds(Failure())
    return ModelDescription(
        name="GtmEnvelope",
        title="Steady flight envelope of the GTM-T2 with a failed rudder, exact",
        groups={
            "case": (altitude, replace(gamma, scale=1.0), *rudder),
            "speed": (speed,),
            "envelope": tuple(envelope),
            "flags": (feasible, always),
            "margins": tuple(margins),
        },
        stop_time=1.0,
        step_size=0.1,
        usage=USAGE,
        constants={"lower": lower.tolist(), "upper": upper.tolist()},
    )
