"""The findings of the study in numbers: a sentence for each stage that is finished, computed from its results."""

from collections.abc import Callable, Mapping
from typing import Any

from gtm_study.paper import published
from gtm_study.paper.rudder_sensitivity import AS_IN_THE_PAPER, EXACT
from gtm_study.tables import short

Values = Mapping[str, Any]


def findings(results: Mapping[str, Values]) -> list[str]:
    """Sentences for the abstract."""
    return [tell(results[name]) for name, tell in _SENTENCES.items() if name in results]


def _trims(trims: Values) -> str:
    return (
        f"Of {trims['trims']} random steady manoeuvres with a failed rudder, {trims['same_verdict']} get the same "
        "verdict from the search over the FMU as from the compiled core; where both find a trim, no unknown differs by "
        f"more than {short(trims['largest_difference'], 2)} of its scale. {trims['stable']} of the {trims['feasible']} "
        "trims are stable."
    )


def _lattice(lattice: Values) -> str:
    return (
        f"Of the {lattice['cases']} cases of the lattice, {lattice['feasible']} have a flight envelope (the paper "
        f"counts {published.FEASIBLE_CASES})."
    )


def _networks(networks: Values) -> str:
    best, theirs = min(networks["mse_independent"]), published.MSE_ANN[6]
    off = networks["off_lattice"]["all"]
    return (
        f"The best of {len(networks['mse_independent'])} networks reaches a mean squared error of {short(best)} on the "
        f"independent test data; the paper reports {short(theirs)}. Between the nodes of the lattice it is worse: on "
        f"{off['cases']} random cases 95 % of its errors are below {off['percentile_95_kt']:.2f} kn, and the largest "
        f"is {off['largest_kt']:.1f} kn."
    )


def _surrogate(surrogate: Values) -> str:
    off = surrogate["off_lattice"]["all"]
    return (
        f"The thrust map, which GtmSurrogate.fmu carries, keeps 95 % of its errors below {off['percentile_95_kt']:.2f} "
        f"kn on the same kind of cases; the largest is {off['largest_kt']:.2f} kn, and {off['same_verdict']:.2%} of "
        "its verdicts are right."
    )


def _sensitivity(sensitivity: Values) -> str:
    exact = sensitivity["questions"][AS_IN_THE_PAPER]["answers"][EXACT]["v_max_kt"]["indices"]
    theirs = published.VARIANCE_INDICES["v_max_kt"]
    names = {"altitude_ft": "altitude", "gamma_deg": "flight-path angle"}
    indices = " and ".join(
        f"{exact[key]['first']:.2f} for {name} ({theirs[key]['first']:.2f} there)" for key, name in names.items()
    )
    return (
        f"{sensitivity['without_envelope']:.1%} of all failures of the rudder leave no envelope. Exact first-order "
        f"indices of V_max are {indices}; the published ones break a bound that holds for any model."
    )


def _local_models(local: Values) -> str:
    return (
        f"The best local model network reaches {short(min(local['part']['mse_independent']))} on the independent test "
        f"data (the paper: {short(published.MSE_LMN[6])})."
    )


def _feasibility(jams: Values) -> str:
    return f"{jams['feasible']} of {jams['cases']} jams of the rudder over altitude and flight path leave an envelope."


def _asymmetry(apart: Values) -> str:
    return (
        f"Left and right are not the same: mirrored failures differ by up to {apart['v_min_kt']['largest']:.1f} kn in "
        f"V_min and {apart['v_max_kt']['largest']:.1f} kn in V_max; half of the {apart['cases']} pairs by less than "
        f"{apart['v_max_kt']['median']:.2f} kn in V_max."
    )


def _certainty(scan: Values) -> str:
    return (
        f"A scan of {scan['manoeuvres']} manoeuvres about the ends of {scan['with_an_envelope']} envelopes and over "
        f"{scan['cases'] - scan['with_an_envelope']} failures without one finds {len(scan['missed'])} failures whose "
        "envelope the search has cut short or missed."
    )


_SENTENCES: dict[str, Callable[[Values], str]] = {
    "trims": _trims,
    "lattice": _lattice,
    "surrogate-fmu": _surrogate,
    "networks": _networks,
    "local-models": _local_models,
    "sensitivity": _sensitivity,
    "feasibility": _feasibility,
    "asymmetry": _asymmetry,
    "certainty": _certainty,
}
