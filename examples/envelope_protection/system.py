"""The co-simulation as an SSP 1.0 archive: aircraft, envelope and autopilot, how they are wired, how they start."""

import zipfile
from pathlib import Path

import fmpy
from lxml import etree

from gtm_fmu.units import RAD_PER_DEG

NAMESPACES = {
    "ssd": "http://ssp-standard.org/SSP1/SystemStructureDescription",
    "ssc": "http://ssp-standard.org/SSP1/SystemStructureCommon",
    "ssv": "http://ssp-standard.org/SSP1/SystemStructureParameterValues",
}
STEP_S, STOP_S = 0.02, 130.0
JAM_S, JAM_RAD = 30.0, 20 * RAD_PER_DEG
CONNECTIONS = (
    # The envelope answers at once, so its answers leave before new questions arrive, whatever the tool does first.
    ("envelope.v_min", "autopilot.v_min"),
    ("envelope.v_max", "autopilot.v_max"),
    ("envelope.feasible", "autopilot.feasible"),
    ("aircraft.air.tas", "autopilot.tas"),
    ("aircraft.path.gamma", "autopilot.gamma"),
    ("aircraft.state.phi", "autopilot.phi"),
    ("aircraft.state.p", "autopilot.p"),
    ("aircraft.state.q", "autopilot.q"),
    ("aircraft.state.r", "autopilot.r"),
    ("aircraft.state.altitude", "autopilot.altitude"),
    ("aircraft.authority.rudder.lower", "envelope.rudder.lower"),
    ("aircraft.authority.rudder.upper", "envelope.rudder.upper"),
    ("aircraft.air.tas", "envelope.tas"),
    ("autopilot.altitude_asked", "envelope.altitude"),
    ("autopilot.gamma_asked", "envelope.gamma"),
    ("autopilot.elevator", "aircraft.control.elevator"),
    ("autopilot.aileron", "aircraft.control.aileron"),
    ("autopilot.rudder", "aircraft.control.rudder"),
    ("autopilot.throttle", "aircraft.control.throttle"),
)
"""From an output to an input, each as component and variable."""
FLIGHT: dict[str, float | bool] = {
    "failure.time": JAM_S,
    "limits.rudder.lower": JAM_RAD,
    "limits.rudder.upper": JAM_RAD,
    "fuel.burn": True,
    "wind.north": -2.4,
    "wind.east": 1.8,
}
"""Of the aircraft: the jam, and 3 m/s of wind from the north-west that grows with height."""
PARAMETER_SET = "start"
CONTROLS = ("elevator", "aileron", "rudder", "throttle")


def _tag(tag: str) -> str:
    prefix, local = tag.split(":")
    return f"{{{NAMESPACES[prefix]}}}{local}"


def _add(parent: etree._Element, tag: str, /, **attributes: str) -> etree._Element:
    return etree.SubElement(parent, _tag(tag), attributes)


def _add_value(parent: etree._Element, name: str, value: float | bool) -> None:
    parameter = _add(parent, "ssv:Parameter", name=name)
    if isinstance(value, bool):
        _add(parameter, "ssv:Boolean", value=str(value).lower())
    else:
        _add(parameter, "ssv:Real", value=repr(float(value)))


def _add_component(parent: etree._Element, name: str, fmu: Path, values: dict[str, float | bool]) -> None:
    """A component with a connector for each wired variable and each that is set."""
    variables = {v.name: v for v in fmpy.read_model_description(fmu, validate=False).modelVariables}
    source = {"source": f"resources/{fmu.name}", "type": "application/x-fmu-sharedlibrary"}
    component = _add(parent, "ssd:Component", name=name, **source)
    connectors = _add(component, "ssd:Connectors")
    ends = [end.split(".", 1)[1] for pair in CONNECTIONS for end in pair if end.startswith(f"{name}.")]
    for variable in dict.fromkeys([*ends, *values]):
        connector = _add(connectors, "ssd:Connector", name=variable, kind=variables[variable].causality)
        _add(connector, "ssc:Boolean" if variables[variable].type == "Boolean" else "ssc:Real")
    if values:
        binding = _add(_add(component, "ssd:ParameterBindings"), "ssd:ParameterBinding")
        parameters = _add(_add(binding, "ssd:ParameterValues"), "ssv:ParameterSet", version="1.0", name=PARAMETER_SET)
        listed = _add(parameters, "ssv:Parameters")
        for variable, value in values.items():
            _add_value(listed, variable, value)


def system_structure(fmus: dict[str, Path], is_protected: bool) -> bytes:
    """SystemStructure.ssd of the FMUs ``aircraft``, ``envelope`` and ``autopilot``."""
    starts = {v.name: v.start for v in fmpy.read_model_description(fmus["aircraft"], validate=False).modelVariables}
    trims: dict[str, float | bool] = {f"trim_{name}": float(starts[f"control.{name}"]) for name in CONTROLS}
    values: dict[str, dict] = {
        "aircraft": FLIGHT,
        "envelope": {},
        "autopilot": {"is_protected": is_protected, **trims},
    }
    root = etree.Element(
        _tag("ssd:SystemStructureDescription"), {"version": "1.0", "name": "envelope_protection"}, nsmap=NAMESPACES
    )
    system = _add(root, "ssd:System", name="envelope_protection")
    elements = _add(system, "ssd:Elements")
    for name, fmu in fmus.items():
        _add_component(elements, name, fmu, values[name])
    connections = _add(system, "ssd:Connections")
    for start, end in CONNECTIONS:
        (source, output), (sink, input_) = start.split(".", 1), end.split(".", 1)
        ends = {"startElement": source, "startConnector": output, "endElement": sink, "endConnector": input_}
        _add(connections, "ssd:Connection", **ends)
    _add(root, "ssd:DefaultExperiment", startTime="0.0", stopTime=repr(STOP_S))
    return etree.tostring(root, xml_declaration=True, encoding="UTF-8", pretty_print=True)


def write_ssp(path: Path, fmus: dict[str, Path], is_protected: bool) -> Path:
    """The archive with the FMUs."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("SystemStructure.ssd", system_structure(fmus, is_protected))
        for fmu in fmus.values():
            archive.write(fmu, f"resources/{fmu.name}")
    return path
