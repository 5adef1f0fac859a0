"""Surrogates beyond the paper's, measured off the lattice: library models, networks, jam maps, the thrust map.

Every model is a part of the results that is kept as soon as it is done, so that a stopped run goes on from there.
"""

import io
import json
import re
import time
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from rich.console import Console

from gtm_fmu.airframe.provenance import provenance
from gtm_fmu.datasets import lattice as dataset
from gtm_fmu.datasets import off_lattice, paper
from gtm_fmu.datasets.off_lattice import OffLattice, measured
from gtm_fmu.envelopes.thrust_map import THRUST_MAPS, ThrustMap
from gtm_fmu.envelopes.trim_map import TrimMap
from gtm_fmu.errors import InputError
from gtm_fmu.progress import Advance
from gtm_study.files import write_text
from gtm_study.kept import Kept, run_folder
from gtm_study.progress import stages
from gtm_study.research import trim_map_study
from gtm_study.research.adaptive_sampling import chosen_jams, refinements
from gtm_study.research.envelope_models import (
    CaseModel,
    Estimator,
    JamModel,
    boosted_trees,
    gaussian_process,
    polynomial,
    support_vectors,
    surface_map,
)
from gtm_study.research.failure_sets import (
    OTHER_FAILURES,
    further_cases,
    other_sets,
    rudder_sets,
    several_controls,
    solved,
)
from gtm_study.research.surrogate_report import SHIPPED, SHIPPED_FURTHER
from surrogate.rudder.surrogates import SURROGATES, load_surrogate

RESULTS_FILE = "surrogates.json"
SEARCHES_A_CASE = 3
"""V_min, V_max and t_min of a case are a search each, as is a thrust of a map."""
SURFACE_SOLUTIONS = (500, 1000, 2000)
JAM_COUNTS = (128, 256, 512, 1024)
JAM_LATTICES = ((4, 4, 8), (4, 7, 9), (6, 8, 11), (8, 10, 13))
"""Levels of altitude, flight path and jam."""


class Contender(NamedTuple):
    """A model and what it learns from."""

    data: str
    make: Callable[[], Any]


def _bayesian(hidden: int = 10, restarts: int = 6, epochs: int = 500) -> Any:
    from surrogate.estimators import BayesianRegularizationRegressor

    return BayesianRegularizationRegressor(hidden, restarts=restarts, epochs=epochs, random_state=0)


def _levenberg_marquardt() -> Any:
    from surrogate.estimators import LevenbergMarquardtRegressor

    return LevenbergMarquardtRegressor(10, restarts=6, epochs=500, validation_fraction=0.1, random_state=0)


CASE_ESTIMATORS: dict[str, Estimator] = {
    "BR network 4-10-2": _bayesian,
    "LM network 4-10-2": _levenberg_marquardt,
    "Gaussian process": gaussian_process,
    "support vectors": support_vectors,
    "boosted trees": boosted_trees,
    "polynomial": polynomial,
}


def contenders() -> dict[str, Contender]:
    """Models of a failed rudder by name."""
    paper_s = {
        f"{name}, lattice": Contender("lattice", partial(CaseModel, make)) for name, make in CASE_ESTIMATORS.items()
    }
    better_data = {
        f"{name}, Sobol cases": Contender("sobol_cases", partial(CaseModel, CASE_ESTIMATORS[name]))
        for name in ("BR network 4-10-2", "Gaussian process", "support vectors")
    }
    network = partial(_bayesian, 30, 2, 200)
    jam_maps = {
        f"{name}, jam map": Contender("sobol_jams", partial(JamModel, make))
        for name, make in (("Gaussian process", gaussian_process), ("BR network 3-30-2", network))
    }
    return paper_s | better_data | jam_maps


def run(
    folder: Path, only: str | None = None, console: Console | None = None, advance: Advance | None = None
) -> dict[str, Any]:
    """Fit and measure every model, or those whose name holds ``only``, and return the results.

    Progress is shown by a bar for each model on the console, or told to ``advance``: models done, all.

    Raises:
        InputError: the folder cannot be written, or no model has such a name.
    """
    folder = run_folder(folder)
    truth, kept = off_lattice.load(), Kept(folder)
    jobs = _jobs(folder, truth)
    wanted = {key: job for key, job in jobs.items() if only is None or only.lower() in " ".join(key).lower()}
    if not wanted:
        names = ", ".join(sorted({part for part, _ in jobs} | {name.split(",")[0] for _, name in jobs}))
        raise InputError(f"No model is named like {only!r}: give some of {names}.")
    results: dict[str, Any] = {"provenance": provenance()}
    quiet = Console(file=io.StringIO()) if advance else Console(stderr=True)
    with stages(console or quiet) as stage:
        for done, ((part, name), job) in enumerate(jobs.items()):
            if (part, name) in wanted and kept.find(_file(part, name)) is None:
                with stage(f"{name}"[:36]) as steps:
                    kept.part(_file(part, name), partial(_found, job, steps))
            if advance:
                advance(done + 1, len(jobs))
            if (found := kept.find(_file(part, name))) is not None:
                results.setdefault(part, {})[name] = found.values["found"]
    write_text(json.dumps(results, indent=1, allow_nan=False), folder / RESULTS_FILE)
    return results


def _found(job: Callable[[Advance], Any], advance: Advance) -> dict[str, Any]:
    return {"found": job(advance)}


def _file(part: str, name: str) -> str:
    """Name of the file that keeps a part."""
    return re.sub(r"[^a-z0-9]+", "-", f"{part} {name}".lower()).strip("-")


def _jobs(folder: Path, truth: OffLattice) -> dict[tuple[str, str], Callable[[Advance], Any]]:
    """What there is to do, by part of the results and name."""

    def rudder_data(advance: Advance) -> dict[str, OffLattice]:
        return solved(folder, rudder_sets(), advance) | {"lattice": _lattice(folder)}

    def model(contender: Contender, advance: Advance) -> dict[str, Any]:
        return _measured(contender, rudder_data(advance), truth)

    def surface(make: Estimator, solutions: int, advance: Advance) -> dict[str, Any]:
        return _surface(exact, make, solutions, truth)

    def jam_curve(chosen: Callable, name: str, advance: Advance) -> list[dict[str, Any]]:
        return _jam_curve(chosen(rudder_data(advance), name), truth)

    def thrust_map(advance: Advance) -> dict[str, Any]:
        return measured(exact, truth) | {"searches": exact.provenance["solves"], "fit_s": 0.0}

    def map_curve(advance: Advance) -> list[dict[str, Any]]:
        return [measured(part, truth) | {"searches": searches} for searches, part in refinements(exact)]

    def shipped(name: str, advance: Advance) -> dict[str, Any]:
        return measured(load_surrogate(name), truth)

    def shipped_further(name: str, advance: Advance) -> dict[str, Any]:
        return measured(load_surrogate(name), solved(folder, further_cases(), advance)["further_cases"])

    exact = ThrustMap.load()
    jobs: dict[tuple[str, str], Callable[[Advance], Any]] = {("models", "thrust map"): thrust_map}
    for part, measure in ((SHIPPED, shipped), (SHIPPED_FURTHER, shipped_further)):
        jobs |= {(part, name): partial(measure, name) for name in SURROGATES}
    jobs |= {("models", name): partial(model, contender) for name, contender in contenders().items()}
    for solutions in SURFACE_SOLUTIONS:
        name = f"Gaussian process, {solutions} thrusts"
        jobs["models", name] = partial(surface, gaussian_process, solutions)
    jobs["models", "BR network 4-20-1, 4000 thrusts"] = partial(surface, partial(_bayesian, 20, 2, 200), 4000)
    jobs["curves", "thrust map, refined"] = map_curve
    curves: dict[str, Callable[..., list[OffLattice]]] = {
        "lattice": partial(_lattices, folder),
        "random": _first,
        "sobol": _first,
        "adaptive": _adaptive,
    }
    for name, chosen in curves.items():
        jobs["curves", f"jam map, {name}"] = partial(jam_curve, chosen, name)
    jobs |= {("other failures", failure): partial(_other, folder, failure) for failure in OTHER_FAILURES}
    jobs["trim map", "rudder"] = partial(trim_map_study.curve, ("rudder",), truth)
    jobs |= {("trim map", failure): partial(_several, folder, failure) for failure in several_controls()}
    return jobs


def _lattice(folder: Path) -> OffLattice:
    return OffLattice(*dataset.samples(dataset.solved(folder / "lattice.zarr", dataset.lattice())))


def _measured(contender: Contender, sets: Mapping[str, OffLattice], truth: OffLattice) -> dict[str, Any]:
    data = sets[contender.data]
    started = time.process_time()
    model = contender.make().fit(data)
    seconds = time.process_time() - started
    found = off_lattice.scores(truth, *model.predict(truth.X))
    return found | {"searches": SEARCHES_A_CASE * len(data.X), "fit_s": seconds}


def _surface(exact: ThrustMap, make: Estimator, solves: int, truth: OffLattice) -> dict[str, Any]:
    started = time.process_time()
    learnt = surface_map(exact, make, solves)
    seconds = time.process_time() - started
    return measured(learnt, truth) | {"searches": solves, "fit_s": seconds}


def _jam_curve(sets: list[OffLattice], truth: OffLattice) -> list[dict[str, Any]]:
    """Errors of the Gaussian process on the jam map by the number of jams."""
    points = []
    for data in sets:
        found = off_lattice.scores(truth, *JamModel(gaussian_process).fit(data).predict(truth.X))
        points.append(found | {"searches": SEARCHES_A_CASE * len(data.X)})
    return points


def _first(sets: Mapping[str, OffLattice], name: str) -> list[OffLattice]:
    return [sets[f"{name}_jams"].take(slice(None, count)) for count in JAM_COUNTS]


def _adaptive(sets: Mapping[str, OffLattice], name: str) -> list[OffLattice]:
    pool = sets["sobol_jams"]
    order = chosen_jams(pool, JAM_COUNTS[-1])
    return [pool.take(order[:count]) for count in JAM_COUNTS]


def _lattices(folder: Path, sets: Mapping[str, OffLattice], name: str) -> list[OffLattice]:
    found = []
    for altitudes, gammas, jams in JAM_LATTICES:
        deflections = np.linspace(-30.0, 30.0, jams).tolist()
        table = dataset.lattice(
            np.linspace(*paper.ALTITUDE_FT, altitudes).tolist(),
            np.linspace(*paper.GAMMA_DEG, gammas).tolist(),
            [(deflection, deflection) for deflection in deflections],
        )
        data = dataset.solved(folder / f"jam_lattice_{len(table)}.zarr", table)
        found.append(OffLattice(*dataset.samples(data)))
    return found


def _other(folder: Path, failure: str, advance: Advance) -> dict[str, Any]:
    """Models of another failure, by name, on data of its own."""
    training, test = solved(folder, other_sets(failure), advance).values()
    measured = {}
    for name, make in (
        ("Gaussian process", gaussian_process),
        ("support vectors", support_vectors),
        ("boosted trees", boosted_trees),
        ("BR network", partial(_bayesian, 15, 3, 200)),
    ):
        started = time.process_time()
        model = CaseModel(make).fit(training)
        seconds = time.process_time() - started
        scores = off_lattice.scores(test, *model.predict(test.X))["all"]
        searches = SEARCHES_A_CASE * len(training.X)
        measured[name] = scores | {"fit_s": seconds, "inputs": test.X.shape[1], "searches": searches}
    trims = trim_map_study.measured(TrimMap.solve(), OTHER_FAILURES[failure], test)
    measured["trim map"] = trims | {"fit_s": 0.0, "inputs": test.X.shape[1]}
    if failure in THRUST_MAPS:
        scores = off_lattice.measured(ThrustMap.load(THRUST_MAPS[failure]), test)
        measured["thrust map"] = scores["all"] | {"fit_s": 0.0, "inputs": test.X.shape[1]}
    return measured


def _several(folder: Path, failure: str, advance: Advance) -> list[dict[str, Any]]:
    """Trim maps on limits of several controls."""
    (truth,) = solved(folder, {_file("several", failure): several_controls()[failure]}, advance).values()
    return trim_map_study.curve(OTHER_FAILURES[failure], truth, advance)
