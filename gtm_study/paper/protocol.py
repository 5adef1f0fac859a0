"""The paper's comparison of neural networks and local model networks (section III-D, III-E, appendix), over splits.

Each part of it is computed once and kept as a file, so that a stopped run goes on where it was. The split of a seed is
the same for all methods. Errors are mean squares of speeds mapped to 0..1 (paper eq. 11).
"""

import hashlib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from gtm_fmu.datasets import off_lattice, paper
from gtm_fmu.progress import Advance
from gtm_study.files import save_figures
from gtm_study.kept import Kept
from gtm_study.paper import protocol_figures, published
from gtm_study.paper.figures import LABELS
from gtm_study.paper.lattice import members
from surrogate import Schedule, Selection, Split, select_network, split_samples
from surrogate.plots import (
    plot_error_histogram,
    plot_growth,
    plot_performance,
    plot_regression,
    plot_regularization,
    plot_training,
)
from surrogate.rudder.emulator import INPUTS, SPEEDS
from surrogate.training.local_selection import LocalSelection, select_local_models
from surrogate.training.selection import squared_errors
from surrogate.training.train import METHODS, Method

TEST_FRACTION = 0.1
OUTLIERS = np.array(published.OUTLIERS)
"""Cases (4, 4) of paper Figs. 24-27 and 29-32."""


@dataclass(frozen=True)
class Lattice:
    """The feasible cases of the paper's lattice: inputs X (N, 4) as `INPUTS`, exact speeds Y (N, 2) in kn."""

    X: np.ndarray
    Y: np.ndarray

    @property
    def key(self) -> str:
        """What the kept parts belong to."""
        return hashlib.sha256(self.X.tobytes() + np.round(self.Y, 6).tobytes()).hexdigest()[:16]

    def members(self, data_set: int) -> np.ndarray:
        """Which cases (N,) belong to one of the paper's six data sets (Tables 7-12)."""
        return members(data_set, *self.X[:, 1:].T)

    def corners(self, rows: np.ndarray) -> list[int]:
        """Which of the rows are the lattice's corner: sea level, steepest descent, rudder jammed hard over."""
        altitude, gamma, lower, upper = self.X[rows].T
        ends = (altitude == self.X[:, 0].min()) & (gamma == self.X[:, 1].min()) & (lower == upper)
        return rows[ends & (np.abs(lower) == self.X[:, 2].max())].tolist()


@dataclass(frozen=True)
class Protocol:
    """The comparison on a lattice, into a folder."""

    lattice: Lattice
    folder: Path
    rounds: int = published.TRAINING_ROUNDS
    jobs: int = 1
    schedule: Schedule | None = None
    """Of the networks' training; None: the trainers' own."""
    hidden: int = 10
    most_local_models: int | None = None
    """Of a local model network; None: the trainer's own."""
    neuron_counts: tuple[int, ...] = tuple(range(1, 21))
    neuron_iterations: int = 10
    """The appendix: 1 to 20 hidden neurons, the process iterated 10 times."""
    shown: int = 0
    """The seed of the split whose figures are drawn."""

    def split(self, seed: int, data_set: int = 6) -> Split:
        """The split of a seed; the independent part is that of the whole data set, whichever set is trained on."""
        members = self.lattice.members(data_set)
        return split_samples(len(self.lattice.X), self.rounds, TEST_FRACTION, seed, members)

    def part(self, name: str, compute: Callable[[], tuple[dict[str, Any], dict[str, Figure]]]) -> dict[str, Any]:
        """Values of a part, kept or computed, its figures first."""
        drawn: list[Path] = []

        def computed() -> dict[str, Any]:
            values, figures = compute()
            for title, figure in figures.items():
                drawn.extend(save_figures(figure, self.folder / title))
            return values

        kept = Kept(self.folder, lattice=self.lattice.key, rounds=self.rounds, schedule=self.schedule)
        sizes: dict[str, Any] = {
            "hidden": self.hidden,
            "most_local_models": self.most_local_models,
            "shown": self.shown,
        }
        sizes["iterations"] = self.neuron_iterations
        return kept.part(name, computed, lambda: drawn, **sizes)

    def networks(
        self, method: Method, seed: int, advance: Advance, data_set: int = 6, selection: Selection | None = None
    ) -> dict[str, Any]:
        """Algorithm 1 with a method on a data set; `selection`: what it gave, where it has run already."""

        def compute() -> tuple[dict[str, Any], dict[str, Figure]]:
            found = selection or self._select(method, seed, self.split(seed, data_set), advance)
            return self._networks(found, method, seed == self.shown and data_set == 6)

        return self.part(f"{method}-set{data_set}-split{seed}", compute)

    def _networks(self, selection: Selection, method: Method, drawn: bool) -> tuple[dict[str, Any], dict[str, Figure]]:
        values = self._scores(selection, squared_errors(selection.network, selection.X, selection.Y))
        values["epochs"] = [len(history.sse) - 1 for history in selection.histories]
        values["off_lattice"] = _off_lattice(selection.network.predict)
        values["metrics"] = selection.network.metrics
        values["outliers"] = selection.network.predict(OUTLIERS).tolist()
        return values, _network_figures(selection, method) if drawn else {}

    def local_models(self, seed: int, advance: Advance, data_set: int = 6) -> dict[str, Any]:
        """Algorithm 2 on a data set."""

        def compute() -> tuple[dict[str, Any], dict[str, Figure]]:
            X, Y = self.lattice.X, self.lattice.Y
            selection = select_local_models(
                X,
                Y,
                inputs=INPUTS,
                outputs=SPEEDS,
                seed=seed,
                split=self.split(seed, data_set),
                jobs=self.jobs,
                max_models=self.most_local_models,
                progress=advance,
            )
            squares = ((selection.predict(X) - Y) / np.ptp(Y, axis=0)) ** 2
            values = self._scores(selection, squares)
            values["chosen"] = [
                [f"{c.algorithm} {c.local_model}" for c in selection.best(j)] for j in range(self.rounds)
            ]
            values["sizes"] = [
                {"models": c.network.models, "parameters": int(c.growth.parameters[c.growth.best - 1])}
                for c in selection.best(selection.selected)
            ]
            values["off_lattice"] = _off_lattice(selection.predict)
            values["outliers"] = selection.predict(OUTLIERS).tolist()
            drawn = seed == self.shown and data_set == 6
            return values, _growth_figures(selection) if drawn else {}

        return self.part(f"local_models-set{data_set}-split{seed}", compute)

    def neurons(self, seed: int, advance: Advance) -> dict[str, Any]:
        """Least errors on the independent part by number of hidden neurons and iteration (Fig. 41)."""
        split = split_samples(len(self.lattice.X), self.neuron_iterations, TEST_FRACTION, seed)
        mse = []
        for k, hidden in enumerate(self.neuron_counts):

            def compute(hidden: int = hidden) -> tuple[dict[str, Any], dict[str, Figure]]:
                selection = self._select("bayesian_regularization", seed, split, lambda *_: None, hidden)
                return {"mse_independent": selection.mse["independent"].tolist()}, {}

            mse.append(self.part(f"neurons{hidden}-split{seed}", compute)["mse_independent"])
            advance(k + 1, len(self.neuron_counts))
        return {"neurons": list(self.neuron_counts), "mse_independent": mse}

    def _select(
        self, method: Method, seed: int, split: Split, advance: Advance, hidden: int | None = None
    ) -> Selection:
        return select_network(
            self.lattice.X,
            self.lattice.Y,
            inputs=INPUTS,
            outputs=SPEEDS,
            seed=seed,
            method=method,
            split=split,
            hidden=hidden or self.hidden,
            schedule=self.schedule,
            progress=advance,
        )

    def _scores(self, selection: Selection | LocalSelection, squares: np.ndarray) -> dict[str, Any]:
        """Errors of all rounds, and of the selected model (squares (N, 2)) at each independent case."""
        independent = selection.split.independent
        return {
            "samples": int(selection.split.training.shape[1] + selection.split.test.shape[1]),
            "mse_independent": selection.mse["independent"].tolist(),
            "mse_by_output": selection.mse_by_output["independent"].tolist(),
            "mse_training": selection.mse["training"].tolist(),
            "selected": selection.selected,
            "cases": self.lattice.X[independent].tolist(),
            "squared_errors": squares[independent].tolist(),
            "corners": self.lattice.X[self.lattice.corners(independent)].tolist(),
        }


def run(protocol: Protocol, splits: int, data_set_splits: int, stage: Callable) -> dict[str, Any]:
    """All parts, and the results that they make: tables and figures beside the parts."""
    methods: dict[Method, list[dict[str, Any]]] = {}
    for method, (name, _) in METHODS.items():
        methods[method] = []
        for seed in range(splits):
            with stage(f"{name}, split {seed + 1}") as advance:
                methods[method].append(protocol.networks(method, seed, advance))
    local = []
    for seed in range(splits):
        with stage(f"Local model networks, split {seed + 1}") as advance:
            local.append(protocol.local_models(seed, advance))
    data_sets: dict[int, list[dict[str, Any]]] = {}
    for data_set in paper.DATA_SETS:
        data_sets[data_set] = []
        for seed in range(data_set_splits):
            with stage(f"Data set {data_set}, split {seed + 1}") as advance:
                network = protocol.networks("bayesian_regularization", seed, advance, data_set)
                local_models = protocol.local_models(seed, advance, data_set)
            data_sets[data_set].append({"network": network, "local_models": local_models})
    with stage("Hidden neurons") as advance:
        neurons = protocol.neurons(0, advance)
    results = {"networks": methods, "local_models": local, "data_sets": data_sets, "neurons": neurons}
    for title, figure in protocol_figures.figures(results).items():
        save_figures(figure, protocol.folder / title)
    return results


def _off_lattice(predict: Callable[[np.ndarray], np.ndarray]) -> dict[str, Any]:
    """Errors on the off-lattice test set, where envelopes exist."""
    truth = off_lattice.load()
    return off_lattice.scores(truth, predict(truth.X), truth.feasible)


def _network_figures(selection: Selection, method: Method) -> dict[str, Figure]:
    """Figs. 11-13 (Bayesian regularisation) or 14-16, and what the paper does not show: the evidence parameters."""
    figures = {
        f"{method}_training": plot_training(selection),
        f"{method}_regression": plot_regression(selection, LABELS),
        f"{method}_errors": plot_error_histogram(selection, LABELS),
        f"{method}_networks": plot_performance(selection),
    }
    if method == "bayesian_regularization":
        figures[f"{method}_evidence"] = plot_regularization(selection.histories[selection.selected])
    return figures


def _growth_figures(selection: LocalSelection) -> dict[str, Figure]:
    """Figs. 20-22: the growth of the best network of V_max in the selected round, and of all six."""
    six = selection.candidates[selection.selected][-1]
    growths = {f"{c.algorithm.upper()}, {c.local_model.replace('_', ' ')}": c.growth for c in six}
    best = selection.best(selection.selected)[-1].growth
    return {
        "growth_best": protocol_figures.plot_best_growth(best),
        **{f"growth_{part}": plot_growth(growths, part) for part in ("training", "validation")},
    }
