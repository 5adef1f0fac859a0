"""Numbers of the study: every method held against another that answers the same question."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from gtm_fmu.aircraft.client import FmuClient
from gtm_fmu.aircraft.limits import ControlLimits
from gtm_fmu.aircraft.ranges import WIDEST, Range
from gtm_fmu.core import solver
from gtm_fmu.datasets.off_lattice import ALTITUDE_FT, GAMMA_DEG, Surrogate
from gtm_fmu.envelopes.envelope import FlightCondition
from gtm_fmu.envelopes.family import EnvelopeFamily, envelope_family
from gtm_fmu.progress import Advance
from gtm_fmu.trims import linearization, steady
from gtm_fmu.trims.fmu_trimmer import FmuTrimmer
from gtm_fmu.units import M_PER_FT, M_S_PER_KT, RAD_PER_DEG
from surrogate import Selection
from surrogate.rudder.emulator import RudderEmulator

TRIMS = 200
OFF_LATTICE_CASES = 300
FIG_3 = (10000.0, -5.0)  # altitude and flight-path angle of paper Fig. 3
FIG_3_JAMS_DEG = (-30.0, -20.0, -10.0, 0.0, 10.0, 20.0, 30.0)
JAM_CONDITION = (10000.0, 0.0)


def compare_trims(fmu: Path, seed: int, advance: Advance) -> dict[str, Any]:
    """Random trims, half of them with a jammed rudder: over FMU evaluations, in the core, and their linear models."""
    rng = np.random.default_rng(seed)
    largest, feasible, agreed, stable, uncontrollable = 0.0, 0, 0, 0, 0
    with FmuClient(fmu) as client:
        trimmer = FmuTrimmer(client)
        for k in range(TRIMS):
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
            advance(k + 1, TRIMS)
    return {
        "trims": TRIMS,
        "same_verdict": agreed,
        "feasible": feasible,
        "largest_difference": largest,
        "stable": stable,
        "uncontrollable": uncontrollable,
    }


def jam_family(advance: Advance) -> EnvelopeFamily:
    """Envelopes over turn rate for jams of the rudder, as in paper Fig. 3."""
    return envelope_family(FlightCondition(*FIG_3), "rudder", FIG_3_JAMS_DEG, progress=advance)


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


@dataclass(frozen=True)
class EmulatorTruth:
    """Scores of the emulator against exact envelopes, and a cut through both."""

    scores: dict[str, Any]
    jams: SpeedsOverJams


def compare_emulator(emulator: RudderEmulator, data: xr.Dataset, seed: int, advance: Advance) -> EmulatorTruth:
    """The emulator against exact envelopes at random cases between the lattice's nodes, and over jams."""
    rng = np.random.default_rng(seed + 1)
    low, high = (
        np.array([getattr(data[name], end)().item() for name in ("altitude", "gamma")]) for end in ("min", "max")
    )
    speed_range = [float(data[name].max() - data[name].min()) for name in ("v_min", "v_max")]
    errors, agreed = [], 0
    for k in range(OFF_LATTICE_CASES):
        altitude_ft, gamma_deg = rng.uniform(low, high).tolist()
        lower, upper = np.sort(rng.uniform(*WIDEST["rudder_deg"], 2)).tolist()
        rudder_deg: Range = (lower, lower if k % 2 else upper)
        exact = FlightCondition(altitude_ft, gamma_deg).envelope(rudder_deg)
        emulated = emulator.predict_one(altitude_ft, gamma_deg, rudder_deg)
        agreed += exact.feasible == emulated["feasible"]
        if exact.feasible:
            errors.append(_speeds(emulated) - _speeds(exact.to_dict()))
        advance(k + 1, OFF_LATTICE_CASES + 1)
    error = np.array(errors)
    known = np.isfinite(error).all(axis=1)
    scores = {
        "cases": OFF_LATTICE_CASES,
        "same_verdict": agreed,
        "feasible": len(error),
        "compared": int(known.sum()),
        "mse": float(np.mean((error[known] / speed_range) ** 2)),
        "median_error_kt": np.median(np.abs(error[known]), axis=0).tolist(),
        "percentile_95_error_kt": np.percentile(np.abs(error[known]), 95, axis=0).tolist(),
        "largest_error_kt": np.abs(error[known]).max(axis=0).tolist(),
    }
    return EmulatorTruth(scores, _speeds_over_jams(emulator))


def _speeds(envelope: Mapping[str, Any]) -> np.ndarray:
    """(V_min, V_max) in kn of an exact or emulated envelope, NaN without one."""
    return np.array([envelope["v_min_kt"], envelope["v_max_kt"]], dtype=float)


def _speeds_over_jams(emulator: RudderEmulator) -> SpeedsOverJams:
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
