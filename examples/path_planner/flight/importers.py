"""The aircraft's FMU in two tools: values set and read by name, in SI, and steps taken."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Protocol

import numpy as np

from gtm_fmu.aircraft.client import FmuClient

Values = Mapping[str, float | bool]


class Aircraft(Protocol):
    """One flight in a tool."""

    def set(self, names: Sequence[str], values: Sequence[float]) -> None:
        """Set inputs."""

    def get(self, names: Sequence[str]) -> np.ndarray:
        """Values of outputs."""

    def step(self) -> None:
        """One step."""

    def close(self) -> None:
        """Free the FMU."""


class FmpyAircraft:
    """FMPy, which calls the FMU."""

    def __init__(self, fmu: Path, start: Values, step_s: float) -> None:
        self._client, self._step_s = FmuClient(fmu), step_s
        for name in start:
            if self._client.is_boolean(name):
                self._client.set_boolean(name, bool(start[name]))
        reals = {name: float(value) for name, value in start.items() if not self._client.is_boolean(name)}
        self._client.set(tuple(reals), list(reals.values()))
        self.set, self.get, self.close = self._client.set, self._client.get, self._client.close

    def step(self) -> None:
        """One step."""
        self._client.step(self._step_s)


class EcosAircraft:
    """Ecos, through its Python package."""

    def __init__(self, fmu: Path, start: Values, step_s: float) -> None:
        from ecospy.EcosSimulation import EcosSimulation
        from ecospy.EcosSimulationStructure import EcosSimulationStructure

        self._structure = EcosSimulationStructure()
        self._structure.add_model("aircraft", fmu)
        values = {f"aircraft::{name}": v if isinstance(v, bool) else float(v) for name, v in start.items()}
        self._structure.add_parameter_set("start", values)
        self._simulation = EcosSimulation(structure=self._structure, step_size=step_s)
        self._simulation.init(parameter_set="start")

    def set(self, names: Sequence[str], values: Sequence[float]) -> None:
        """Set inputs."""
        for name, value in zip(names, values, strict=True):
            self._simulation.set_real(f"aircraft::{name}", float(value))

    def get(self, names: Sequence[str]) -> np.ndarray:
        """Values of outputs."""
        return np.array([self._simulation.get_real(f"aircraft::{name}") for name in names])

    def step(self) -> None:
        """One step."""
        self._simulation.step(1)

    def close(self) -> None:
        """Free the simulation."""
        self._simulation.free()
        self._structure.free()


IMPORTERS: dict[str, type[FmpyAircraft] | type[EcosAircraft]] = {"FMPy": FmpyAircraft, "ecospy": EcosAircraft}
PACKAGES = {"FMPy": "fmpy", "ecospy": "ecospy"}
