"""Trims on a dense grid, found without the search for envelope ends: Newton's method from several first guesses.

Every jammed control is held, then speed, bank and rudder, until three unknowns are; so no trim of a jam falls between
grid lines.
"""

from dataclasses import dataclass

import numpy as np

from gtm_fmu.aircraft.limits import ControlLimits
from gtm_fmu.airframe.names import AILERON, ELEVATOR, PHI, RUDDER, THROTTLE, V
from gtm_fmu.core import solver
from gtm_fmu.core.configuration import Configuration, trim_jacobian
from gtm_fmu.envelopes.envelope import Envelope, FlightCondition
from gtm_fmu.trims import manoeuvre
from gtm_fmu.units import FT_S_PER_KT, RAD_PER_DEG
from tests.reference import plain_model

SLOWEST_KT, FASTEST_KT = 50.0, 230.0
"""Below any stall and above any level speed of the airframe with gamma from -5 to 5 deg."""
TOLERANCE_KT, NEAR_KT = 0.01, 15.0
_MOST_STEPS, _CONVERGED, _INSIDE = 15, 1e-9, 1e-9
_GUESSES = 3


@dataclass(frozen=True)
class Case:
    """A flight condition and what a failure leaves of its controls."""

    altitude_ft: float
    gamma_deg: float
    limits: ControlLimits

    def envelope(self) -> Envelope:
        """What is to be checked."""
        return FlightCondition(self.altitude_ft, self.gamma_deg, self.limits).envelope()

    @property
    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """Of the trim unknowns (9 each)."""
        return manoeuvre.bounds(self.limits)


@dataclass(frozen=True)
class Steps:
    """Of a grid: speed in kn, bank and rudder in deg."""

    tas_kt: float
    phi_deg: float
    rudder_deg: float


def random_case(rng: np.random.Generator) -> Case:
    """A jam or a restriction of the rudder, in half of the cases with limits of other controls too."""
    lower, upper = np.sort(rng.uniform(-30, 30, 2))
    limits = {"rudder_deg": (lower, lower if rng.random() < 0.35 else upper)}
    if rng.random() < 0.5:
        widest = {"elevator_deg": (-8.0, 6.0), "aileron_deg": (-20.0, 20.0), "throttle_pct": (0.0, 100.0)}
        for name in rng.choice(list(widest), rng.integers(1, 4), replace=False):
            lower, upper = np.sort(rng.uniform(*widest[name], 2))
            limits[name] = (lower, lower if rng.random() < 0.25 else upper)
    near_ceiling = rng.random() < 0.3
    altitude_ft = rng.uniform(25000, 36000) if near_ceiling else rng.uniform(0, 36000)
    return Case(altitude_ft, rng.uniform(-5, 5), ControlLimits(**limits))


def newton(case: Case, y: np.ndarray, held: list[int]) -> np.ndarray:
    """Trims among y (n, 9) moved to the manifold with three unknowns held."""
    free, scale = [k for k in range(len(solver.scale())) if k not in held], solver.scale()
    altitude, gamma = case.altitude_ft, case.gamma_deg * RAD_PER_DEG
    y, airframe = y.copy(), Configuration()
    for _ in range(_MOST_STEPS):
        F, slopes = trim_jacobian(solver.with_both_throttles(y), altitude, gamma, airframe)
        J = slopes[..., :-1]
        J[..., THROTTLE] += slopes[..., -1]
        J = J[..., free] * scale[free]
        step = np.linalg.solve(J + 1e-12 * np.eye(6), F[..., None])[..., 0]
        step /= np.maximum(np.abs(step).max(axis=-1, keepdims=True), 1)
        y[:, free] -= step * scale[free]
        y[:, V] = np.clip(y[:, V], 20, 600)
    F, _ = trim_jacobian(solver.with_both_throttles(y), altitude, gamma, airframe)
    return y[np.abs(F).max(axis=-1) < _CONVERGED]


def trims(case: Case, tas_kt: np.ndarray, steps: Steps) -> np.ndarray:
    """All trims (m, 9) inside the limits that the grid meets at the given speeds."""
    lower, upper = case.bounds
    jams = [k for k in (ELEVATOR, AILERON, THROTTLE, RUDDER) if lower[k] == upper[k]]
    held = [*jams, V, PHI, RUDDER][:3] if jams != [RUDDER] else [RUDDER, V, PHI]
    banks = np.arange(lower[PHI], upper[PHI] + 1e-9, steps.phi_deg * RAD_PER_DEG)
    if PHI not in held:
        banks = np.linspace(lower[PHI], upper[PHI], 2 * _GUESSES)
    on_grid = int((upper[RUDDER] - lower[RUDDER]) / steps.rudder_deg) + 2
    rudders = np.unique(np.linspace(lower[RUDDER], upper[RUDDER], on_grid if RUDDER in held else _GUESSES))
    grid = np.array(np.meshgrid(tas_kt * FT_S_PER_KT, banks, rudders)).reshape(3, -1).T
    y = solver.cold_starts(case.altitude_ft, case.gamma_deg * RAD_PER_DEG, np.ascontiguousarray(grid))
    if jams not in ([], [RUDDER]) and len(y):
        y[:, jams] = lower[jams]
        y = newton(case, y, held)
    within = (lower - _INSIDE <= y) & (y <= upper + _INSIDE)
    within[:, V] = True
    return y[within.all(axis=-1)]


def errors(case: Case, found: Envelope, near: Steps, far: Steps) -> list[str]:
    """What a dense scan finds wrong in an envelope: trims beyond it, or ends that are none.

    The scan steps by ``near`` up to `NEAR_KT` beyond the ends, and by ``far`` over all speeds.
    """
    wide = trims(case, np.arange(SLOWEST_KT, FASTEST_KT, far.tas_kt), far)[:, V] / FT_S_PER_KT
    if not found.feasible:
        return [f"missed: {wide.size} trims inside the limits"] if wide.size else []
    wrong = []
    for trim, outward in ((found.at_v_min, -1), (found.at_v_max, 1)):
        assert trim is not None
        x, u = trim.state_and_controls
        lower, upper = case.bounds
        excess = np.maximum(lower - trim.unknowns, trim.unknowns - upper) / solver.scale()
        if excess.max() > 1e-6 or np.abs(plain_model.derivatives(x, u)[:6]).max() > 1e-8:
            wrong.append(f"{trim.tas_kt:.3f} kt is no trim inside the limits")
        beyond = np.append(np.arange(TOLERANCE_KT, NEAR_KT, near.tas_kt), [0.03, 0.1, 0.3])
        close = trims(case, trim.tas_kt + outward * beyond, near)[:, V] / FT_S_PER_KT
        gain = outward * (np.append(wide, close) - trim.tas_kt)
        if np.any(gain > 0.999 * TOLERANCE_KT):
            wrong.append(f"trims up to {gain.max():.3f} kt beyond {trim.tas_kt:.3f} kt")
    return wrong
