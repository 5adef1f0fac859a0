"""What the exact envelopes say to the paper's figures and tables of envelopes and of training data."""

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

from gtm_fmu.datasets import paper
from gtm_study.paper import published
from gtm_study.paper.counterpart import Finding, Results, Verdict

SAME_KT = 1.0
"""Speeds that a published figure does not tell apart."""
FALLS_KT = 5.0
"""A fall that is seen in a published figure."""
Ends = Sequence[Sequence[float | None]]


def agreed(holds: bool) -> Verdict:
    """Whether a published claim holds here."""
    return "same" if holds else "different"


def _known(members: Ends) -> list[list[float]]:
    """Value, V_min and V_max of the members that have an envelope."""
    return [[value for value in member if value is not None] for member in members if None not in member]


def volume(results: Results) -> Finding:
    """Figure 1: V_max over flight path with a jammed rudder."""
    known = _known(results["volume"]["jammed"])
    (first, _, highest), (last, _, lowest) = known[0], known[-1]
    falls = all(after[2] < before[2] for before, after in pairwise(known))
    return Finding(
        f"V_max is {highest:.1f} kn at {first:g} deg and {lowest:.1f} kn at {last:g} deg.",
        agreed(falls),
        "V_max falls from each flight path to the next steeper one." if falls else "V_max does not fall throughout.",
    )


def healthy_volume(results: Results) -> Finding:
    """Figure 2: the volume of the unimpaired aircraft, which holds that of the jammed one."""
    found = results["volume"]
    pairs = list(zip(_known(found["healthy"]), _known(found["jammed"]), strict=False))
    inside = all(a[1] <= b[1] + 0.01 and a[2] >= b[2] - 0.01 for a, b in pairs)
    first = pairs[0][0]
    return Finding(
        f"V_min {first[1]:.1f} kn and V_max {first[2]:.1f} kn at {first[0]:g} deg.",
        agreed(inside),
        "It holds the volume of Figure 1 at every flight path." if inside else "The jammed aircraft reaches beyond it.",
    )


def jams(results: Results) -> Finding:
    """Figure 3: jams at one flight condition."""
    found = results["jams"]
    members = {member[0]: member[1:] for member in found["members"]}
    gone = sorted(jam for jam, ends in members.items() if None in ends)
    shrinks = all(
        None in after or (None not in before and after[0] >= before[0] and after[1] <= before[1])
        for side in (1.0, -1.0)
        for before, after in pairwise([members[jam] for jam in sorted(members, key=abs) if side * jam >= 0.0])
    )
    parts = []
    alike = True
    if 0.0 in members and None not in members[0.0]:
        apart = [ours - whole for ours, whole in zip(members[0.0], found["healthy_kt"], strict=True)]
        alike = max(map(abs, apart)) < SAME_KT
        parts.append(f"A jam at 0 deg moves V_min by {apart[0]:+.2f} kn and V_max by {apart[1]:+.2f} kn.")
    if gone:
        parts.append(f"Jams at {', '.join(f'{jam:g}' for jam in gone)} deg leave no envelope.")
    why = "The envelope shrinks with the jam on both sides." if shrinks else "The envelope does not shrink throughout."
    if alike:
        why += " A jam at 0 deg is all but no failure; the small rest is the aircraft's own asymmetry."
    return Finding(" ".join(parts), agreed(shrinks and alike), why)


def trim_points(results: Results) -> Finding:
    """Figure 8: the examination of a trim point."""
    found = results["trims"]
    return Finding(
        f"{found['stable']} of {found['feasible']} feasible trims are stable, {found['uncontrollable']} "
        "uncontrollable.",
        "same" if found["same_verdict"] == found["trims"] else "different",
        f"The compiled core and trims over the FMU agree in {found['same_verdict']} of {found['trims']} verdicts; "
        f"their unknowns differ by {found['largest_difference']:.1e} of their scale at most. The paper tests the rank "
        "of Kalman's matrix, which rounding can decide; here the test is that of Popov, Belevitch and Hautus, scaled.",
    )


def limit_surface(results: Results) -> Finding:
    """Figure 33: V_max over both limits."""
    found = results["limits"]
    narrow, wide = found["narrow_kt"], found["wide_kt"]
    lost = wide - narrow if narrow is not None else wide
    left = "no envelope" if narrow is None else f"V_max {narrow:.1f} kn"
    holds = found["within_1_kt_of_the_highest"] > 0.5 and lost > FALLS_KT
    return Finding(
        f"{found['within_1_kt_of_the_highest']:.0%} of the ranges are within 1 kn of the highest V_max, "
        f"{found['highest_kt']:.1f} kn. Limits of -25 and -23 deg leave {left}, -25 and 30 deg {wide:.1f} kn.",
        agreed(holds),
        "Flat with steep edges, as published; here every point is exact, not a network's.",
    )


def path_surface(results: Results) -> Finding:
    """Figure 34: V_max over altitude and flight path."""
    found = results["paths"]
    falls = found["fall_over_gamma_kt"]
    steps, usual = found["largest_step_kt"]["along gamma"], found["median_step_kt"]["along gamma"]
    told = " and ".join(f"{fall:.1f} kn at {float(altitude):,.0f} ft" for altitude, fall in falls.items())
    low, *high = falls.values() or [0.0]
    holds = found["rises_with_gamma"] == 0 and all(fall >= low for fall in high)
    return Finding(
        f"Over the flight paths V_max falls by {told}; the largest step between neighbouring points is {steps:.1f} kn, "
        f"the median {usual:.1f} kn; {found['without_envelope']} of {found['points']} points have no envelope.",
        agreed(holds),
        "The fall is steeper at height, as published. But V_max jumps where two branches of steady flight meet at full "
        "throttle, and high climbs have no envelope: the published surface, a network's, is smooth there and goes on.",
    )


def inputs(results: Results) -> Finding:
    """Table 1: the inputs."""
    told = (f"{name}: {len(levels.split(', '))} levels" for name, levels in results["lattice"]["inputs"]["rows"])
    return Finding(f"{'; '.join(told)}.", "same", "The same four inputs.")


def properties(results: Results) -> Finding:
    """Table 2: the airframe."""
    rows = results["trims"]["properties"]["rows"]
    told = ", ".join(f"{name} {value}" for name, value in rows[:4])
    beside = ""
    if "nasa" in results:
        off = results["nasa"]["largest_difference"]
        beside = (
            f" Level trims and modes are those of NASA's plots within {off['elevator_deg']:.2f} deg of elevator, "
            f"{off['throttle_pct']:.2f} % of throttle, {off['eas_kt']:.2f} kn and {off['sp_hz']:.3f} Hz, which is how "
            "well the plots can be read."
        )
    return Finding(
        f"{told[0].upper()}{told[1:]}.",
        "same",
        "The airframe is NASA's GTM_DesignSim, which the paper uses. Its centre of gravity lies to the left of the "
        "plane of symmetry; the paper calls the aircraft symmetric." + beside,
    )


def failures(results: Results) -> Finding:
    """Table 3: rudder failures."""
    of = results["lattice"]["failures_of"]
    n = published.ENVELOPES_3D // len(paper.ALTITUDES_FT)
    return Finding(
        f"{of['jams']} jams and {of['restrictions']} restrictions, the whole range among them.",
        agreed(of["jams"] == len(paper.RUDDERS_DEG) and sum(of.values()) == n),
        f"The paper's {published.ENVELOPES_3D} envelopes at {len(paper.ALTITUDES_FT)} altitudes are {n} failures.",
    )


def envelopes_3d(results: Results) -> Finding:
    """Table 4: 3-D envelopes."""
    altitudes, of, total = results["lattice"]["envelopes"]["rows"][0]
    return Finding(
        f"{altitudes} altitudes x {of} failures: {total}.",
        agreed(total == published.ENVELOPES_3D),
        f"The paper has {published.ENVELOPES_3D}.",
    )


def increments(results: Results) -> Finding:
    """Table 5: increments."""
    step = results["lattice"]["steps"]["rows"][1][1]
    return Finding(
        f"{step} in flight path; none in speed and turn rate.",
        "better",
        "V_min and V_max are optima of the steady manoeuvres, so no grid of speeds and turn rates cuts them off.",
    )


def _count(results: Results, data_set: int) -> dict[str, Any]:
    return next(row for row in results["lattice"]["counts_of"] if row["data_set"] == data_set)


def samples(data_set: int) -> Any:
    """Tables 7-12: the samples of a data set."""

    def find(results: Results) -> Finding:
        row = _count(results, data_set)
        too_many = row["paper"] > row["feasible"]
        return Finding(
            f"{row['feasible']} of {row['cases']} cases have an envelope.",
            agreed(row["feasible"] == row["paper"]),
            f"The levels are the paper's. It counts {row['paper']} samples, so "
            + (
                f"at least {row['paper'] - row['feasible']} of them have no steady manoeuvre inside its own limits. "
                if too_many
                else f"it left {row['feasible'] - row['paper']} out that have one. "
            )
            + (results["lattice"]["contradiction"] if data_set == 6 else "Its counts contradict each other: Table 13."),
        )

    return find


def counts(results: Results) -> Finding:
    """Table 13: samples of the data sets."""
    rows = results["lattice"]["counts_of"]
    told = ", ".join(f"{row['data_set']}: {row['feasible']} ({row['paper']})" for row in rows)
    alike = all(row["feasible"] == row["paper"] for row in rows)
    return Finding(f"Samples here (the paper's): {told}.", agreed(alike), results["lattice"]["contradiction"])
