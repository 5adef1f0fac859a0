"""What a native FMU adds to the variables of its pythonfmu sibling: the time, and the tolerance of the dynamics."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

from fmu_src.description.model_description import Implementation, ModelDescription, Variable
from fmu_src.slaves.gtm_dynamics import FAULTS

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
    bounded=True,
)
TIME = Variable(name="time", description="Simulation time", causality="independent", unit="s")
DYNAMICS_FAULTS = ("", *FAULTS.values(), "The step cannot be integrated to solver.tolerance.")
"""By fault; the last is that of dynamics.c."""

DYNAMICS_USAGE = (
    "With solver.tolerance above 0 a co-simulation step is integrated by an embedded pair of orders 5 and 4 with "
    "control of the error, beginning each communication step with its whole length.",
    "In model exchange there are 12 continuous states, no events and exact partial derivatives of der(state.*) and of "
    "all outputs with respect to states and controls, and to limits.*. At a breakpoint of the aerodynamic tables they "
    "are those of the interval above; with respect to a control that is held they are zero.",
)

STARTS_USAGE = (
    "A changed start.* sets its state, so that importers that set nothing but parameters can set initial states; "
    "whatever is set last counts.",
)


def start_parameters(states: Sequence[Variable]) -> tuple[Variable, ...]:
    """Parameters start.* that give the states their initial values."""
    return tuple(
        replace(
            state,
            name=f"start.{state.name.removeprefix('state.')}",
            description=f"Initial value of {state.name}",
            causality="parameter",
            variability="fixed",
            starts=state.name,
            depends_on=(),
        )
        for state in states
    )


_STEP_EVENTS = (
    "In model exchange there are no states. The Boolean outputs change at events only: where the inputs would change "
    "one, CompletedIntegratorStep asks for an event.",
)
_CALLS = (
    "A call that the standard does not allow at its place, a value reference that does not exist, a null pointer or a "
    "token of another FMU gives the status Error, one sentence in the log, and changes nothing. A value that is not "
    "finite, or outside bounds that are enforced, gives Discard; the old value is kept, and nothing is computed until "
    "a good one comes."
)


def native_description(
    model: ModelDescription,
    name: str,
    fmi: int,
    sources: tuple[str, ...],
    usage: tuple[str, ...],
    groups: Mapping[str, tuple[Variable, ...]],
    later: Sequence[str],
    has_partial_derivatives: bool,
    memory: int,
    has_model_exchange: bool,
) -> ModelDescription:
    """The description of the native FMU of FMI 2 or 3 with the variables of a pythonfmu one.

    Args:
        sources: C files to compile.
        usage: paragraphs on what only the native FMU does.
        groups: variables that it adds, or has in place of the other's.
        later: groups that come after the time, since they are newer than its value reference.
    """
    events = _STEP_EVENTS if has_model_exchange and model.has_step_events else ()
    own = {**model.groups, **groups}
    last = {group: own.pop(group) for group in later}
    return replace(
        model,
        name=name,
        groups={**own, "time": (TIME,), **last},
        usage=(*model.usage, *events, *usage, _CALLS),
        implementation=Implementation(
            fmi=fmi,
            tool="gtm-fmu",
            has_model_exchange=has_model_exchange,
            has_partial_derivatives=has_partial_derivatives,
            memory=memory,
            sources=sources,
        ),
    )
