"""The description of an FMU: units, variables and model as frozen dataclasses.

It is written as XML (`fmi2_xml`, `fmi3_xml`), as the table that a slave reads in its host (`slave_table`), as that of a
native FMU (`native_sources`), and as documentation.
"""

from dataclasses import dataclass, field
from typing import Any

from gtm_fmu import units

BUILD_DATE = (1980, 1, 1, 0, 0, 0)
"""Every FMU carries this time, the first that a zip archive can hold, so that equal sources give equal bytes."""

BASE_UNITS: dict[str, dict[str, int]] = {
    "1": {},
    "m": {"m": 1},
    "m/s": {"m": 1, "s": -1},
    "m/s2": {"m": 1, "s": -2},
    "rad": {"rad": 1},
    "rad/s": {"rad": 1, "s": -1},
    "rad/s2": {"rad": 1, "s": -2},
    "s": {"s": 1},
    "kg": {"kg": 1},
    "kg/s": {"kg": 1, "s": -1},
    "N": {"kg": 1, "m": 1, "s": -2},
    "Pa": {"kg": 1, "m": -1, "s": -2},
}
"""SI units of the variables as exponents of the base units."""

DISPLAY_UNITS: dict[str, tuple[str, float]] = {
    "%": ("1", 0.01),
    "ft": ("m", units.M_PER_FT),
    "ft/s": ("m/s", units.M_PER_FT),
    "ft/min": ("m/s", units.M_PER_FT / 60),
    "kn": ("m/s", units.M_S_PER_KT),
    "ft/s2": ("m/s2", units.M_PER_FT),
    "deg": ("rad", units.RAD_PER_DEG),
    "deg/s": ("rad/s", units.RAD_PER_DEG),
    "deg/s2": ("rad/s2", units.RAD_PER_DEG),
    "lb": ("kg", units.KG_PER_LB),
    "lb/s": ("kg/s", units.KG_PER_LB),
    "lb/min": ("kg/s", units.KG_PER_LB / 60),
    "lbf": ("N", units.N_PER_LBF),
    "lbf/ft2": ("Pa", units.PA_PER_PSF),
}
"""Units that people think in: the SI unit and its amount in one display unit."""

EXTRA = "extra/alt.gtm-fmu"
"""Folder of expected results. FMI 3.0, 2.5.1, asks for a domain in reverse; under ``alt`` there are none (RFC 9476)."""

LOG_CATEGORIES = {
    "logStatusWarning": "A command is held inside its limits.",
    "logStatusDiscard": "A value or a step is refused, or the outputs cannot be computed.",
    "logStatusError": "A call is refused.",
    "logStatusFatal": "The FMU cannot go on.",
    "logAll": "All messages.",
}


def si(value: float, unit: str) -> float:
    """A value given in an SI or display unit, in SI."""
    return value if unit in BASE_UNITS else value * DISPLAY_UNITS[unit][1]


@dataclass(frozen=True, kw_only=True)
class Variable:
    """A variable; ``unit`` is SI, and start, minimum, maximum and nominal are in it."""

    name: str
    description: str
    causality: str
    variability: str = "continuous"
    initial: str | None = None
    unit: str = "1"
    display_unit: str | None = None
    start: float | None = None
    minimum: float | None = None
    maximum: float | None = None
    nominal: float | None = None
    derivative_of: str | None = None
    depends_on: tuple[str, ...] = ()
    """Known variables that an output or derivative depends on at a communication point."""
    starts: str | None = None
    """The state whose initial value a parameter gives, for importers that set nothing but parameters."""
    boolean: bool = False
    items: tuple[str, ...] = ()
    """Names of the values of an enumeration, 1 and so on."""
    scale: float = 1.0
    """SI per unit in which the slave computes the variable."""
    bounded: bool = False
    """Values outside minimum .. maximum are refused."""
    deferred: bool = False
    """A native FMU computes the output only when it is asked for it or another deferred one."""

    @property
    def is_discrete(self) -> bool:
        """Whether it is no real number."""
        return self.boolean or bool(self.items)

    def displayed(self, value: float) -> float:
        """A value in SI, in the display unit."""
        return value / DISPLAY_UNITS[self.display_unit][1] if self.display_unit else value


def output(name: str, display: str, description: str, **more: Any) -> Variable:
    """A number that is computed, shown in a display unit; with further attributes, or others."""
    unit, scale = DISPLAY_UNITS[display]
    usual: dict[str, Any] = {
        "causality": "output",
        "initial": "calculated",
        "unit": unit,
        "display_unit": display,
        "scale": scale,
    }
    return Variable(name=name, description=description, **usual | more)


def verdict(name: str, description: str, **more: Any) -> Variable:
    """A discrete answer that is computed: yes or no, or one of some ``items``."""
    usual: dict[str, Any] = {
        "causality": "output",
        "variability": "discrete",
        "initial": "calculated",
        "boolean": "items" not in more,
    }
    return Variable(name=name, description=description, **usual | more)


@dataclass(frozen=True, kw_only=True)
class Implementation:
    """How an FMU was made, and what it can do beyond co-simulation."""

    fmi: int
    """2 or 3."""
    tool: str
    needs_execution_tool: bool = False
    has_model_exchange: bool = False
    has_partial_derivatives: bool = False
    """Directional ones, and in FMI 3.0 adjoint ones."""
    memory: int = 0
    """Numbers that a native model keeps between calls of an instance."""
    sources: tuple[str, ...] = ()
    """C files to compile, under the folder of the sources."""


PYTHON_SLAVE = Implementation(fmi=2, tool="gtm-fmu with pythonfmu", needs_execution_tool=True)


@dataclass(frozen=True)
class ModelDescription:
    """A model; the value reference of a variable is its place in the groups."""

    name: str
    title: str
    groups: dict[str, tuple[Variable, ...]]
    stop_time: float
    step_size: float
    usage: tuple[str, ...]
    """How to use the FMU, paragraph by paragraph."""
    limits: dict[str, tuple[str, str]] = field(default_factory=dict)
    """Parameters between which a command is held, lower and upper: known variables as well during initialization."""
    has_free_start: bool = False
    """Whether everything that is computed depends on all known variables during initialization."""
    constants: dict[str, float | list[float]] = field(default_factory=dict)
    """Numbers that the slave needs besides its variables."""
    implementation: Implementation = PYTHON_SLAVE
    origin: str | None = None
    """Where a user's own model comes from; None: this is the aircraft. The names and units of such a model are its
    user's."""

    @property
    def variables(self) -> list[Variable]:
        """All variables in the order of their value references."""
        return [variable for group in self.groups.values() for variable in group]

    @property
    def outputs(self) -> list[Variable]:
        """Variables that are outputs."""
        return [variable for variable in self.variables if variable.causality == "output"]

    @property
    def derivatives(self) -> list[Variable]:
        """Derivatives of the states."""
        return [variable for variable in self.variables if variable.derivative_of]

    @property
    def has_step_events(self) -> bool:
        """Whether model exchange has events: a discrete output that is about to change asks for one."""
        return any(variable.is_discrete for variable in self.outputs)

    @property
    def initial_unknowns(self) -> list[Variable]:
        """Variables that are computed during initialization."""
        return [variable for variable in self.variables if variable.initial == "calculated"]

    def knowns(self, unknown: Variable, is_initial: bool) -> list[str] | None:
        """Names of what an unknown depends on at a communication point, or during initialization; None: on all."""
        if is_initial and self.has_free_start:
            return None
        starts = {variable.starts: variable.name for variable in self.variables if variable.starts}
        parameters = [name for known in unknown.depends_on for name in self.limits.get(known, ())]
        parameters += [starts[known] for known in unknown.depends_on if known in starts]
        return [*unknown.depends_on, *parameters] if is_initial else list(unknown.depends_on)


def slave_table(model: ModelDescription) -> dict:
    """The variables as the slave reads them: names, start values, scales and the bounds of parameters."""
    variables = model.variables
    place = {variable.name: index for index, variable in enumerate(variables)}
    return {
        "model": model.name,
        "log_categories": LOG_CATEGORIES,
        "constants": model.constants,
        "names": list(place),
        "units": [variable.unit for variable in variables],
        "starts": [0.0 if variable.start is None else float(variable.start) for variable in variables],
        "scales": [variable.scale for variable in variables],
        "booleans": [place[variable.name] for variable in variables if variable.boolean],
        "enumerations": [place[variable.name] for variable in variables if variable.items],
        "computed": [place[variable.name] for variable in model.initial_unknowns],
        "bounds": {
            str(place[variable.name]): [variable.minimum, variable.maximum]
            for variable in variables
            if variable.bounded
        },
        "groups": {
            name: [place[group[0].name], place[group[0].name] + len(group)] for name, group in model.groups.items()
        },
    }
