"""Stages that train: the paper's networks and local model networks, on its data sets, judged on and off the lattice."""

from collections.abc import Mapping
from dataclasses import replace
from statistics import median
from typing import Any

import numpy as np
import xarray as xr

from gtm_fmu.aircraft.limits import ControlLimits
from gtm_fmu.datasets import lattice as lattices
from gtm_fmu.datasets import off_lattice, paper
from gtm_fmu.envelopes.boundary import envelope_boundary
from gtm_fmu.envelopes.envelope import FlightCondition
from gtm_fmu.progress import Advance
from gtm_study.paper import comparisons, figures, protocol_figures, published
from gtm_study.paper.counterpart import table
from gtm_study.paper.lattice import members
from gtm_study.paper.protocol_figures import NAMES
from gtm_study.paper.stage import Run, Written, draw
from surrogate import Network, Selection
from surrogate.rudder.emulator import RudderEmulator, train
from surrogate.training.train import Method

BAYESIAN: Method = "bayesian_regularization"
PLAIN: Method = "levenberg_marquardt"
Values = dict[str, Any]


def _nothing(done: int, total: int) -> None:
    """Of a part that is finished already."""


def _part(advance: Advance, part: int, parts: int) -> Advance:
    """Progress of one of several equal parts."""
    return lambda done, total: advance(done + part * total, parts * total)


def networks(run: Run, advance: Advance, written: Written) -> Values:
    """Algorithm 1 with Bayesian regularisation: the paper's network, and one of the least throttle beside it."""
    data, sizes = run.lattice(), run.sizes
    samples = lattices.samples(data)
    speeds, throttle = train(
        samples, run.seed, advance, rounds=sizes.rounds, hidden=sizes.hidden, schedule=run.schedule
    )
    part = run.protocol().networks(BAYESIAN, run.seed, _nothing, selection=speeds)
    emulator = RudderEmulator(*(_documented(selection, data) for selection in (speeds, throttle)))
    scores = off_lattice.measured(emulator, off_lattice.load())
    written += emulator.with_provenance(off_lattice=scores).save(run.folder)
    draw(
        run,
        written,
        emulator_jams=figures.plot_speeds(comparisons.speeds_over_jams(emulator)),
        networks_by_output=protocol_figures.plot_outputs(part, "neural networks"),
    )
    _enter(run, written, BAYESIAN, ("training", "regression", "errors", "networks", "evidence"))
    return comparisons.network_scores(speeds, throttle) | {"off_lattice": scores, "part": _shown(part)}


def _documented(selection: Selection, data: xr.Dataset) -> Network:
    """The selected network with where its data come from beside how it was trained."""
    network = selection.network
    return replace(network, provenance={**data.attrs, **network.provenance})


def _enter(run: Run, written: Written, method: str, names: tuple[str, ...]) -> None:
    """Figures that a part of the protocol has drawn."""
    stems = [f"{method}_{name}" for name in names]
    written.extend(run.folder / f"{stem}{ending}" for stem in stems for ending in (".svg", ".png"))


def _shown(part: Mapping[str, Any]) -> Values:
    """What the results hold of a part of the protocol."""
    names = (
        "samples", "mse_independent", "mse_by_output", "mse_training", "selected", "epochs", "chosen", "sizes",
        "corners", "outliers", "off_lattice",
    )  # fmt: skip
    return {name: part[name] for name in names if name in part}


def levenberg_marquardt(run: Run, advance: Advance, written: Written) -> Values:
    """Algorithm 1 without regularisation, beside the networks with it."""
    protocol = run.protocol()
    first = {
        BAYESIAN: protocol.networks(BAYESIAN, run.seed, _part(advance, 0, 2)),
        PLAIN: protocol.networks(PLAIN, run.seed, _part(advance, 1, 2)),
    }
    draw(run, written, trainings=protocol_figures.plot_rounds(first, "Fig. 10"))
    _enter(run, written, PLAIN, ("training", "regression", "errors", "networks"))
    errors = zip(*(part["mse_independent"] for part in first.values()), strict=True)
    marks, names = [part["selected"] for part in first.values()], [NAMES[name] for name in first]
    rows = [
        (j + 1, *pair, ", ".join(name for name, mark in zip(names, marks, strict=True) if mark == j))
        for j, pair in enumerate(errors)
    ]
    part = first[PLAIN]
    return {"part": _shown(part), "metrics": part["metrics"]} | {
        "rounds": table(("network", *names, "selected by"), rows)
    }


def local_models(run: Run, advance: Advance, written: Written) -> Values:
    """Algorithm 2: local model networks by LOLIMOT and HILOMOT, beside the networks."""
    protocol = run.protocol()
    local = protocol.local_models(run.seed, advance)
    first = {BAYESIAN: protocol.networks(BAYESIAN, run.seed, advance), "local_models": local}
    draw(
        run,
        written,
        networks_and_local_models=protocol_figures.plot_rounds(first, "Fig. 17"),
        local_models_by_output=protocol_figures.plot_outputs(local, "local model networks"),
        squared_errors=protocol_figures.plot_squared_errors(first),
    )
    _enter(run, written, "growth", ("best", "training", "validation"))
    squares = {name: [row[1] for row in part["squared_errors"]] for name, part in first.items()}
    worst = sorted(range(len(local["cases"])), key=lambda k: -squares["local_models"][k])[:4]
    rows = [(*local["cases"][k], *(squares[name][k] for name in ("local_models", BAYESIAN))) for k in worst]
    heads = ("h, ft", "gamma, deg", "lower, deg", "upper, deg", NAMES["local_models"], NAMES[BAYESIAN])
    return {"part": _shown(local), "squares": squares, "worst": table(heads, rows)}


def outliers(run: Run, advance: Advance, written: Written) -> Values:
    """The four cases of Figs. 24-27: the exact envelope beside the selected models' speeds."""
    protocol = run.protocol()
    models = {
        NAMES[BAYESIAN]: protocol.networks(BAYESIAN, run.seed, advance)["outliers"],
        NAMES["local_models"]: protocol.local_models(run.seed, advance)["outliers"],
    }
    return _outliers(run, written, models, "")


def _outliers(run: Run, written: Written, models: Mapping[str, list], suffix: str) -> Values:
    exact, rows = [], []
    for k, (altitude_ft, gamma_deg, low, high) in enumerate(published.OUTLIERS):
        condition = FlightCondition(altitude_ft, gamma_deg, ControlLimits(rudder_deg=(low, high)))
        found = condition.envelope()
        if found.v_min_kt is None or found.v_max_kt is None:
            raise RuntimeError(f"{condition} has no envelope any more")
        exact.append([found.v_min_kt, found.v_max_kt])
        estimates: dict[str, tuple[float, float]] = {
            name: (speeds[k][0], speeds[k][1]) for name, speeds in models.items()
        }
        ends = (found.v_min_kt, found.v_max_kt)
        picture = protocol_figures.plot_outlier(condition, ends, estimates, envelope_boundary(condition))
        draw(run, written, **{f"outlier_{k + 1}{suffix}": picture})
        cells = [f"{v_min:.1f} .. {v_max:.1f}" for v_min, v_max in (exact[-1], *estimates.values())]
        rows.append((f"{altitude_ft:g} ft, {gamma_deg:g} deg, rudder {low:g} .. {high:g} deg", *cells))
    return {
        "exact_kt": exact,
        "estimates_kt": {name: list(speeds) for name, speeds in models.items()},
        "outliers": table(("case", "exact, kn", *models), rows),
    }


def data_sets(run: Run, advance: Advance, written: Written) -> Values:
    """Networks and local model networks on the paper's six data sets, as Fig. 28 and Figs. 29-32."""
    found = _data_sets(run, (run.seed,), advance)
    draw(run, written, data_sets=protocol_figures.plot_data_sets(found))
    models = {f"data set {k}": found[k][0]["network"]["outliers"] for k in (3, 5, 6)}
    return _outliers(run, written, models, "_data_sets") | _of_data_sets(found)


def _data_sets(run: Run, seeds: tuple[int, ...], advance: Advance) -> dict[int, list[Values]]:
    protocol = run.protocol()
    found: dict[int, list[Values]] = {}
    tasks = len(paper.DATA_SETS) * len(seeds)
    for i, data_set in enumerate(paper.DATA_SETS):
        found[data_set] = []
        for s, seed in enumerate(seeds):
            part = i * len(seeds) + s
            network = protocol.networks(BAYESIAN, seed, _part(advance, 2 * part, 2 * tasks), data_set)
            local = protocol.local_models(seed, _part(advance, 2 * part + 1, 2 * tasks), data_set)
            found[data_set].append({"network": network, "local_models": local})
    return found


def _of_data_sets(found: Mapping[int, list[Values]]) -> Values:
    """Samples and least errors of each data set, the medians over splits in a table."""
    least = {
        key: {str(k): [min(part[key]["mse_independent"]) for part in parts] for k, parts in found.items()}
        for key in ("network", "local_models")
    }
    samples = {str(k): parts[0]["network"]["samples"] for k, parts in found.items()}
    own = {str(k): _at_own_levels(k, parts[0]["network"]) for k, parts in found.items()}
    rows = [
        (
            k,
            samples[str(k)],
            *(median(least[key][str(k)]) for key in least),
            published.TRAINING_SAMPLES[k],
            published.MSE_ANN[k],
            published.MSE_LMN[k],
        )
        for k in found
    ]
    heads = ("data set", "samples", "networks", "local models", "paper: samples", "networks", "local models")
    return {"samples": samples, "least": least, "at_own_levels": own, "data_sets": table(heads, rows)}


def _at_own_levels(data_set: int, part: Mapping[str, Any]) -> float | None:
    """Error of the selected network on the independent cases at the levels of its own data set; None without any."""
    inside = members(data_set, *np.array(part["cases"]).T[1:])
    return float(np.array(part["squared_errors"])[inside].mean()) if inside.any() else None


def neurons(run: Run, advance: Advance, written: Written) -> Values:
    """Errors by the number of hidden neurons, as Fig. 41."""
    found = run.protocol().neurons(run.seed, advance)
    draw(run, written, neurons=protocol_figures.plot_neurons(found))
    rows = [
        (n, min(mse), median(mse), max(mse)) for n, mse in zip(found["neurons"], found["mse_independent"], strict=True)
    ]
    return found | {"by_neurons": table(("neurons", "least", "median", "greatest"), rows)}


def splits(run: Run, advance: Advance, written: Written) -> Values:
    """The comparison over several divisions of the data, which the paper has one of."""
    protocol, sizes = run.protocol(), run.sizes
    seeds = tuple(range(run.seed, run.seed + sizes.splits))
    found: dict[str, list[Values]] = {BAYESIAN: [], PLAIN: [], "local_models": []}
    for k, seed in enumerate(seeds):
        for j, method in enumerate((BAYESIAN, PLAIN)):
            found[method].append(protocol.networks(method, seed, _part(advance, 4 * k + j, 5 * len(seeds))))
        found["local_models"].append(protocol.local_models(seed, _part(advance, 4 * k + 2, 5 * len(seeds))))
    sets = _data_sets(run, seeds[: sizes.data_set_splits], lambda done, total: advance(4 * total + done, 5 * total))
    draw(
        run,
        written,
        splits=protocol_figures.plot_splits(found),
        data_sets_over_splits=protocol_figures.plot_data_sets(sets),
    )
    heads = ("method", *(f"split {k + 1}" for k in range(len(seeds))), "median")
    best = {name: [min(part["mse_independent"]) for part in parts] for name, parts in found.items()}
    off = {name: [part["off_lattice"]["all"]["mse"] for part in parts] for name, parts in found.items()}
    wins = [
        sum(a < b for a, b in zip(network["mse_independent"], local["mse_independent"], strict=True))
        for network, local in zip(found[BAYESIAN], found["local_models"], strict=True)
    ]
    return {
        "best": best,
        "off_lattice": off,
        "rounds_with_a_better_network": wins,
        "rounds": len(found[BAYESIAN][0]["mse_independent"]),
        "corners": [part["corners"] for part in found["local_models"]],
        "on_the_lattice": _by_method(heads, best),
        "off_the_lattice": _by_method(heads, off),
    } | {f"{name}_over_splits": value for name, value in _of_data_sets(sets).items()}


def _by_method(heads: tuple[str, ...], errors: Mapping[str, list[float]]) -> dict[str, list[Any]]:
    return table(heads, [(NAMES[name], *row, median(row)) for name, row in errors.items()])
