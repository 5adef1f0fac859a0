"""The comparison of networks on a lattice: parts that are kept, tables and figures."""

import json
from contextlib import contextmanager
from dataclasses import replace

import numpy as np
import pytest

from gtm_fmu.progress import Advance
from gtm_study.paper import protocol_report, published
from gtm_study.paper.protocol import Lattice, Protocol, run
from surrogate import Schedule
from tests.gtm_study.looks import alike

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def lattice() -> Lattice:
    """A lattice as the paper's, with a smooth function in place of the envelope."""
    axes = [published.LATTICE_LEVELS[name] for name in ("altitude_ft", "gamma_deg", "rudder_lower_deg")]
    altitude, gamma, lower, upper = (
        values.ravel() for values in np.meshgrid(*axes, axes[-1], indexing="ij") if values is not None
    )
    X = np.column_stack([altitude, gamma, lower, upper])[lower <= upper]
    h, g, low, up = X.T
    severity = np.maximum(np.maximum(low, -up), 0) / 30
    return Lattice(X, np.column_stack([60 + h / 1000 + 10 * severity**2, 150 - h / 1000 - g - 30 * severity**2]))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("protocol")


@pytest.fixture(scope="module")
def comparison(lattice, folder) -> Protocol:
    half = Lattice(lattice.X[::2], lattice.Y[::2])
    return Protocol(half, folder, rounds=2, schedule=Schedule(epochs=5))


def nothing(done: int, total: int) -> None:
    """No progress to show."""


def test_data_sets_are_the_papers(lattice):
    """Tables 7-12 without the samples that have no envelope."""
    assert len(lattice.X) == 1232
    assert [int(lattice.members(k).sum()) for k in range(1, 7)] == [
        3 * 4 * 28,
        11 * 4 * 6,
        11 * 4 * 10,
        3 * 4 * 6,
        3 * 4 * 10,
        1232,
    ]


def test_corners_are_the_hardest_jams_at_sea_level(lattice):
    rows = lattice.corners(np.arange(len(lattice.X)))
    assert lattice.X[rows].tolist() == [[0, -5, -30, -30], [0, -5, 30, 30]]


def test_diminished_sets_keep_the_independent_part(comparison):
    whole, part = comparison.split(0), comparison.split(0, 5)
    np.testing.assert_array_equal(whole.independent, part.independent)
    assert comparison.lattice.members(5)[part.rows("all", 0)].all()


def test_a_part_is_computed_once_and_kept(comparison, folder):
    first = comparison.networks("levenberg_marquardt", 1, nothing)
    path = folder / "parts" / "levenberg_marquardt-set6-split1.json"
    before = path.read_bytes()
    assert comparison.networks("levenberg_marquardt", 1, pytest.fail) == first
    assert path.read_bytes() == before
    kept = json.loads(before)
    kept.pop("seconds")
    for useless in (json.dumps(kept | {"key": "of another run"}), before[:100].decode()):
        path.write_text(useless)
        assert comparison.networks("levenberg_marquardt", 1, nothing)["mse_independent"] == first["mse_independent"]
        again = json.loads(path.read_bytes())
        assert again.pop("seconds") >= 0.0
        assert again == kept


def test_errors_are_those_of_the_part(comparison):
    lattice = comparison.lattice
    part = comparison.networks("levenberg_marquardt", 1, nothing)
    independent = comparison.split(1).independent
    np.testing.assert_array_equal(part["cases"], lattice.X[independent])
    assert np.mean(part["squared_errors"]) == pytest.approx(min(part["mse_independent"]), rel=1e-9)
    assert part["samples"] == len(lattice.X) - len(independent)
    assert np.mean(part["mse_by_output"], axis=1) == pytest.approx(part["mse_independent"])


def test_tables_and_figures_of_a_whole_run(comparison, monkeypatch):
    """With few neurons tried and few models grown; the numbers in the tables are those of the parts."""
    pictures = []

    def noted(figure, stem):
        pictures.append(stem.name)
        assert alike(figure) == [], stem.name
        return []

    monkeypatch.setattr("gtm_study.paper.protocol.save_figures", noted)
    comparison = replace(comparison, neuron_counts=(1, 2), neuron_iterations=2, most_local_models=3)

    @contextmanager
    def stage(name: str):
        advance: Advance = nothing
        yield advance

    results = protocol_report.summary(run(comparison, 2, 1, stage))
    text = protocol_report.protocol_report(results)
    least = results["methods"]["bayesian_regularization"]["best"]
    assert f"| Bayesian regularisation | {least[0]:.3g} | {least[1]:.3g} |" in text
    assert f"| {published.MSE_ANN[3]:.3g} | {published.MSE_LMN[3]:.3g} |" in text
    assert set(results["neurons"]) == {"1", "2"}
    assert {"trainings", "splits", "data_sets", "neurons", "squared_errors", "growth_validation"} <= set(pictures)
    assert json.loads(json.dumps(results, allow_nan=False))["data_sets"].keys() == {"1", "2", "3", "4", "5", "6"}
