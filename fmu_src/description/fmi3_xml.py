"""XML files of FMI 3.0: modelDescription (section 2.4), buildDescription (2.5.2.1), terminalsAndIcons (2.5.4)."""

from collections.abc import Sequence

from lxml import etree

from fmu_src.description import xml_elements as xml
from fmu_src.description.model_description import ModelDescription, Variable


def write_fmi3(model: ModelDescription, token: str, version: str) -> bytes:
    """The description of a model in FMI 3.0."""
    head = {"fmiVersion": "3.0", "instantiationToken": token}
    root = etree.Element("fmiModelDescription", head | xml.root_attributes(model, version))
    made = model.implementation
    common = {
        "modelIdentifier": model.name,
        "needsExecutionTool": made.needs_execution_tool,
        "canGetAndSetFMUState": True,
        "canSerializeFMUState": True,
        "providesDirectionalDerivatives": made.has_partial_derivatives,
        "providesAdjointDerivatives": made.has_partial_derivatives,
    }
    if made.has_model_exchange:
        etree.SubElement(
            root, "ModelExchange", xml.attributes(common | {"needsCompletedIntegratorStep": model.has_step_events})
        )
    own = {"canHandleVariableCommunicationStepSize": True, "hasEventMode": False}
    etree.SubElement(root, "CoSimulation", xml.attributes(common | own))
    xml.add_head(root, model, _add_enumeration)
    variables = etree.SubElement(root, "ModelVariables")
    reference = {variable.name: place for place, variable in enumerate(model.variables)}
    for variable in model.variables:
        _add_variable(variables, variable, reference)
    _add_structure(root, model, reference)
    return xml.document(root)


def _add_enumeration(parent: etree._Element, name: str) -> etree._Element:
    return etree.SubElement(parent, "EnumerationType", name=name)


def _add_variable(parent: etree._Element, variable: Variable, reference: dict[str, int]) -> None:
    common = xml.variable_attributes(variable, reference[variable.name])
    tag, own = xml.type_and_attributes(variable, reference, "Float64")
    etree.SubElement(parent, tag, xml.attributes(common | own))


def _add_structure(root: etree._Element, model: ModelDescription, reference: dict[str, int]) -> None:
    """ModelStructure: what is an output, a derivative, unknown at the start, and what each depends on."""
    structure = etree.SubElement(root, "ModelStructure")

    def add(tag: str, unknowns: Sequence[Variable], is_initial: bool) -> None:
        for variable in unknowns:
            knowns = model.knowns(variable, is_initial)
            given = {"valueReference": reference[variable.name], "dependencies": xml.places(knowns, reference)}
            etree.SubElement(structure, tag, xml.attributes(given))

    add("Output", model.outputs, is_initial=False)
    add("ContinuousStateDerivative", model.derivatives, is_initial=False)
    add("InitialUnknown", model.initial_unknowns, is_initial=True)


def write_build_description(model: ModelDescription) -> bytes:
    """sources/buildDescription.xml: how to compile the sources."""
    root = etree.Element("fmiBuildDescription", fmiVersion="3.0")
    configuration = etree.SubElement(root, "BuildConfiguration", modelIdentifier=model.name)
    files = etree.SubElement(configuration, "SourceFileSet", language="C99")
    for name in model.implementation.sources:
        etree.SubElement(files, "SourceFile", name=name)
    shared = "For a shared library. Without it the names of all functions begin with the model identifier."
    definition = {"name": "FMI3_OVERRIDE_FUNCTION_PREFIX", "optional": True, "description": shared}
    etree.SubElement(files, "PreprocessorDefinition", xml.attributes(definition))
    etree.SubElement(configuration, "Library", name="m", external="true", description="Mathematics of the C library")
    return xml.document(root)


def write_terminals_and_icons() -> bytes:
    """terminalsAndIcons/terminalsAndIcons.xml: the icon in a square."""
    root = etree.Element("fmiTerminalsAndIcons", fmiVersion="3.0")
    representation = etree.SubElement(root, "GraphicalRepresentation")
    corners = {"x1": -100.0, "y1": -100.0, "x2": 100.0, "y2": 100.0}
    etree.SubElement(representation, "CoordinateSystem", xml.attributes(corners | {"suggestedScalingFactorTo_mm": 0.1}))
    etree.SubElement(representation, "Icon", xml.attributes(corners))
    return xml.document(root)
