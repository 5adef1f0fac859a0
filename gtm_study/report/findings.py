"""The findings of the study in numbers: a sentence for each stage that is finished, computed from its results."""

from collections.abc import Callable, Mapping, Sequence
from statistics import median
from typing import Any, NamedTuple

from gtm_study.paper import published
from gtm_study.paper.rudder_sensitivity import AS_IN_THE_PAPER, EXACT
from gtm_study.paper.sensitivity_findings import SHORT
from gtm_study.tables import short

Values = Mapping[str, Any]


class Findings(NamedTuple):
    """Sentences of the abstract under a title."""

    title: str
    sentences: Sequence[str]


def findings(results: Mapping[str, Values]) -> list[Findings]:
    """The abstract: what the finished stages found, subject by subject."""
    told = (
        Findings(title, [tell(results[name]) for name, tell in sentences.items() if name in results])
        for title, sentences in _SENTENCES.items()
    )
    return [each for each in told if each.sentences]


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
    indices = " and ".join(
        f"{exact[key]['first']:.2f} for {SHORT[key]} ({theirs[key]['first']:.2f} there)"
        for key in ("altitude_ft", "gamma_deg")
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


def _nasa(beside: Values) -> str:
    off = beside["largest_difference"]
    return (
        f"{beside['trims']} level trims and {beside['modes']} modes lie on the plots that NASA published: "
        f"within {off['elevator_deg']:.2f} deg of elevator, {off['throttle_pct']:.2f} % of throttle and "
        f"{off['eas_kt']:.2f} kn."
    )


def _limits(surface: Values) -> str:
    return (
        f"At 10 000 ft in level flight {surface['within_1_kt_of_the_highest']:.0%} of all limits of the rudder cost "
        f"less than 1 kn of V_max ({surface['highest_kt']:.1f} kn); narrow limits far from neutral cost up to "
        f"{surface['highest_kt'] - surface['lowest_kt']:.0f} kn."
    )


def _levenberg_marquardt(plain: Values) -> str:
    errors = plain["part"]["mse_independent"]
    return f"Without regularisation the best of {len(errors)} networks reaches {short(min(errors))}."


def _data_sets(sets: Values) -> str:
    network = {k: median(errors) for k, errors in sets["least"]["network"].items()}
    best = min((k for k in network if k != "6"), key=network.__getitem__)
    return (
        f"With fewer levels the networks err more: {short(network[best])} at best (data set {best}, "
        f"{sets['samples'][best]} samples) in place of {short(network['6'])}."
    )


def _neurons(found: Values) -> str:
    medians = dict(zip(found["neurons"], map(median, found["mse_independent"]), strict=True))
    least = min(medians, key=medians.__getitem__)
    told = f"The median error on the lattice is least with {least} hidden neurons: {short(medians[least])}"
    if published.NEURONS in medians and least != published.NEURONS:
        told += f", with {published.NEURONS}, as in the paper, {short(medians[published.NEURONS])}"
    return f"{told}."


def _effects(found: Values) -> str:
    strongest = {
        output: max(found[output], key=lambda name: found[output][name]["mu_star"])
        for output in ("v_min_kt", "v_max_kt")
    }
    return (
        f"By {found['evaluations']} evaluations of the paper's network {SHORT[strongest['v_min_kt']]} has the largest "
        f"elementary effects on V_min, {SHORT[strongest['v_max_kt']]} on V_max."
    )


def _convergence(found: Values) -> str:
    widest = max(found[output]["widest"][-1] for output in ("v_min_kt", "v_max_kt"))
    return (
        f"After {found['evaluations']:,} evaluations of that network no 95 % interval of its indices is wider than "
        f"{widest:.4f}."
    )


def _advice(found: Values) -> str:
    level = found["level"]
    return " ".join(level["words"][:2])


def _splits(found: Values) -> str:
    best = found["best"]["bayesian_regularization"]
    return (
        f"Over {len(best)} divisions of the data the best network's error goes from {short(min(best))} to "
        f"{short(max(best))}: one division decides little."
    )


def _exact_indices(found: Values) -> str:
    told = f"The {found['jams']} exact jams behind the indices were computed anew"
    if "largest_difference_kt" in found:
        apart = short(found["largest_difference_kt"])
        told += f": {found['other_verdicts']} other verdicts, speeds at most {apart} kn apart"
    return f"{told}."


def _all_failures(found: Values) -> str:
    scenarios = (
        f"{each['cases']} of {name} ({each['with_an_envelope']:.0%} leave an envelope)" for name, each in found.items()
    )
    return f"Exact envelopes of everything that may fail were computed anew: {' and '.join(scenarios)}."


_SENTENCES: dict[str, dict[str, Callable[[Values], str]]] = {
    "The envelope": {
        "lattice": _lattice,
        "trims": _trims,
        "nasa": _nasa,
        "limits": _limits,
        "feasibility": _feasibility,
        "asymmetry": _asymmetry,
        "certainty": _certainty,
    },
    "What learns it": {
        "surrogate-fmu": _surrogate,
        "networks": _networks,
        "levenberg-marquardt": _levenberg_marquardt,
        "local-models": _local_models,
        "data-sets": _data_sets,
        "neurons": _neurons,
        "splits": _splits,
    },
    "What it depends on": {
        "sensitivity": _sensitivity,
        "effects": _effects,
        "convergence": _convergence,
        "exact-indices": _exact_indices,
        "all-failures": _all_failures,
        "advice": _advice,
    },
}
