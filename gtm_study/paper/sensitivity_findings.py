"""What exact indices say to the paper's figures and table of sensitivities."""

from collections.abc import Callable, Mapping
from typing import Any

from gtm_study.paper import published
from gtm_study.paper.counterpart import Finding, Results
from gtm_study.paper.envelope_findings import agreed
from gtm_study.paper.rudder_sensitivity import AS_IN_THE_PAPER, EXACT, LIMITS, NAMES

NEAR = 0.05
"""Indices closer than this are alike."""
NONE = 0.1
"""An effect below this part of the largest is none."""
SHORT = {
    "altitude_ft": "altitude",
    "gamma_deg": "flight path",
    **dict(zip(LIMITS, ("lower limit", "upper limit"), strict=True)),
}
PAIR = ",".join(LIMITS)


def effects(output: str) -> Callable[[Results], Finding]:
    """Figures 35 and 36: the elementary effects on an output."""

    def find(results: Results) -> Finding:
        found = results["effects"]
        strength = {name: found[output][name]["mu_star"] for name in NAMES}
        spread = {name: found[output][name]["sigma"] for name in NAMES}
        by_paper = {name: abs(found[output][name]["paper_mean"]) for name in NAMES}
        first, by_theirs = max(strength, key=strength.__getitem__), max(by_paper, key=by_paper.__getitem__)
        most_spread = max(spread, key=spread.__getitem__)
        expected = "gamma_deg" if output == "v_max_kt" else "altitude_ft"
        holds = first == expected and most_spread in LIMITS
        why = (
            f"Strongest by the ranges is {SHORT[first]} (the paper: {SHORT[expected]}); the largest deviation has the "
        )
        why += (
            f"{SHORT[most_spread]} (the paper: the limits). By the paper's scaling I0 / f(I0), which vanishes where an "
        )
        why += (
            f"input is 0, and signed means, which cancel, the first would be {SHORT[by_theirs]}: we scale by the "
            "ranges."
        )
        relative = max(strength, key=lambda name: spread[name] / strength[name])
        why += f" Beside its own effect the deviation is largest for the {SHORT[relative]}."
        if output == "v_min_kt":
            gamma = strength["gamma_deg"] / strength[first]
            holds = holds and gamma < NONE
            why += f" Flight path has {gamma:.0%} of the largest effect; the paper calls it none."
        told = ", ".join(f"{SHORT[name]} {value:.1f} +- {spread[name]:.1f}" for name, value in strength.items())
        return Finding(
            f"Mean absolute effect and deviation in kn: {told} ({found['evaluations']:,} evaluations).",
            agreed(holds),
            why,
        )

    return find


def _exact(results: Results, output: str) -> Mapping[str, Any]:
    found: Mapping[str, Any] = results["sensitivity"]["questions"][AS_IN_THE_PAPER]["answers"][EXACT][output]["indices"]
    return found


def bound(indices: Mapping[str, Any], pair: float) -> float:
    """S of the lower limit, S^T of the upper one and the share of altitude and flight path: at most 1 for any model.

    Args:
        indices: by input, "first" and "total".
        pair: what altitude and flight path share beyond their own.
    """
    lower, upper = LIMITS
    own = indices["altitude_ft"]["first"] + indices["gamma_deg"]["first"] + pair
    return float(indices[lower]["first"] + indices[upper]["total"] + own)


def indices(output: str) -> Callable[[Results], Finding]:
    """Figures 37 and 38: the indices of an output."""

    def find(results: Results) -> Finding:
        ours, theirs = _exact(results, output), published.VARIANCE_INDICES[output]
        first = {name: ours[name]["first"] for name in NAMES}
        ranking = sorted(NAMES, key=lambda name: -first[name])
        their_ranking = sorted(NAMES, key=lambda name: -theirs[name]["first"])
        apart = max(abs(first[name] - theirs[name]["first"]) for name in NAMES)
        total = max(abs(ours[name]["total"] - theirs[name]["total"]) for name in NAMES)
        limits = [theirs[name]["total"] for name in LIMITS]
        told = ", ".join(f"{SHORT[name]} {first[name]:.3f} ({theirs[name]['first']:.3f})" for name in NAMES)
        excess = bound(theirs, published.SECOND_ORDER_INDICES[output]["altitude_ft,gamma_deg"])
        return Finding(
            f"S, exact (the paper's): {told}; both limits together {ours[PAIR]['first']:.3f}. S^T of one limit "
            f"{ours[LIMITS[0]]['total']:.3f} and {ours[LIMITS[1]]['total']:.3f}.",
            agreed(ranking[0] == their_ranking[0] and apart < NEAR and total < NEAR),
            f"S differs by up to {apart:.3f}, S^T by up to {total:.3f}. The published S^T of one limit "
            f"({limits[0]:.3f}, {limits[1]:.3f}) is what both limits have together ({ours[PAIR]['total']:.3f}): as if "
            f"both had been redrawn, not one given the other. The published indices add up to {excess:.3f} where no "
            "model exceeds 1." + _left_and_right(results, output),
        )

    return find


def _left_and_right(results: Results, output: str) -> str:
    """Why one limit matters more than the other."""
    ours = _exact(results, output)
    lower, upper = (ours[name]["first"] for name in LIMITS)
    if abs(lower - upper) < NEAR:
        return ""
    said = (
        f" The lower limit matters more than the upper one ({lower:.3f}, {upper:.3f}); the paper has them alike, and "
    )
    said += "calls the aircraft symmetric, but the centre of gravity of NASA's model lies to the left."
    if "asymmetry" in results:
        apart = results["asymmetry"][output]
        said += (
            f" Mirrored failures differ in it by {apart['median']:.2f} kn in the median, {apart['largest']:.1f} kn "
            "at most."
        )
    return said


def table_15(results: Results) -> Finding:
    """Table 15: all indices."""
    parts, largest = [], 0.0
    for output, known in published.VARIANCE_INDICES.items():
        ours = _exact(results, output)
        for kind, symbol in (("first", "S"), ("total", "S^T")):
            apart = max(abs(ours[name][kind] - known[name][kind]) for name in NAMES)
            largest = max(largest, apart)
            parts.append(f"{symbol} of {output.removesuffix('_kt').capitalize()} {apart:.3f}")
    sums = [
        bound(known, published.SECOND_ORDER_INDICES[output]["altitude_ft,gamma_deg"])
        for output, known in published.VARIANCE_INDICES.items()
    ]
    found = results["sensitivity"]["questions"][AS_IN_THE_PAPER]
    return Finding(
        f"Largest differences from the published ones: {', '.join(parts)}.",
        agreed(largest < NEAR),
        f"The published table contradicts itself: sums that no model lets exceed 1 are {sums[0]:.3f} and "
        f"{sums[1]:.3f}. Its equation 60 for the first index as printed multiplies each run by itself, and is 1 for "
        "every input. Its S^T less S is called interaction, which holds for independent inputs; the limits are not. A "
        f"network as the paper's is off by {found['own_error']['paper' + chr(39) + 's network']:.3f} by itself, and "
        f"{results['sensitivity']['without_envelope']:.1%} of the cases have no envelope, where a network only "
        "continues.",
    )


def convergence(output: str) -> Callable[[Results], Finding]:
    """Figures 39 and 40: how the indices settle."""

    def find(results: Results) -> Finding:
        found = results["convergence"]
        width = found[output]["widest"][-1]
        own = results["sensitivity"]["questions"][AS_IN_THE_PAPER]["own_error"]["paper's network"]
        return Finding(
            f"After {found['evaluations']:,} evaluations no 95 % interval is wider than {width:.4f}.",
            "better" if width < own else "same",
            f"They settle, as in the paper at {published.EVALUATIONS:,} evaluations in 100 minutes. But they settle "
            f"at the network's indices, which are off by up to {own:.3f}: more than any interval shows. The exact "
            "indices are sums over half a million envelopes and need no sampling.",
        )

    return find
