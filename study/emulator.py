"""The rudder emulator: V_min and V_max of a failed rudder without solving, from two small networks.

One network gives V_min and V_max where an envelope exists. The other gives t_min, the least throttle of a steady
manoeuvre; an envelope exists exactly when that is no more than full throttle, so t_min decides feasibility.
"""

from collections.abc import Callable
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from gtm_fmu import manoeuvre
from gtm_fmu.errors import InputError
from gtm_fmu.failures import WIDEST, ControlLimits, Range
from surrogate import Network

if TYPE_CHECKING:  # not needed to predict
    import xarray as xr

    from surrogate import Selection

SPEEDS_FILE, THROTTLE_FILE = "rudder_speeds.json", "rudder_throttle.json"
INPUTS = (("altitude_ft", "ft"), ("gamma_deg", "deg"), ("rudder_lower_deg", "deg"), ("rudder_upper_deg", "deg"))
SPEEDS = (("v_min_kt", "kt"), ("v_max_kt", "kt"))
THROTTLE = (("t_min_pct", "%"),)
FULL_THROTTLE_PCT = WIDEST["throttle_pct"][1]


@dataclass(frozen=True)
class Prediction:
    """Emulated envelope of one case; without one the speeds and their standard deviations are None.

    Attributes:
        in_domain: the case lies inside the ranges that the networks were trained on.
    """

    feasible: bool
    in_domain: bool
    v_min_kt: float | None
    v_max_kt: float | None
    v_min_std_kt: float | None
    v_max_std_kt: float | None
    t_min_pct: float


@dataclass(frozen=True)
class RudderEmulator:
    """Two networks over (altitude ft, gamma deg, rudder limits deg): of V_min and V_max, and of t_min."""

    speeds: Network
    throttle: Network

    @classmethod
    def load(cls, folder: str | Path | None = None) -> "RudderEmulator":
        """The networks of a study's folder, or by default those that come with the package.

        Raises:
            InputError: a file is missing, damaged or of another model.
        """
        place = Path(str(files("study") / "data")) if folder is None else Path(folder)
        try:
            networks = [Network.load(place / name) for name in (SPEEDS_FILE, THROTTLE_FILE)]
        except ValueError as error:
            raise InputError(f"{str(error).rstrip('.')}; run `gtm-fmu study` to train it anew.") from None
        for network, outputs in zip(networks, (SPEEDS, THROTTLE), strict=True):
            if (network.inputs, network.outputs) != (INPUTS, outputs):
                raise InputError(f"{place} holds networks of another model; give the folder `gtm-fmu study` wrote.")
        return cls(*networks)

    def save(self, folder: str | Path) -> None:
        """Write both networks into a folder.

        Raises:
            InputError: it cannot be written.
        """
        try:
            self.speeds.save(Path(folder) / SPEEDS_FILE)
            self.throttle.save(Path(folder) / THROTTLE_FILE)
        except ValueError as error:
            raise InputError(str(error)) from None

    def predict(self, altitude_ft: float, gamma_deg: float, rudder_deg: Range) -> Prediction:
        """Emulated envelope with the rudder held inside ``rudder_deg`` (lower, upper).

        Raises:
            InputError: altitude, flight path or rudder limits outside what is allowed.
        """
        manoeuvre.check_range("altitude in ft", altitude_ft, manoeuvre.ALTITUDE_FT)
        manoeuvre.check_range("gamma in deg", gamma_deg, manoeuvre.GAMMA_DEG)
        case = np.array([altitude_ft, gamma_deg, *ControlLimits(rudder_deg=rudder_deg).rudder_deg])
        t_min = float(self.throttle.predict(case)[0])
        v_min, v_max = self.speeds.predict(case).tolist()
        v_min_std, v_max_std = self.speeds.predict_std(case).tolist()
        feasible = t_min <= FULL_THROTTLE_PCT and v_min <= v_max
        return Prediction(
            feasible=feasible,
            in_domain=bool(self.speeds.in_range(case)),
            v_min_kt=v_min if feasible else None,
            v_max_kt=v_max if feasible else None,
            v_min_std_kt=v_min_std if feasible else None,
            v_max_std_kt=v_max_std if feasible else None,
            t_min_pct=t_min,
        )


def train(
    data: "xr.Dataset", seed: int, progress: Callable[[int, int], None] | None = None, **options: Any
) -> tuple["Selection", "Selection"]:
    """Train both networks on a data set by the paper's protocol (Algorithm 1); options as in `select_network`.

    The speeds are learnt on the feasible cases, as in the paper; t_min on all cases that have one.
    """
    from gtm_fmu.dataset import samples
    from surrogate import select_network

    X, V, t_min = samples(data)
    feasible, has_t_min = np.isfinite(V).all(axis=1), np.isfinite(t_min)
    protocol = {"inputs": INPUTS, "seed": seed, **options}

    def half(part: int) -> Callable[[int, int], None]:
        return lambda done, total: progress(done + part * total, 2 * total) if progress else None

    speeds = select_network(X[feasible], V[feasible], outputs=SPEEDS, progress=half(0), **protocol)
    throttle = select_network(X[has_t_min], t_min[has_t_min, None], outputs=THROTTLE, progress=half(1), **protocol)
    return speeds, throttle
