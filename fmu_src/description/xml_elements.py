"""Parts of modelDescription.xml that FMI 2.0 and 3.0 write alike."""

from collections.abc import Callable, Sequence
from typing import Any

from lxml import etree

from fmu_src.description.model_description import (
    BASE_UNITS,
    BUILD_DATE,
    DISPLAY_UNITS,
    LOG_CATEGORIES,
    ModelDescription,
    Variable,
)


def attributes(values: dict) -> dict[str, str]:
    """XML attributes of the values that are given; numbers to the last digit."""
    texts = {bool: lambda value: str(value).lower(), float: repr}
    return {name: texts.get(type(value), str)(value) for name, value in values.items() if value is not None}


def places(names: Sequence[str] | None, place: dict[str, int]) -> str | None:
    """What an unknown depends on, as an attribute; without it, it depends on all."""
    return None if names is None else " ".join(map(str, sorted(place[name] for name in names)))


def root_attributes(model: ModelDescription, version: str) -> dict[str, str]:
    """What both standards say about a model as a whole."""
    year, month, day, hour, minute, second = BUILD_DATE
    values = {
        "modelName": model.name,
        "description": model.title,
        "version": version,
        "license": "Apache-2.0" if model.origin is None else None,
        "generationTool": model.implementation.tool,
        "generationDateAndTime": f"{year:04}-{month:02}-{day:02}T{hour:02}:{minute:02}:{second:02}Z",
        "variableNamingConvention": "structured" if model.origin is None else "flat",
    }
    return attributes(values)


def type_name(variable: Variable) -> str:
    """Of an enumeration."""
    return variable.name.capitalize()


def add_head(
    root: etree._Element, model: ModelDescription, add_enumeration: Callable[[etree._Element, str], etree._Element]
) -> None:
    """Units, enumerations, log categories and the default experiment.

    Args:
        add_enumeration: adds the definition of a named type; what it gives holds the items.
    """
    _add_units(root, model.variables)
    enumerations = [variable for variable in model.variables if variable.items]
    definitions = etree.SubElement(root, "TypeDefinitions") if enumerations else root
    for variable in enumerations:
        items = add_enumeration(definitions, type_name(variable))
        for value, name in enumerate(variable.items, start=1):
            etree.SubElement(items, "Item", name=name, value=str(value))
    categories = etree.SubElement(root, "LogCategories")
    for name, description in LOG_CATEGORIES.items():
        etree.SubElement(categories, "Category", name=name, description=description)
    experiment = {"startTime": 0.0, "stopTime": model.stop_time, "stepSize": model.step_size}
    etree.SubElement(root, "DefaultExperiment", attributes(experiment))


def _add_units(root: etree._Element, variables: Sequence[Variable]) -> None:
    definitions = etree.SubElement(root, "UnitDefinitions")
    used = {variable.unit for variable in variables if not variable.is_discrete}
    known = [name for name in (*BASE_UNITS, *DISPLAY_UNITS) if name in used]
    for name in [*known, *sorted(used.difference(known))]:
        unit = etree.SubElement(definitions, "Unit", name=name)
        si_unit, factor = DISPLAY_UNITS.get(name, (name, None))
        if si_unit in BASE_UNITS:
            etree.SubElement(unit, "BaseUnit", attributes(BASE_UNITS[si_unit] | {"factor": factor}))
        displayed = {variable.display_unit for variable in variables if variable.unit == name}
        for display, (_, si_per_display) in DISPLAY_UNITS.items():
            if display in displayed:
                etree.SubElement(unit, "DisplayUnit", attributes({"name": display, "factor": 1 / si_per_display}))


def variable_attributes(variable: Variable, reference: int) -> dict[str, Any]:
    """What both standards say about a variable, in their order."""
    return {
        "name": variable.name,
        "valueReference": reference,
        "description": variable.description,
        "causality": variable.causality,
        "variability": variable.variability,
        "initial": variable.initial,
    }


def type_and_attributes(variable: Variable, place: dict[str, int], number: str) -> tuple[str, dict[str, Any]]:
    """Name of its type's element, and what stands there; ``place`` as a derivative points at its state.

    Args:
        number: what the standard calls a floating-point number.
    """
    if variable.boolean:
        return "Boolean", {"start": None if variable.start is None else bool(variable.start)}
    if variable.items:
        return "Enumeration", {"declaredType": type_name(variable)}
    return number, {
        "unit": variable.unit,
        "displayUnit": variable.display_unit,
        "min": variable.minimum,
        "max": variable.maximum,
        "nominal": variable.nominal,
        "start": variable.start,
        "derivative": place[variable.derivative_of] if variable.derivative_of else None,
    }


def document(root: etree._Element) -> bytes:
    """The file of an element."""
    return etree.tostring(root, xml_declaration=True, encoding="UTF-8", pretty_print=True)
