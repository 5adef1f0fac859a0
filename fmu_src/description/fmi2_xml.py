"""modelDescription.xml of FMI 2.0 (FMI 2.0.4, sections 2.2, 3.3 and 4.3)."""

from collections.abc import Sequence

from lxml import etree

from fmu_src.description import xml_elements as xml
from fmu_src.description.model_description import ModelDescription, Variable


def write_fmi2(model: ModelDescription, guid: str, version: str) -> bytes:
    """The description of a model in FMI 2.0."""
    head = {"fmiVersion": "2.0", "guid": guid, "numberOfEventIndicators": "0"}
    root = etree.Element("fmiModelDescription", head | xml.root_attributes(model, version))
    made = model.implementation
    common = {
        "modelIdentifier": model.name,
        "needsExecutionTool": made.needs_execution_tool,
        "canGetAndSetFMUstate": True,
        "canSerializeFMUstate": True,
        "canNotUseMemoryManagementFunctions": True,
        "providesDirectionalDerivative": made.has_partial_derivatives,
    }
    kinds = {"CoSimulation": {"canHandleVariableCommunicationStepSize": True}}
    if made.has_model_exchange:
        kinds = {"ModelExchange": {"completedIntegratorStepNotNeeded": not model.has_step_events}, **kinds}
    for kind, own in kinds.items():
        element = etree.SubElement(root, kind, xml.attributes(common | own))
        if made.sources:
            files = etree.SubElement(element, "SourceFiles")
            for name in made.sources:
                etree.SubElement(files, "File", name=name)
    xml.add_head(root, model, _add_enumeration)
    variables = etree.SubElement(root, "ModelVariables")
    index = {variable.name: place for place, variable in enumerate(model.variables, start=1)}
    for variable in model.variables:
        _add_variable(variables, variable, index)
    _add_structure(root, model, index)
    return xml.document(root)


def _add_enumeration(parent: etree._Element, name: str) -> etree._Element:
    return etree.SubElement(etree.SubElement(parent, "SimpleType", name=name), "Enumeration")


def _add_variable(parent: etree._Element, variable: Variable, index: dict[str, int]) -> None:
    common = xml.attributes(xml.variable_attributes(variable, index[variable.name] - 1))
    tag, own = xml.type_and_attributes(variable, index, "Real")
    etree.SubElement(etree.SubElement(parent, "ScalarVariable", common), tag, xml.attributes(own))


def _add_structure(root: etree._Element, model: ModelDescription, index: dict[str, int]) -> None:
    """ModelStructure: what is an output, a derivative, unknown at the start, and what each depends on."""
    structure = etree.SubElement(root, "ModelStructure")

    def add(tag: str, unknowns: Sequence[Variable], is_initial: bool) -> None:
        if not unknowns:
            return
        parent = etree.SubElement(structure, tag)
        for variable in unknowns:
            knowns = model.knowns(variable, is_initial)
            given = {"index": index[variable.name], "dependencies": xml.places(knowns, index)}
            etree.SubElement(parent, "Unknown", xml.attributes(given))

    add("Outputs", model.outputs, is_initial=False)
    add("Derivatives", model.derivatives, is_initial=False)
    add("InitialUnknowns", model.initial_unknowns, is_initial=True)
