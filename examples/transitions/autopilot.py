"""An autopilot that holds steady manoeuvres: the controls of the trim, corrected by LQR about it.

At a trim x_s, u_s with the exact linear model x' = A (x - x_s) + B (u - u_s) of the controls that still move

    u = u_s - K (x - x_s) + L x_s'

K is python-control's ``lqr``. L leads where the trim itself moves: a change of bank and pitch needs the body rates
T x_s', and x_s' - A T x_s' is left to the controls, in the sense of least squares. States are those relative to the
air, so a steady wind is no deviation. All in the airframe's units: ft/s, rad/s, rad, deg, %.
"""

from typing import NamedTuple

import control
import numpy as np

from gtm_fmu.airframe.names import CONTROLS, LINEAR_STATES
from gtm_fmu.envelopes.manoeuvres import Manoeuvres
from gtm_fmu.trims.linearization import INPUT_SCALE, STATE_SCALE, slopes
from gtm_fmu.units import FT_S_PER_KT, RAD_PER_DEG

_P, _Q, _R, _PHI, _THETA = (LINEAR_STATES.index(name) for name in ("p", "q", "r", "phi", "theta"))
_INPUT_COST = 9.0
"""Of a control's typical deflection beside a typical deviation: faster ones would need the servos in the model."""


class Hold(NamedTuple):
    """What holds a steady manoeuvre: states (8) and controls (4) of its trim, gain K (4, 8) and lead L (4, 8)."""

    states: np.ndarray
    controls: np.ndarray
    gain: np.ndarray
    lead: np.ndarray

    def commands(self, states: np.ndarray, trim_rates: np.ndarray) -> np.ndarray:
        """Commands (4) at states (8), while those of the trim move at ``trim_rates`` (8) per second."""
        return self.controls - self.gain @ (states - self.states) + self.lead @ trim_rates


def hold(found: Manoeuvres, k: int, like: Hold | None = None) -> Hold:
    """What holds manoeuvre ``k``, which must be feasible; with the gains of another hold if it is given.

    Raises:
        ValueError, LinAlgError: no gain makes it stable.
    """
    trim, failure = found.trim(k), found.failures[k]
    assert trim is not None
    x, u = trim.state_and_controls
    states, controls = np.concatenate([x[:6], x[9:11]]), u[: len(CONTROLS)]
    if like is not None:
        return Hold(states, controls, like.gain, like.lead)
    moving = [place for place, is_jammed in enumerate(failure.jammed) if not is_jammed]
    gain, lead = np.zeros((2, len(CONTROLS), len(LINEAR_STATES)))
    if moving:
        A, B = slopes(x, u, failure.airframe.configuration, failure.controls)
        B = B[:, moving]
        gain[moving] = control.lqr(A, B, np.diag(STATE_SCALE**-2), _INPUT_COST * np.diag(INPUT_SCALE[moving] ** -2))[0]
        T = _body_rates(states)
        work = np.linalg.pinv(B / STATE_SCALE[:, None]) / STATE_SCALE
        lead[moving] = work @ (np.eye(len(A)) - A @ T)
        lead += gain @ T
    return Hold(states, controls, gain, lead)


def _body_rates(states: np.ndarray) -> np.ndarray:
    """T (8, 8): body rates that changes of bank and pitch add."""
    phi, T = states[_PHI], np.zeros((len(states), len(states)))
    T[_P, _PHI], T[_Q, _THETA], T[_R, _THETA] = 1.0, np.cos(phi), -np.sin(phi)
    return T


def states_in_air(tas_kt: float, alpha_deg: float, beta_deg: float, rates_and_angles: np.ndarray) -> np.ndarray:
    """`names.LINEAR_STATES` (8) of airspeed and flow angles, and p q r phi theta."""
    v, alpha, beta = tas_kt * FT_S_PER_KT, alpha_deg * RAD_PER_DEG, beta_deg * RAD_PER_DEG
    along = v * np.cos(beta)
    flow = (along * np.cos(alpha), v * np.sin(beta), along * np.sin(alpha))
    return np.concatenate([flow, rates_and_angles])
