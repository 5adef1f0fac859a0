"""What can be wrong with the failure that an FMU is told. It runs in the Python of the host."""

_LIMITED = (
    "limits.elevator",
    "limits.aileron",
    "limits.rudder",
    "limits.throttle",
    "limits.throttle.left",
    "limits.throttle.right",
    "limits.alpha",
    "limits.bank",
)
"""Pairs of limits in the order of ``gtm_failure``."""

FAILURE_FAULTS = (
    "",
    "The outputs are not finite.",
    *(f"The limits are reversed: {name}.lower is above {name}.upper." for name in _LIMITED),
    "No throttle is left: limits.throttle.* and those of the engines that run have none in common.",
    "damage.case is no whole number, or there is no such case.",
    "The stabiliser, the flaps, the spoilers, the gear or the fuel used is out of range.",
    "The rudder limits are reversed: rudder.lower is above rudder.upper.",
    "No rudder is left: rudder.* and limits.rudder.* have no deflection in common.",
    "There are no slopes here: what is asked about is settled by nothing, or by too much at once.",
)
"""By fault: ``enum gtm_failure_fault`` of gtm_failure.h."""
