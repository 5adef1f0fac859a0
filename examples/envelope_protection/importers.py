"""The same SSP archive in three co-simulation tools; each runs in a process of its own and writes what it finds as CSV.

python importers.py TOOL SSP CSV [SECONDS]
"""

import csv
import sys
import tempfile
import zipfile
from collections.abc import Callable, Iterator
from pathlib import Path

from fmpy.ssp.ssd import SystemStructureDescription, read_ssd

from examples.envelope_protection.system import PARAMETER_SET, STEP_S, STOP_S
from gtm_fmu.aircraft.client import FmuClient

RECORDED = (
    "aircraft.air.tas",
    "aircraft.air.alpha",
    "aircraft.path.gamma",
    "aircraft.state.phi",
    "aircraft.state.altitude",
    "aircraft.state.latitude",
    "aircraft.state.longitude",
    "aircraft.surface.aileron",
    "aircraft.surface.rudder",
    "aircraft.engine.throttle",
    "aircraft.fuel.used",
    "autopilot.known_v_min",
    "autopilot.known_v_max",
    "autopilot.tas_planned",
    "autopilot.tas_command",
)
"""Component and variable."""


def _ends(name: str) -> tuple[str, str]:
    component, variable = name.split(".", 1)
    return component, variable


def run_fmpy(ssp: Path, steps: int) -> Iterator[list[float]]:
    """FMPy reads the archive and calls the FMUs; all step at once, then outputs go to the inputs they are wired to."""
    with tempfile.TemporaryDirectory() as folder, zipfile.ZipFile(ssp) as archive:
        archive.extractall(folder)
        system = read_ssd(str(ssp))
        clients = {part.name: FmuClient(Path(folder, part.source)) for part in system.system.elements}
        try:
            yield from _steps(system, clients, steps)
        finally:
            for client in clients.values():
                client.close()


def _steps(system: SystemStructureDescription, clients: dict[str, FmuClient], steps: int) -> Iterator[list[float]]:
    for part in system.system.elements:
        for binding in part.parameterBindings:
            for given in binding.parameterValues[0].parameters:
                set_value(clients[part.name], given.name, given.value)

    def exchange() -> None:
        for wire in system.system.connections:
            value = get_value(clients[wire.startElement], wire.startConnector)
            set_value(clients[wire.endElement], wire.endConnector, value)

    for _ in clients:  # what is wired through several components arrives after as many rounds
        exchange()
    for step in range(steps + 1):
        if step:
            for client in clients.values():
                client.step(STEP_S)
            exchange()
        yield [float(clients[component].get([variable])[0]) for component, variable in map(_ends, RECORDED)]


def get_value(client: FmuClient, name: str) -> float | bool:
    """A real or Boolean value."""
    return client.get_boolean(name) if client.is_boolean(name) else float(client.get([name])[0])


def set_value(client: FmuClient, name: str, value) -> None:
    """Set a real or Boolean value, given as such or as text."""
    if client.is_boolean(name):
        client.set_boolean(name, value in (True, "true"))
    else:
        client.set([name], [float(value)])


def run_ecospy(ssp: Path, steps: int) -> Iterator[list[float]]:
    """Ecos, through its Python package."""
    from ecospy.EcosSimulation import EcosSimulation

    names = ["::".join(_ends(name)) for name in RECORDED]
    with EcosSimulation(ssp_path=str(ssp), step_size=STEP_S) as simulation:
        simulation.init(parameter_set=PARAMETER_SET)
        for step in range(steps + 1):
            if step:
                simulation.step(1)
            yield [simulation.get_real(name) for name in names]


def run_libcosimpy(ssp: Path, steps: int) -> Iterator[list[float]]:
    """libcosim of the Open Simulation Platform, through its Python package."""
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
    from libcosimpy.CosimObserver import CosimObserver

    log_output_level(CosimLogLevel.WARNING)
    execution = CosimExecution.from_ssp_file(str(ssp), step_size=round(STEP_S * 1e9))
    observer = CosimObserver.create_last_value()
    execution.add_observer(observer)
    places = []
    for component, variable in map(_ends, RECORDED):
        index = execution.slave_index_from_instance_name(component)
        known = {info.name.decode(): info.reference for info in execution.slave_variables(index)}
        places.append((index, known[variable]))
    for _ in range(steps):
        if not execution.step(1):
            raise RuntimeError("libcosim refused a step.")
        yield [observer.last_real_values(index, [reference])[0] for index, reference in places]


IMPORTERS: dict[str, Callable[[Path, int], Iterator[list[float]]]] = {
    "FMPy": run_fmpy,
    "ecospy": run_ecospy,
    "libcosimpy": run_libcosimpy,
}


def main() -> None:
    """Run one tool."""
    tool, ssp, target, *seconds = sys.argv[1:]
    steps = round(float(seconds[0] if seconds else STOP_S) / STEP_S)
    rows = list(IMPORTERS[tool](Path(ssp), steps))
    with open(target, "w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["time", *RECORDED])
        first = steps + 1 - len(rows)  # a tool may not tell the values before the first step
        writer.writerows([[repr((first + i) * STEP_S), *map(repr, row)] for i, row in enumerate(rows)])


if __name__ == "__main__":
    main()
