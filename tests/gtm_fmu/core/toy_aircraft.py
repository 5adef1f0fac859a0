"""The aircraft of toy_aircraft.c in closed form."""

import ctypes

import numpy as np

from gtm_fmu.airframe.names import TRIM_UNKNOWNS
from gtm_fmu.core.library import address

NT, MOST, MOST_NULL, NF = len(TRIM_UNKNOWNS), 10, 4, 6
SCALE = np.array([30, 0.05, 0.05, 0.1, 0.17, 4, 4, 6, 20])
LOWER = np.array([20, -0.2, -0.3, -1, -1, -20, -20, -30, 0.0])
UPPER = np.array([400, 0.1, 0.3, 1, 1, 20, 20, 30, 100.0])
KINK = 10.0


def real(value: float) -> ctypes.c_double:
    return ctypes.c_double(value)


def manoeuvre(speed, rate, rudder, drag=0.0) -> np.ndarray:
    """The toy's steady manoeuvre in closed form."""
    alpha = 900 / speed**2
    beta = 0.002 * rudder * (1 + speed / 300)
    aileron = -0.5 * rudder - 0.5 * max(rudder - KINK, 0)
    throttle = 10 + (speed - 100) ** 2 / 50 + drag
    bank = np.arctan(speed * rate / 32)
    return np.array([speed, alpha, beta, rate, bank, 3 - 20 * alpha, aileron, rudder, throttle])


def manoeuvres(count: int, seed: int = 0) -> list[np.ndarray]:
    rng = np.random.default_rng(seed)
    return [manoeuvre(*given) for given in rng.uniform((95, -0.2, -25), (160, 0.2, 25), (count, 3))]


def accelerations(toy, y) -> tuple[np.ndarray, np.ndarray]:
    y, F, J = np.array(y, dtype=float), np.empty(NF), np.empty((NF, NT))
    toy.toy_jacobian(address(y), address(F), address(J))
    return F, J
