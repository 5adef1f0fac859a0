"""The variables of GtmEnvelope: the interface of GtmSurrogate, and exact V_min and V_max of any failure behind it."""

from collections.abc import Iterable
from dataclasses import replace
from functools import cache

from fmu_src.description.failure_variables import FAILURE_USAGE, failure_inputs
from fmu_src.description.model_description import ModelDescription, Variable
from fmu_src.description.surrogate_variables import CASE, ENVELOPE, FLAGS, MARGINS, SPEED
from gtm_fmu import units
from gtm_fmu.aircraft.failures import Failure
from gtm_fmu.airframe.names import FAILURE, TWO_THROTTLE_UNKNOWNS
from gtm_fmu.trims.manoeuvre import bounds

REVERSED = "The rudder limits are reversed: rudder.lower is above rudder.upper."
ENVELOPE_FAULTS = ("", "The outputs are not finite.", REVERSED)
"""By fault, as in envelope_model.c."""

MEMORY = 1 + len(CASE) + 1 + len(FAILURE) + 2 * len(TWO_THROTTLE_UNKNOWNS)
"""Numbers that envelope_model.c keeps (its ``Place``) before those of the core's memory."""

USAGE = (
    "V_min and V_max are the slowest and fastest true airspeed of a steady turn or straight flight at this altitude "
    "and flight-path angle that a failure leaves. They are exact: found among the trims of the aerodynamic tables "
    "themselves, not by a network. margin.slow and margin.fast say how far tas is inside.",
    FAILURE_USAGE,
    "The rudder moves inside both rudder.* and limits.rudder.*: connect one of the two. rudder.* is what the learnt "
    "surrogates know too.",
    "All else is the interface of GtmSurrogate, so that one can take the other's place where nothing but the rudder "
    "fails: the standard deviations are zero, and in_domain is always true. Where feasible is false there is no "
    "envelope, and both speeds are zero.",
    "Outputs follow the inputs at once, also in Initialization Mode, and are found anew only when another input than "
    "tas has changed. That takes some milliseconds, less in the FMU in C where the inputs move a little: it follows "
    "the ends that it found before.",
    "Values that are not finite or outside their bounds, reversed limits and a damage.case that is no whole number are "
    "logged in one sentence; the step is discarded and all values stay as before it. No output is ever NaN.",
)


@cache
def envelope_description() -> ModelDescription:
    """The description of GtmEnvelope; computed in the core's units (ft, ft/s, rad; surfaces in deg)."""
    altitude, gamma, *rudder = (replace(variable, bounded=True) for variable in CASE)
    speed, *speeds = (replace(variable, scale=units.M_PER_FT) for variable in (SPEED, *ENVELOPE, *MARGINS))
    envelope, margins = speeds[: len(ENVELOPE)], speeds[len(ENVELOPE) :]
    failure = failure_inputs()
    feasible, in_domain = FLAGS
    always = replace(in_domain, description="True: the exact envelope has no training data")
    lower, upper = bounds(Failure())
    names = tuple(variable.name for variable in failure)

    def depending(outputs: Iterable[Variable]) -> tuple[Variable, ...]:
        return tuple(replace(output, depends_on=(*output.depends_on, *names)) for output in outputs)

    return ModelDescription(
        name="GtmEnvelope",
        title="Steady flight envelope of the GTM-T2 after a failure, exact",
        groups={
            "case": (altitude, replace(gamma, scale=1.0), *rudder),
            "speed": (speed,),
            "envelope": depending(envelope),
            "flags": depending((feasible, always)),
            "margins": depending(margins),
            "failure": failure,
        },
        stop_time=1.0,
        step_size=0.1,
        usage=USAGE,
        constants={"lower": lower.tolist(), "upper": upper.tolist()},
    )
