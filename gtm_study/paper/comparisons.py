"""Numbers of the study: every method held against another that answers the same question."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from gtm_fmu.aircraft.client import FmuClient
from gtm_fmu.aircraft.limits import ControlLimits
from gtm_fmu.aircraft.ranges import WIDEST
from gtm_fmu.core import solver
from gtm_fmu.datasets.off_lattice import Surrogate
from gtm_fmu.datasets.paper import ALTITUDE_FT, GAMMA_DEG
from gtm_fmu.envelopes.envelope import FlightCondition
from gtm_fmu.envelopes.family import EnvelopeFamily, envelope_family
from gtm_fmu.progress import Advance
from gtm_fmu.trims import linearization, steady
from gtm_fmu.trims.fmu_trimmer import FmuTrimmer
from gtm_fmu.units import M_PER_FT, M_S_PER_KT, RAD_PER_DEG
from surrogate import Selection
from surrogate.rudder.emulator import RudderEmulator

FIG_3 = (10000.0, -5.0)  # altitude and flight-path angle of paper Fig. 3
FIG_3_JAMS_DEG = (-30.0, -20.0, -10.0, 0.0, 10.0, 20.0, 30.0)
JAM_CONDITION = (10000.0, 0.0)


def compare_trims(fmu: Path, seed: int, trims: int, advance: Advance) -> dict[str, Any]:
    """Random trims, half of them with a jammed rudder: over FMU evaluations, in the core, and their linear models."""
    rng = np.random.default_rng(seed)
    largest, feasible, agreed, stable, uncontrollable = 0.0, 0, 0, 0, 0
    with FmuClient(fmu) as client:
        trimmer = FmuTrimmer(client)
        for k in range(trims):
            low, high = np.sort(rng.uniform(*WIDEST["rudder_deg"], 2))
            limits = ControlLimits(rudder_deg=(low, low if k % 2 else high))
            tas_kt, gamma_deg, turn_rate_deg_s = rng.uniform((80.0, -5.0, -5.0), (150.0, 5.0, 5.0))
            question = (rng.uniform(*ALTITUDE_FT), tas_kt, gamma_deg, turn_rate_deg_s, limits)
            by_core, by_fmu = steady.trim(*question), trimmer.trim(*question)
            agreed += by_core.feasible == by_fmu.feasible
            if by_core.feasible and by_fmu.feasible:
                difference = np.abs(by_core.unknowns - by_fmu.unknowns) / solver.scale()
                largest = max(largest, float(difference.max()))
                model = linearization.linearize(by_core)
                feasible, stable = feasible + 1, stable + model.stable
                uncontrollable += not model.controllable
            advance(k + 1, trims)
    return {
        "trims": trims,
        "same_verdict": agreed,
        "feasible": feasible,
        "largest_difference": largest,
        "stable": stable,
        "uncontrollable": uncontrollable,
    }


def jam_family(jams_deg: Sequence[float], advance: Advance) -> EnvelopeFamily:
    """Envelopes over turn rate for jams of the rudder, as in paper Fig. 3."""
    return envelope_family(FlightCondition(*FIG_3), "rudder", jams_deg, progress=advance)


def network_scores(speeds: Selection, throttle: Selection) -> dict[str, Any]:
    """Errors of all networks and of the selected ones, on targets scaled to 0..1."""
    return {
        "samples": len(speeds.X),
        "independent_samples": len(speeds.split.independent),
        "mse_independent": speeds.mse["independent"].tolist(),
        "selected": speeds.selected + 1,
        "speeds": speeds.network.metrics,
        "throttle": throttle.network.metrics,
    }


@dataclass(frozen=True)
class SpeedsOverJams:
    """Exact and emulated (V_min, V_max) in kn over jammed deflections in deg at one flight condition."""

    altitude_ft: float
    gamma_deg: float
    deflections_deg: Sequence[float]
    exact_kt: np.ndarray
    emulated_kt: np.ndarray


def _speeds(envelope: Mapping[str, Any]) -> np.ndarray:
    """(V_min, V_max) in kn of an exact or emulated envelope, NaN without one."""
    return np.array([envelope["v_min_kt"], envelope["v_max_kt"]], dtype=float)


def speeds_over_jams(emulator: RudderEmulator) -> SpeedsOverJams:
    """V_min and V_max of every jam at one flight condition, by search and by networks."""
    deflections = np.arange(WIDEST["rudder_deg"][0], WIDEST["rudder_deg"][1] + 1).tolist()
    condition = FlightCondition(*JAM_CONDITION)
    exact = [_speeds(condition.envelope((deflection, deflection)).to_dict()) for deflection in deflections]
    emulated = [_speeds(emulator.predict_one(*JAM_CONDITION, (deflection, deflection))) for deflection in deflections]
    return SpeedsOverJams(*JAM_CONDITION, deflections, np.array(exact), np.array(emulated))


def compare_surrogate_fmu(fmu: Path, surrogate: Surrogate, seed: int) -> dict[str, Any]:
    """The surrogate's FMU through FMPy against what it carries."""
    rng = np.random.default_rng(seed + 2)
    inputs = ("altitude", "gamma", "rudder.lower", "rudder.upper")
    largest, agreed, cases = 0.0, 0, 50
    with FmuClient(fmu) as client:
        for _ in range(cases):
            altitude_ft, gamma_deg = rng.uniform(*np.transpose([ALTITUDE_FT, GAMMA_DEG]))
            lower, upper = np.sort(rng.uniform(*WIDEST["rudder_deg"], 2)).tolist()
            si = np.array([altitude_ft * M_PER_FT, *(angle * RAD_PER_DEG for angle in (gamma_deg, lower, upper))])
            client.set(inputs, si)
            speeds_kt = np.asarray(client.get(("v_min", "v_max"))) / M_S_PER_KT
            found = surrogate.predict_one(altitude_ft, gamma_deg, (lower, upper))
            if fmu_finds := client.get_boolean("feasible"):
                expected = _speeds(found)
                largest = max(largest, float(np.abs(speeds_kt - expected).max()))
            agreed += fmu_finds == found["feasible"]
    return {"cases": cases, "same_verdict": agreed, "largest_difference_kt": largest}
