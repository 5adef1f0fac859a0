"""A flight as time goes on: servos, delays, throttle lag, fuel, wind and a failure at its time (SPEC 10).

In the specification's units and the orders of `names`: states (13) SIMULATION_STATES, inputs (13) SIMULATION_INPUTS,
outputs (32) SIMULATION_OUTPUTS.
"""

import ctypes
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike

from gtm_fmu.airframe.actuators import RATE_LIMIT_DEG_S
from gtm_fmu.airframe.names import (
    SIMULATION_INPUTS,
    SIMULATION_OUTPUTS,
    SIMULATION_SETTINGS,
    SIMULATION_STATES,
)
from gtm_fmu.airframe.wind import RUNWAY_ALTITUDE_FT
from gtm_fmu.core.library import address, library, rows
from gtm_fmu.core.motion import MOST_SUBSTEPS
from gtm_fmu.errors import InputError

NX, NU, NY = len(SIMULATION_STATES), len(SIMULATION_INPUTS), len(SIMULATION_OUTPUTS)
FAULTS = {
    1: "A number is not finite",
    2: "The airspeed is below 1 ft/s",
    3: "The sideslip is 90 deg",
    4: "The pitch angle is 90 or -90 deg",
    5: "The latitude is 90 or -90 deg",
    6: f"A duration is negative, a substep is not positive or there are more than {MOST_SUBSTEPS} of them",
    7: "The limits of a control are reversed",
    8: "A setting, command, wind or the fuel used is outside its range",
    9: "The commands changed more than 2048 times within the delays: take longer steps or shorter delays",
    10: "The memory of the actuators is damaged",
}
"""``enum gtm_fault`` and ``enum gtm_simulation_fault``."""

DEFAULTS: dict[str, float] = {
    **{"elevator_lower": -30.0, "elevator_upper": 30.0, "aileron_lower": -20.0, "aileron_upper": 20.0},
    **{"rudder_lower": -30.0, "rudder_upper": 30.0, "throttle_lower": 0.0, "throttle_upper": 100.0},
    **dict.fromkeys(("elevator_rate", "aileron_rate", "rudder_rate"), RATE_LIMIT_DEG_S),
    **{"failure_time": 0.0, "damage_case": 0, "engine_left_running": 1, "engine_right_running": 1},
    **{"stabilizer": 0.0, "has_shear": 1, "runway_altitude": RUNWAY_ALTITUDE_FT, "has_stall_asymmetry": 0},
    **{"has_servos": 1, "has_dead_band": 0, "has_throttle_lag": 1},
    **{"command_delay": 0.005, "surface_delay": 0.010, "has_fuel_burn": 0},
}
"""Values of the settings: no failure, actuators as built."""


def memory_size() -> int:
    """How many numbers a flight remembers besides its state."""
    size = library().gtm_simulation_memory_size
    size.restype = ctypes.c_long
    return size()


class Simulation:
    """One flight.

    Attributes:
        x: the state (13) now; it may be set before the first step.
        settings: values of `names.SIMULATION_SETTINGS` that differ from `DEFAULTS`.
    """

    def __init__(self, x: ArrayLike, settings: Mapping[str, float] | None = None) -> None:
        """Begin at a state (12) with full tanks, or (13)."""
        state = np.asarray(x, float)
        self.x = rows(np.append(state, np.zeros(NX - len(state))), NX, "x")
        unknown = set(settings or {}) - set(DEFAULTS)
        if unknown:
            raise InputError(f"There is no setting '{min(unknown)}': choose of {', '.join(DEFAULTS)}.")
        self.settings = {**DEFAULTS, **(settings or {})}
        self._memory = np.zeros(memory_size())

    def _arguments(self, u: np.ndarray | Sequence[float]) -> list[np.ndarray]:
        inputs = np.zeros(NU)
        inputs[: len(u)] = u
        return [inputs, np.array([self.settings[name] for name in SIMULATION_SETTINGS], float)]

    def evaluate(self, u: np.ndarray | Sequence[float]) -> tuple[np.ndarray, np.ndarray]:
        """Derivatives (13) and outputs (32) now; inputs u as in `advance`.

        Raises:
            FloatingPointError: there are none.
        """
        u, settings = self._arguments(u)
        dx, y = np.empty(NX), np.empty(NY)
        arrays = (self.x, u, settings, self._memory, dx, y)
        self._check(library().gtm_simulation_evaluate(*map(address, arrays)))
        return dx, y

    def advance(self, u: np.ndarray | Sequence[float], duration_s: float, substep_s: float) -> np.ndarray:
        """State (13) after ``duration_s`` with constant inputs u (those left out are zero), in parts of ``substep_s``.

        Raises:
            FloatingPointError: why it cannot be reached; nothing has changed then.
        """
        arrays = (self.x, *self._arguments(u), self._memory)
        times = ctypes.c_double(duration_s), ctypes.c_double(substep_s)
        self._check(library().gtm_simulation_advance(*map(address, arrays), *times))
        return self.x.copy()

    @staticmethod
    def _check(fault: int) -> None:
        if fault:
            raise FloatingPointError(f"{FAULTS[fault]} (fault {fault}, see gtm_simulation.h).")
