"""The description of an FMU: units, variables and model as frozen dataclasses, written as FMI 2.0 XML.

The same variables are the table that the slave reads in its host (`slave_table`) and that the documentation prints.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

from lxml import etree

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
    "lbf": ("N", units.N_PER_LBF),
    "lbf/ft2": ("Pa", units.PA_PER_PSF),
}
"""Units that people think in: the SI unit and its amount in one display unit."""

LOG_CATEGORIES = {
    "logStatusWarning": "A command is held inside its limits.",
    "logStatusDiscard": "A step is refused.",
    "logStatusError": "A value is refused, or the outputs cannot be computed.",
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
    boolean: bool = False
    scale: float = 1.0
    """SI per unit in which the slave computes the variable."""

    @property
    def is_calculated(self) -> bool:
        """Whether the FMU computes the value during initialization."""
        return self.initial == "calculated"

    def displayed(self, value: float) -> float:
        """A value in SI, in the display unit."""
        return value / DISPLAY_UNITS[self.display_unit][1] if self.display_unit else value


@dataclass(frozen=True)
class ModelDescription:
    """An FMI 2.0 co-simulation model; the value reference of a variable is its place in the groups."""

    name: str
    title: str
    groups: dict[str, tuple[Variable, ...]]
    stop_time: float
    step_size: float
    usage: tuple[str, ...]
    """How to use the FMU, paragraph by paragraph."""
    initial_knowns: dict[str, tuple[str, ...]] = field(default_factory=dict)
    """Parameters that come with a known variable during initialization."""
    constants: dict[str, float] = field(default_factory=dict)
    """Numbers that the slave needs besides its variables."""

    @property
    def variables(self) -> list[Variable]:
        """All variables in the order of their value references."""
        return [variable for group in self.groups.values() for variable in group]


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
        "bounds": {
            str(place[variable.name]): [variable.minimum, variable.maximum]
            for variable in variables
            if variable.causality == "parameter"
        },
        "groups": {
            name: [place[group[0].name], place[group[0].name] + len(group)] for name, group in model.groups.items()
        },
    }


def write_xml(model: ModelDescription, guid: str, version: str) -> bytes:
    """modelDescription.xml of the model (FMI 2.0.4, sections 2.2 and 4.3)."""
    year, month, day, hour, minute, second = BUILD_DATE
    root = etree.Element(
        "fmiModelDescription",
        fmiVersion="2.0",
        modelName=model.name,
        guid=guid,
        description=model.title,
        version=version,
        license="Apache-2.0",
        generationTool="gtm-fmu with pythonfmu",
        generationDateAndTime=f"{year:04}-{month:02}-{day:02}T{hour:02}:{minute:02}:{second:02}Z",
        variableNamingConvention="structured",
        numberOfEventIndicators="0",
    )
    etree.SubElement(
        root,
        "CoSimulation",
        modelIdentifier=model.name,
        needsExecutionTool="true",
        canHandleVariableCommunicationStepSize="true",
        canGetAndSetFMUstate="true",
        canSerializeFMUstate="true",
        canNotUseMemoryManagementFunctions="true",
    )
    _add_units(root, model.variables)
    categories = etree.SubElement(root, "LogCategories")
    for name, description in LOG_CATEGORIES.items():
        etree.SubElement(categories, "Category", name=name, description=description)
    experiment = {"startTime": 0.0, "stopTime": model.stop_time, "stepSize": model.step_size}
    etree.SubElement(root, "DefaultExperiment", _attributes(experiment))
    variables = etree.SubElement(root, "ModelVariables")
    index = {variable.name: place for place, variable in enumerate(model.variables, start=1)}
    for variable in model.variables:
        _add_variable(variables, variable, index)
    _add_structure(root, model, index)
    return etree.tostring(root, xml_declaration=True, encoding="UTF-8", pretty_print=True)


def _attributes(values: dict) -> dict[str, str]:
    """XML attributes of the values that are given; numbers to the last digit."""
    texts = {bool: lambda value: str(value).lower(), float: repr}
    return {name: texts.get(type(value), str)(value) for name, value in values.items() if value is not None}


def _add_units(root: etree._Element, variables: Sequence[Variable]) -> None:
    definitions = etree.SubElement(root, "UnitDefinitions")
    used = {variable.unit for variable in variables if not variable.boolean}
    for name in (unit for unit in BASE_UNITS if unit in used):
        unit = etree.SubElement(definitions, "Unit", name=name)
        etree.SubElement(unit, "BaseUnit", _attributes(BASE_UNITS[name]))
        displayed = {variable.display_unit for variable in variables if variable.unit == name}
        for display, (_, si_per_display) in DISPLAY_UNITS.items():
            if display in displayed:
                etree.SubElement(unit, "DisplayUnit", _attributes({"name": display, "factor": 1 / si_per_display}))


def _add_variable(parent: etree._Element, variable: Variable, index: dict[str, int]) -> None:
    common = {
        "name": variable.name,
        "valueReference": index[variable.name] - 1,
        "description": variable.description,
        "causality": variable.causality,
        "variability": variable.variability,
        "initial": variable.initial,
    }
    element = etree.SubElement(parent, "ScalarVariable", _attributes(common))
    if variable.boolean:
        start = None if variable.start is None else bool(variable.start)
        etree.SubElement(element, "Boolean", _attributes({"start": start}))
        return
    real = {
        "unit": variable.unit,
        "displayUnit": variable.display_unit,
        "min": variable.minimum,
        "max": variable.maximum,
        "nominal": variable.nominal,
        "start": variable.start,
        "derivative": index[variable.derivative_of] if variable.derivative_of else None,
    }
    etree.SubElement(element, "Real", _attributes(real))


def _add_structure(root: etree._Element, model: ModelDescription, index: dict[str, int]) -> None:
    """ModelStructure: what is an output, a derivative, unknown at the start, and what each depends on."""
    structure = etree.SubElement(root, "ModelStructure")
    variables = model.variables
    outputs = [variable for variable in variables if variable.causality == "output"]
    derivatives = [variable for variable in variables if variable.derivative_of]
    calculated = [variable for variable in variables if variable.is_calculated]

    def unknown(parent: etree._Element, variable: Variable, knowns: Sequence[str]) -> None:
        dependencies = " ".join(str(place) for place in sorted(index[name] for name in knowns))
        etree.SubElement(parent, "Unknown", index=str(index[variable.name]), dependencies=dependencies)

    for tag, unknowns in (("Outputs", outputs), ("Derivatives", derivatives)):
        if unknowns:
            parent = etree.SubElement(structure, tag)
            for variable in unknowns:
                unknown(parent, variable, variable.depends_on)
    if calculated:
        parent = etree.SubElement(structure, "InitialUnknowns")
        for variable in calculated:
            parameters = [name for known in variable.depends_on for name in model.initial_knowns.get(known, ())]
            unknown(parent, variable, [*variable.depends_on, *parameters])
