"""Stages of sensitivity: indices, elementary effects, convergence, advice, and the package's exact data anew."""

from collections.abc import Mapping
from itertools import product
from typing import Any

import numpy as np

from gtm_fmu.aircraft.limits import ControlLimits
from gtm_fmu.aircraft.ranges import WIDEST
from gtm_fmu.datasets.paper import ALTITUDE_FT, GAMMA_DEG
from gtm_fmu.envelopes.slopes import envelope_slopes
from gtm_fmu.envelopes.thrust_map import ThrustMap
from gtm_fmu.progress import Advance
from gtm_study.paper import every_failure, figures, published, rudder_grid, rudder_sensitivity
from gtm_study.paper.advice import advice
from gtm_study.paper.advice_figure import plot_advice
from gtm_study.paper.counterpart import table
from gtm_study.paper.rudder_sensitivity import AS_IN_THE_PAPER, EXACT, LIMITS, NAMES, SPEED_NAMES
from gtm_study.paper.sensitivity_report import KINDS
from gtm_study.paper.stage import Run, Written, draw
from gtm_study.research import surrogate_figures, surrogate_study
from gtm_study.tables import Cell
from sensitivity import Distribution, OrderedUniform, Uniform, convergence, effects_design, plot_bars, variance_design
from surrogate.rudder.emulator import INPUTS, RudderEmulator

Values = dict[str, Any]
ADVISED = {"level": (15000.0, 0.0), "climb": (15000.0, 3.0)}
"""Altitude in ft and flight path in deg of the advice, with a rudder that is left between -10 and 15 deg."""
ADVISED_RUDDER_DEG = (-10.0, 15.0)


def distribution() -> Distribution:
    """Of altitude, flight path and the rudder's limits over the paper's ranges."""
    units = [unit for _, unit in INPUTS]
    return Distribution(
        [
            Uniform(NAMES[0], *ALTITUDE_FT, units[0]),
            Uniform(NAMES[1], *GAMMA_DEG, units[1]),
            OrderedUniform((LIMITS[0], LIMITS[1]), *WIDEST["rudder_deg"], units[2]),
        ]
    )


def sensitivity(run: Run, advance: Advance, written: Written) -> Values:
    """Exact indices of three questions beside those of the surrogates."""
    emulator = RudderEmulator.load(run.folder)
    networks = {"package's network": RudderEmulator.load(), "paper's network": emulator}
    found, indices = rudder_sensitivity.results(
        ThrustMap.load(), networks, continued_by=emulator, finer_cells=run.sizes.finer_cells
    )
    chart = plot_bars(indices, published=published.VARIANCE_INDICES, published_label="paper", labels=figures.LABELS)
    everything = every_failure.indices(every_failure.EVERYTHING)
    draw(run, written, indices=chart, failures=plot_bars(everything, labels=figures.LABELS))
    answers = found["questions"][AS_IN_THE_PAPER]["answers"]
    return found | {"failures": every_failure.results(), "indices": _table_15(answers)}


def _table_15(answers: Mapping[str, Any]) -> dict[str, list[Any]]:
    """Indices by output, factor and kind: exact, by the paper's network trained here, and the paper's."""
    rows = []
    for output, factor, (kind, symbol) in product(reversed(SPEED_NAMES), (*NAMES, ",".join(LIMITS)), KINDS.items()):
        known = published.VARIANCE_INDICES[output].get(factor, {}).get(kind)
        ours = [answers[name][output]["indices"][factor][kind] for name in (EXACT, "paper's network")]
        rows.append((output, symbol, factor.replace(",", ", "), *ours, "-" if known is None else known))
    return table(("output", "index", "input", "exact", "a network as the paper's", "paper"), rows)


def effects(run: Run, advance: Advance, written: Written) -> Values:
    """Elementary effects on the paper's network, as Figs. 35 and 36: by the paper's scaling, and by the ranges."""
    model = RudderEmulator.load(run.folder).speeds
    design = effects_design(distribution(), run.sizes.trajectories, radial=True, seed=run.seed)
    outputs = model.predict(design.points)
    found: Values = {"evaluations": len(design.points)}
    rows: list[tuple[Cell, ...]] = []
    for j, output in enumerate(SPEED_NAMES):
        by_range = design.effects(outputs[:, [j]], [output], n_bootstrap=200)
        by_paper = design.effects(outputs[:, [j]], [output], scaling="paper", n_bootstrap=200)
        draw(run, written, **{f"effects_{output.removesuffix('_kt')}": by_range.plot(labels=figures.LABELS)})
        found[output] = {}
        for i, name in enumerate(NAMES):
            values = {
                "mu_star": float(by_range.mu_star.value[i, 0]),
                "sigma": float(by_range.sigma.value[i, 0]),
                "half_width": float(by_range.mu_star.upper[i, 0] - by_range.mu_star.lower[i, 0]) / 2.0,
                "paper_mean": float(by_paper.mu.value[i, 0]),
                "paper_deviation": float(by_paper.sigma.value[i, 0]),
            }
            found[output][name] = values
            rows.append((output, name, *values.values()))
        advance(j + 1, len(SPEED_NAMES))
    heads = ("output", "input", "mu*, kn", "sigma, kn", "+- of mu*", "paper's mean", "paper's deviation")
    return found | {"effects": table(heads, rows)}


def convergence_stage(run: Run, advance: Advance, written: Written) -> Values:
    """Indices of the paper's network by sampling, over the number of evaluations, as Figs. 39 and 40."""
    model = RudderEmulator.load(run.folder).speeds
    design = variance_design(distribution(), run.sizes.base_rows, seed=run.seed)
    advance(1, 4)
    evaluated = design.evaluate(model.predict, output_names=SPEED_NAMES)
    advance(2, 4)
    found: Values = {"evaluations": design.n_evaluations}
    for j, output in enumerate(SPEED_NAMES):
        one = type(evaluated)(design, (output,), evaluated.outputs[:, [j]])
        steps = convergence(one, least=max(64, run.sizes.base_rows // 1024))
        draw(run, written, **{f"convergence_{output.removesuffix('_kt')}": steps.plot(labels=figures.LABELS)})
        last = steps.steps[-1]
        found[output] = {
            "evaluations": [step.design.n_evaluations for step in steps.steps],
            "widest": [
                max(float((step.estimates[kind].upper - step.estimates[kind].lower).max()) for kind in KINDS)
                for step in steps.steps
            ],
            "indices": {
                ",".join(factor): {kind: float(last.estimates[kind].value[i, 0]) for kind in KINDS}
                for i, factor in enumerate(last.factors)
            },
        }
        advance(3 + j, 4)
    return found


def advice_stage(run: Run, advance: Advance, written: Written) -> Values:
    """What the next degree costs, in level flight and in a climb (section IV-C)."""
    found: Values = {}
    for k, (name, (altitude_ft, gamma_deg)) in enumerate(ADVISED.items()):
        advised = advice(envelope_slopes(altitude_ft, gamma_deg, ControlLimits(rudder_deg=ADVISED_RUDDER_DEG)))
        draw(run, written, **{f"advice_{name}": plot_advice(advised)})
        found[name] = advised.to_dict()
        advance(k + 1, len(ADVISED))
    return found


def exact_indices(run: Run, advance: Advance, written: Written) -> Values:
    """The exact jams that come with the package, computed anew, and the indices that follow."""
    cells = run.sizes.exact_cells
    written.append(run.folder / rudder_grid.FILE.with_suffix(".zarr").name)
    solved = rudder_grid.solve(run.folder, cells, progress=advance)
    anew = rudder_grid.RudderGrid.of_jams(cells, *(solved[name] for name in rudder_grid.RESULTS))
    found = rudder_sensitivity.given_an_envelope(anew)
    values: Values = {"cells": cells._asdict(), "jams": len(cells.jams), "indices": found.to_dict()}
    if cells == rudder_grid.EXACT_CELLS:
        shipped = rudder_grid.exact()
        both = anew.has_envelope & shipped.has_envelope
        values["other_verdicts"] = int((anew.has_envelope != shipped.has_envelope).sum())
        values["largest_difference_kt"] = float(np.abs(anew.speeds_kt - shipped.speeds_kt)[both].max())
        values["indices_apart"] = rudder_sensitivity.apart(found, rudder_sensitivity.given_an_envelope(shipped))
    return values


def all_failures(run: Run, advance: Advance, written: Written) -> Values:
    """The exact envelopes of everything that may fail, computed anew."""
    values: Values = {}
    for k, name in enumerate(every_failure.SCENARIOS):
        written.append(run.folder / f"{name}.zarr")
        found = every_failure.solve(
            run.folder,
            name,
            run.sizes.failure_rows,
            progress=lambda done, total, k=k: advance(done + k * total, 2 * total),
        )
        values[name] = {"cases": len(found), "with_an_envelope": float(np.isfinite(found[:, :2]).all(axis=1).mean())}
        if run.sizes.failure_rows == every_failure.ROWS:
            with np.load(every_failure.FILE) as content:
                shipped = content[name].astype(float)
            both = np.isfinite(found).all(axis=1) & np.isfinite(shipped).all(axis=1)
            values[name]["largest_difference_kt"] = float(np.abs(found - shipped)[both, :2].max())
    return values


def surrogates(run: Run, advance: Advance, written: Written) -> Values:
    """Library models, jam maps, thrust and trim maps, off the lattice."""
    found = surrogate_study.run(run.folder / "surrogates", advance=advance)
    draw(run, written, surrogate_errors=surrogate_figures.plot_errors(found))
    rows = [
        (name, *(model["all"][key] for key in ("mse", "percentile_95_kt", "largest_kt")))
        for name, model in found["models"].items()
    ]
    return {"models": found["models"], "off_lattice": table(("model", "MSE", "95 %, kn", "largest, kn"), rows)}
