"""The variables of GtmDynamicsNative: those of GtmDynamics, the tolerance of its second method and the time."""

from dataclasses import replace

from fmu_src.description import Implementation, ModelDescription, Variable
from fmu_src.dynamics_variables import USAGE, dynamics_description
from fmu_src.gtm_dynamics import FAULTS

TOLERANCE = Variable(
    name="solver.tolerance",
    description="Relative error of a step of the adaptive integration (Dormand-Prince 5(4)); 0: fixed steps",
    causality="parameter",
    variability="tunable",
    initial="exact",
    start=0.0,
    minimum=0.0,
    maximum=1e-2,
    nominal=1e-6,
)
TIME = Variable(name="time", description="Simulation time", causality="independent", unit="s")
DYNAMICS_FAULTS = ("", *FAULTS.values(), "The step cannot be integrated to solver.tolerance.")
"""By fault; the last is that of dynamics.c."""

_NATIVE_USAGE = (
    "With solver.tolerance above 0 a co-simulation step is integrated by an embedded pair of orders 5 and 4 with "
    "control of the error, beginning each communication step with its whole length.",
    "In model exchange there are 12 continuous states, no events and exact partial derivatives of der(state.*) and of "
    "all outputs with respect to states and controls, and to limits.*. At a breakpoint of the aerodynamic tables they "
    "are those of the interval above; with respect to a control that is held they are zero.",
    "A call that the standard does not allow at its place, a value reference that does not exist, a null pointer or a "
    "token of another FMU gives the status Error, one sentence in the log, and changes nothing. A value that is not "
    "finite, or a parameter outside its bounds, gives Discard; the old value is kept, and nothing is computed until a "
    "good one comes.",
)


def native_dynamics_description(fmi: int, sources: tuple[str, ...]) -> ModelDescription:
    """The description of the native FMU of FMI 2 or 3."""
    model = dynamics_description()
    return replace(
        model,
        name="GtmDynamicsNative" if fmi == 2 else "GtmDynamicsNative3",
        groups={**model.groups, "solver": (*model.groups["solver"], TOLERANCE), "time": (TIME,)},
        usage=(*USAGE, *_NATIVE_USAGE),
        implementation=Implementation(
            fmi=fmi,
            tool="gtm-fmu",
            has_model_exchange=True,
            has_partial_derivatives=True,
            sources=sources,
        ),
    )
