"""Stages that ask the exact solver: trims, the lattice, the envelopes of Figs. 1-3, 33 and 34, certainty."""

from importlib.util import find_spec
from itertools import pairwise
from typing import Any

import numpy as np

from gtm_fmu.airframe import mass
from gtm_fmu.datasets import lattice as lattices
from gtm_fmu.datasets import off_lattice
from gtm_fmu.envelopes import maps
from gtm_fmu.envelopes.envelope import FlightCondition
from gtm_fmu.envelopes.family import EnvelopeFamily, envelope_family
from gtm_fmu.envelopes.thrust_map import ThrustMap
from gtm_fmu.progress import Advance
from gtm_study.explorer.page import explorer_page
from gtm_study.figures import maps as map_figures
from gtm_study.figures.families import family_page, plot_family
from gtm_study.files import write_text
from gtm_study.paper import asymmetry, certainty, comparisons, lattice, nasa_comparison, paths
from gtm_study.paper.advice import shares_by_kind
from gtm_study.paper.counterpart import table
from gtm_study.paper.stage import Run, Written, build, draw


def trims(run: Run, advance: Advance, written: Written) -> dict[str, Any]:
    """Trims over the FMU and in the core, and what the aircraft weighs and measures."""
    fmu = build(run, written, "dynamics")
    found = comparisons.compare_trims(fmu, run.seed, run.sizes.trims, advance)
    moments = zip(("Ixx", "Iyy", "Izz", "Ixz"), mass.INERTIA_FULL_FUEL[:4].tolist(), strict=True)
    rows = [
        ("weight, full fuel", f"{mass.WEIGHT_FULL_FUEL:g} lb"),
        ("wing area", f"{mass.WING_AREA:g} ft^2"),
        ("span", f"{mass.SPAN:g} ft"),
        ("mean chord", f"{mass.MEAN_CHORD:g} ft"),
        ("centre of gravity, y", f"{mass.CG_FULL_FUEL[1]:.4f} ft"),
        *((name, f"{moment:g} slug ft^2") for name, moment in moments),
    ]
    return found | {"properties": table(("property", "value"), rows)}


def lattice_stage(run: Run, advance: Advance, written: Written) -> dict[str, Any]:
    """The solved lattice, and its cases beside the paper's counts."""
    data, sizes = run.lattice(advance), run.sizes
    written.append(run.folder / "envelopes.zarr")
    failures = lattices.rudder_failures(sizes.rudders_deg)
    counts = lattice.counts(written[-1])
    jams, restrictions = ([f for f in failures if (f[0] == f[1]) is jammed] for jammed in (True, False))
    levels = {
        "h, ft": sizes.altitudes_ft,
        "gamma, deg": sizes.gammas_deg,
        "delta_r, both limits, deg": sizes.rudders_deg,
    }
    return {
        "cases": int(data.feasible.size),
        "feasible": int(data.feasible.sum()),
        "failures_of": {"jams": len(jams), "restrictions": len(restrictions)},
        "counts_of": counts,
        "contradiction": lattice.contradiction(),
        "inputs": table(("input", "levels"), [(name, _listed(values)) for name, values in levels.items()]),
        "failures": table(
            ("failure", "rudder, deg"),
            [
                ("jam", _listed([low for low, _ in jams])),
                ("restriction", ", ".join(f"[{low:g}, {high:g}]" for low, high in restrictions)),
            ],
        ),
        "envelopes": table(
            ("altitudes", "failures", "3-D envelopes"),
            [(len(sizes.altitudes_ft), len(failures), len(sizes.altitudes_ft) * len(failures))],
        ),
        "steps": table(
            ("axis", "step here"),
            [
                ("V", "none: both ends are optima of the steady manoeuvres"),
                ("gamma", f"{_steps(sizes.gammas_deg)} deg"),
                ("turn rate", "none: free at both ends"),
            ],
        ),
        "counts": table(
            ("data set", "cases", "with an envelope", "the paper's samples"),
            [tuple(row[key] for key in ("data_set", "cases", "feasible", "paper")) for row in counts],
        ),
    } | {f"data_set_{number}": _levels_of(number) for number in lattice.paper.DATA_SETS}


def _listed(values: Any) -> str:
    return ", ".join(f"{value:g}" for value in values)


def _steps(values: Any) -> str:
    return _listed(sorted({high - low for low, high in pairwise(values)}))


def _levels_of(number: int) -> dict[str, list[Any]]:
    """Of a data set of the paper (Tables 7-12)."""
    fewer = lattice.paper.DATA_SETS[number]
    rows = [
        ("h, ft", _listed(lattice.paper.ALTITUDES_FT)),
        ("gamma, deg", _listed(fewer.get("gamma_deg", lattice.paper.GAMMAS_DEG))),
        ("delta_r, both limits, deg", _listed(fewer.get("rudder_deg", lattice.paper.RUDDERS_DEG))),
    ]
    return table(("input", "levels"), rows)


def jams(run: Run, advance: Advance, written: Written) -> dict[str, Any]:
    """Envelopes of jammed rudders, as Fig. 3."""
    family = comparisons.jam_family(run.sizes.jams_deg, advance)
    draw(run, written, envelope_jams=plot_family(family))
    healthy = FlightCondition(*comparisons.FIG_3).envelope()
    return {"healthy_kt": [healthy.v_min_kt, healthy.v_max_kt], "members": _ends(family)}


def _ends(family: EnvelopeFamily) -> list[list[float | None]]:
    """Value, V_min and V_max of each member."""
    return [[member.value, member.envelope.v_min_kt, member.envelope.v_max_kt] for member in family.members]


def volume(run: Run, advance: Advance, written: Written) -> dict[str, Any]:
    """Envelopes over flight path, as Figs. 1 and 2."""
    gammas = run.sizes.volume_gammas_deg

    def half(part: int) -> Advance:
        return lambda done, total: advance(done + part * total, 2 * total)

    jammed = maps.volume(gammas, half(0))
    healthy = envelope_family(FlightCondition(maps.FIG_1[0], 0.0), "gamma", gammas, progress=half(1))
    draw(run, written, volume=plot_family(jammed), volume_unimpaired=plot_family(healthy))
    written.append(run.folder / "volume.html")
    write_text(family_page(jammed), written[-1])
    return {"jammed": _ends(jammed), "healthy": _ends(healthy)}


def limits(run: Run, advance: Advance, written: Written) -> dict[str, Any]:
    """V_max over both limits of the rudder, as Fig. 33."""
    condition = FlightCondition(*comparisons.JAM_CONDITION)
    surface = maps.limit_surface(condition, step=run.sizes.limit_step_deg, advance=advance)
    draw(run, written, limits=map_figures.plot_limit_surface(surface))
    known = surface.v_max_kt[np.isfinite(surface.v_max_kt)]
    narrow, wide = (condition.envelope(allowed).v_max_kt for allowed in ((-25.0, -23.0), (-25.0, 30.0)))
    return {
        "highest_kt": float(known.max()),
        "lowest_kt": float(known.min()),
        "within_1_kt_of_the_highest": float((known > known.max() - 1.0).mean()),
        "narrow_kt": narrow,
        "wide_kt": wide,
    }


def paths_stage(run: Run, advance: Advance, written: Written) -> dict[str, Any]:
    """V_max over altitude and flight path, as Fig. 34."""
    surface = paths.path_surface(run.sizes.path_levels, advance)
    draw(run, written, paths=paths.plot_path_surface(surface))
    return paths.summary(surface)


def feasibility(run: Run, advance: Advance, written: Written) -> dict[str, Any]:
    """Where a jam leaves an envelope."""
    sizes = run.sizes
    found = maps.feasibility_map(
        step=sizes.map_jam_step_deg,
        altitudes_ft=sizes.map_altitudes_ft,
        gammas_deg=sizes.map_gammas_deg,
        advance=advance,
    )
    draw(run, written, feasibility=map_figures.plot_feasibility(found))
    return {"cases": int(found.feasible.size), "feasible": int(found.feasible.sum())}


def surrogate_fmu(run: Run, advance: Advance, written: Written) -> dict[str, Any]:
    """The FMU of the thrust map against what it carries, and the map's errors."""
    fmu, thrust_map = build(run, written, "surrogate"), ThrustMap.load()
    scores = off_lattice.measured(thrust_map, off_lattice.load())
    return comparisons.compare_surrogate_fmu(fmu, thrust_map, run.seed) | {"off_lattice": scores}


def explorer(run: Run, advance: Advance, written: Written) -> dict[str, Any]:
    """The page, where there is a compiler for browsers."""
    if find_spec("ziglang") is None:
        return {"page": None, "why": "left out: it needs Zig, pip install 'gtm-fmu[cross]'"}
    written.append(run.folder / "explorer.html")
    write_text(explorer_page(shares_by_kind()), written[-1])
    return {"page": written[-1].name}


def asymmetry_stage(run: Run, advance: Advance, written: Written) -> dict[str, Any]:
    """Envelopes of failures beside those of the mirrored ones."""
    apart = asymmetry.differences(run.sizes.mirrored_cases)
    return {
        "cases": len(apart),
        **{
            name: dict(
                zip(asymmetry.SHARES, np.percentile(column, list(asymmetry.SHARES.values())).tolist(), strict=True)
            )
            for name, column in zip(("v_min_kt", "v_max_kt"), apart.T, strict=True)
        },
    }


def nasa(run: Run, advance: Advance, written: Written) -> dict[str, Any]:
    """Level trims and modes beside those that NASA published with the model."""
    draw(run, written, nasa_trims_modes=nasa_comparison.plot_comparison())
    return nasa_comparison.differences()


def certainty_stage(run: Run, advance: Advance, written: Written) -> dict[str, Any]:
    """Whether manoeuvres are found beyond the ends of the envelopes."""
    return certainty.scan(run.sizes.scanned_cases, run.seed, advance)
