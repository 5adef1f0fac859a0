"""The study end to end at a small size: what it leaves, that it says the same again, and that it can be stopped."""

import io
import json
import re
import sys
from functools import partial
from pathlib import Path

import fmpy
import matplotlib.image
import numpy as np
import pytest
import xarray as xr
from rich.console import Console

from gtm_fmu.aircraft.limits import ControlLimits
from gtm_fmu.datasets import lattice as dataset
from gtm_fmu.envelopes import maps as surveys
from gtm_fmu.envelopes.envelope import envelope
from gtm_fmu.errors import InputError
from study.commands import cli
from study.paper import comparisons, pipeline, rudder_sensitivity
from study.paper.rudder_grid import Cells
from surrogate import Schedule
from surrogate.rudder.emulator import RudderEmulator, train

pytestmark = pytest.mark.slow

PICTURES = {
    f"{name}.png"
    for name in ("envelope_jams", "regression", "performance", "errors", "emulator_jams", "indices", "failures")
}
NETWORKS = {"rudder_speeds.json", "rudder_throttle.json"}
FMUS = {"GtmDynamics.fmu", "GtmSurrogate.fmu"}
PROMISED = {*PICTURES, *NETWORKS, *FMUS, "envelopes.zarr", "results.json", "results.md"}
AFTER_THE_NETWORKS = {
    "GtmSurrogate.fmu",
    "emulator_jams.png",
    "indices.png",
    "failures.png",
    "results.json",
    "results.md",
}
ALTITUDES_FT, GAMMAS_DEG, RUDDERS_DEG = (0.0, 20000.0), (-4.0, 0.0, 4.0), (-20.0, 0.0, 20.0)
TRIMS, CASES, EPOCHS, ROUNDS = 6, 6, 5, 2


@pytest.fixture(scope="module")
def small():
    """The same study with fewer cases, trims, rounds, epochs and rows."""
    failures = dataset.rudder_failures(RUDDERS_DEG)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(dataset, "lattice", partial(dataset.lattice, ALTITUDES_FT, GAMMAS_DEG, failures))
        patch.setattr(pipeline, "train", partial(train, rounds=ROUNDS, hidden=3, schedule=Schedule(epochs=EPOCHS)))
        patch.setattr(comparisons, "TRIMS", TRIMS)
        patch.setattr(comparisons, "OFF_LATTICE_CASES", CASES)
        patch.setattr(rudder_sensitivity, "FINER_CELLS", Cells(4, 4, 12))
        patch.setattr(comparisons, "FIG_3_JAMS_DEG", (0.0, 30.0))
        patch.setattr(surveys, "GAMMAS_DEG", (-5.0, 5.0))
        patch.setattr(surveys, "ALTITUDES_FT", (0.0, 30000.0))
        patch.setattr(surveys, "JAM_STEP", 20.0)
        patch.setattr(surveys, "limit_surface", partial(surveys.limit_surface, step=20.0))
        yield


@pytest.fixture(scope="module")
def folder(small, tmp_path_factory) -> Path:
    """What a run leaves."""
    folder = tmp_path_factory.mktemp("study") / "new"
    pipeline.run(folder, seed=1, console=Console(file=io.StringIO()))
    return folder


@pytest.fixture(scope="module")
def results(folder) -> dict:
    return json.loads((folder / "results.json").read_text())


def names(folder: Path) -> set[str]:
    """Files of a folder, none of them unfinished."""
    found = {path.name for path in folder.iterdir()}
    assert not [name for name in found if name.startswith(".") or "partial" in name or "tmp" in name]
    return found


class TestFiles:
    def test_all_that_are_promised(self, folder):
        assert names(folder) >= PROMISED

    def test_all_of_the_readme(self, folder):
        readme = (Path(pipeline.__file__).parents[2] / "README.md").read_text()
        table = readme.split("leaves in `build/study`")[1].split("\n## ")[0]
        promised = set(re.findall(r"`([\w.]+\.(?:fmu|zarr|json|md|html))`", table))
        assert len(promised) >= 7
        assert names(folder) >= promised

    def test_pictures(self, folder):
        for path in folder.glob("*.png"):
            pixels = matplotlib.image.imread(path)
            assert min(pixels.shape[:2]) > 300
            assert pixels[..., :3].std() > 0.02, f"{path.name} is blank"

    def test_fmus(self, folder, results):
        assert set(results["fmus"]) == FMUS
        for name in FMUS:
            assert f"{fmpy.read_model_description(folder / name).modelName}.fmu" == name

    def test_data_set(self, folder):
        data = dataset.load(folder / "envelopes.zarr")
        assert dict(data.sizes) == {"altitude": 2, "gamma": 3, "failure": 6}
        assert sorted(set(data.rudder_lower.values)) == list(RUDDERS_DEG)
        exact = envelope(20000, -4, ControlLimits(rudder_deg=(0, 20)))
        failure = np.flatnonzero((data.rudder_lower == 0) & (data.rudder_upper == 20)).item()
        found = data.sel(altitude=20000, gamma=-4).isel(failure=failure)
        assert (float(found.v_min), float(found.v_max)) == (exact.v_min_kt, exact.v_max_kt)

    def test_networks(self, folder):
        emulator = RudderEmulator.load(folder)
        for network in (emulator.speeds, emulator.throttle):
            assert network.provenance["seed"] == 1
            assert network.provenance["restart"] in range(ROUNDS)
            assert network.provenance["epochs"] <= EPOCHS
            assert len(network.provenance["aerodynamic_data_sha256"]) == 64
            np.testing.assert_array_equal(network.input_ranges, [(0, 20000), (-4, 4), (-20, 20), (-20, 20)])


class TestResults:
    def test_counts(self, folder, results):
        data = xr.open_zarr(folder / "envelopes.zarr", consolidated=False)
        assert results["envelopes"] == {"cases": 36, "feasible": int(data.feasible.sum())}
        assert results["networks"]["samples"] == results["envelopes"]["feasible"]
        assert results["trims"]["trims"] == TRIMS
        assert results["off_lattice"]["cases"] == CASES
        assert 0 < results["off_lattice"]["compared"] <= results["off_lattice"]["feasible"] <= CASES

    def test_methods_agree(self, results):
        """Issues 5 and 8: both trims to 1e-6, the FMU as its network."""
        trims = results["trims"]
        assert trims["same_verdict"] == TRIMS
        assert trims["feasible"] > 0
        assert trims["largest_difference"] < 1e-6
        assert results["surrogate_fmu"]["largest_difference_kt"] < 1e-9

    def test_selected_network(self, folder, results):
        scores = results["networks"]
        assert len(scores["mse_independent"]) == ROUNDS
        assert scores["selected"] == 1 + int(np.argmin(scores["mse_independent"]))
        assert RudderEmulator.load(folder).speeds.metrics == scores["speeds"]
        assert scores["speeds"]["mse_independent"] == min(scores["mse_independent"])

    def test_indices(self, results):
        """Of three questions, exact and by the thrust map; by both networks where they give the speeds."""
        questions = results["sensitivity"]["questions"]
        speeds = ["exact", "thrust map", "package's network", "paper's network"]
        assert {question: list(found["answers"]) for question, found in questions.items()} == {
            "as in the paper": speeds,
            "with an envelope": speeds,
            "whether": speeds[:2],
        }
        assert set(results["failures"]) == {"controls", "everything"}


class TestAgain:
    def stop(self, *_):
        raise KeyboardInterrupt

    def test_stopped_and_run_again(self, small, folder, tmp_path, monkeypatch):
        """A run that is stopped leaves what was finished; the next one ends with the same bytes as one in peace."""
        with monkeypatch.context() as patch:
            patch.setattr(comparisons, "compare_emulator", self.stop)
            with pytest.raises(KeyboardInterrupt):
                pipeline.run(tmp_path, seed=1, console=Console(file=io.StringIO()))
        assert names(tmp_path) == names(folder) - AFTER_THE_NETWORKS
        for name in NETWORKS:
            assert (tmp_path / name).read_bytes() == (folder / name).read_bytes(), name

        monkeypatch.setattr(sys, "argv", ["gtm-fmu", "study", "--output", str(tmp_path), "--seed", "1", "--json"])
        printed = io.StringIO()
        monkeypatch.setattr(sys, "stdout", printed)
        with pytest.raises(SystemExit) as end:
            cli.main()
        assert end.value.code == 0
        assert names(tmp_path) == names(folder)
        for name in names(folder) - {"envelopes.zarr", "volume.html"}:  # plotly draws a new id each time
            assert (tmp_path / name).read_bytes() == (folder / name).read_bytes(), name
        assert dataset.load(tmp_path / "envelopes.zarr").identical(dataset.load(folder / "envelopes.zarr"))
        assert json.loads(printed.getvalue()) == json.loads((folder / "results.json").read_text())


def test_without_torch(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "torch", None)
    with pytest.raises(InputError, match="trains networks with torch, which is not here; run pip install"):
        pipeline.run(tmp_path / "study")
    assert not list(tmp_path.iterdir())
