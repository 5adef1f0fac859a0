"""Emulators of a failed rudder: V_min and V_max without solving, from two networks.

One network gives V_min and V_max where an envelope exists. The other gives t_min, the least throttle of a steady
manoeuvre; an envelope exists exactly when that is no more than full throttle, so t_min decides feasibility.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from gtm_fmu.aircraft.ranges import Range
from gtm_fmu.envelopes.feasibility import has_envelope
from gtm_fmu.envelopes.thrust_map import checked_case, checked_cases, first_of
from gtm_fmu.errors import InputError
from surrogate.models.network import Network
from surrogate.rudder.names import NETWORK, SPEEDS_FILE, THROTTLE_FILE

if TYPE_CHECKING:  # not needed to predict
    from surrogate.training.selection import Selection

INPUTS = (("altitude_ft", "ft"), ("gamma_deg", "deg"), ("rudder_lower_deg", "deg"), ("rudder_upper_deg", "deg"))
SPEEDS = (("v_min_kt", "kt"), ("v_max_kt", "kt"))
THROTTLE = (("t_min_pct", "%"),)
OFF_LATTICE = "off_lattice"
"""Key of a network's provenance: its errors on the test set of `off_lattice`."""


class EmulatedEnvelopes(NamedTuple):
    """Emulated envelopes (n); without one the speeds and their standard deviations are NaN.

    Attributes:
        in_domain: the case lies inside the ranges that the networks were trained on. Outside, nobody knows how far they
            are off: the standard deviations are NaN.
    """

    v_min_kt: np.ndarray
    v_max_kt: np.ndarray
    v_min_std_kt: np.ndarray
    v_max_std_kt: np.ndarray
    feasible: np.ndarray
    in_domain: np.ndarray
    t_min_pct: np.ndarray


@dataclass(frozen=True)
class RudderEmulator:
    """Two networks over (altitude ft, gamma deg, rudder limits deg): of V_min and V_max, and of t_min."""

    speeds: Network
    throttle: Network

    @classmethod
    def load(cls, folder: str | Path = NETWORK) -> "RudderEmulator":
        """The networks of a folder, by default those of `rudder_networks` that come with the package.

        Raises:
            InputError: a file is missing, damaged or of another model.
        """
        place = Path(folder)
        try:
            networks = [Network.load(place / name) for name in (SPEEDS_FILE, THROTTLE_FILE)]
        except ValueError as error:
            raise InputError(f"{str(error).rstrip('.')}; run `gtm-fmu study` to train it anew.") from None
        for network, outputs in zip(networks, (SPEEDS, THROTTLE), strict=True):
            if (network.inputs, network.outputs) != (INPUTS, outputs):
                raise InputError(f"{place} holds networks of another model; give the folder `gtm-fmu study` wrote.")
        return cls(*networks)

    def save(self, folder: str | Path) -> list[Path]:
        """Write both networks into a folder, and return their files.

        Raises:
            InputError: it cannot be written.
        """
        files = [Path(folder) / name for name in (SPEEDS_FILE, THROTTLE_FILE)]
        try:
            self.speeds.save(files[0])
            self.throttle.save(files[1])
        except ValueError as error:
            raise InputError(str(error)) from None
        return files

    def predict(self, cases: ArrayLike) -> EmulatedEnvelopes:
        """Envelopes of cases (n, 4): altitude in ft, gamma in deg, lower and upper limit of the rudder in deg.

        Raises:
            InputError: altitude, flight path or rudder limits outside what is allowed.
        """
        cases = checked_cases(cases, "rudder")
        t_min = self.throttle.predict(cases)[:, 0]
        v_min, v_max = self.speeds.predict(cases).T
        feasible, inside = has_envelope(t_min) & (v_min <= v_max), self.speeds.in_range(cases)
        std = self.speeds.predict_std(cases).T if self.speeds.has_std else np.full((2, len(cases)), np.nan)
        v_min, v_max = np.where(feasible, (v_min, v_max), np.nan)
        v_min_std, v_max_std = np.where(feasible & inside, std, np.nan)
        return EmulatedEnvelopes(v_min, v_max, v_min_std, v_max_std, feasible, inside, t_min)

    def predict_one(self, altitude_ft: float, gamma_deg: float, limits_deg: Range) -> dict[str, Any]:
        """The same for one case, by the names of `EmulatedEnvelopes` and ready for JSON: None where there is no number.

        Raises:
            InputError: as `predict`.
        """
        return first_of(self.predict([checked_case(altitude_ft, gamma_deg, limits_deg, "rudder")]))

    def with_provenance(self, **facts: Any) -> "RudderEmulator":
        """The same with further facts in the provenance of both networks."""
        return RudderEmulator(
            *(replace(network, provenance=network.provenance | facts) for network in (self.speeds, self.throttle))
        )


SolvedCases = tuple[np.ndarray, np.ndarray, np.ndarray]
"""Inputs (n, 4), V_min and V_max (n, 2) in kt and t_min (n) in %; NaN where there is none."""


def train(
    samples: SolvedCases, seed: int, progress: Callable[[int, int], None] | None = None, **options: Any
) -> tuple["Selection", "Selection"]:
    """Train both networks by the paper's protocol (Algorithm 1); options as in `select_network`.

    The speeds are learnt on the feasible cases, as in the paper; t_min on all cases that have one.
    """
    from surrogate.training.selection import select_network

    X, V, t_min = samples
    feasible, has_t_min = np.isfinite(V).all(axis=1), np.isfinite(t_min)
    protocol = {"inputs": INPUTS, "seed": seed, **options}

    def half(part: int) -> Callable[[int, int], None]:
        return lambda done, total: progress(done + part * total, 2 * total) if progress else None

    speeds = select_network(X[feasible], V[feasible], outputs=SPEEDS, progress=half(0), **protocol)
    throttle = select_network(X[has_t_min], t_min[has_t_min, None], outputs=THROTTLE, progress=half(1), **protocol)
    return speeds, throttle
