"""The study end to end at a small size: what it leaves, that it says the same again, and that it can be stopped."""

import io
import json
import re
import shutil
import sys
from pathlib import Path

import fmpy
import matplotlib.image
import numpy as np
import pytest
from matplotlib.figure import Figure
from rich.console import Console

from gtm_fmu.aircraft.limits import ControlLimits
from gtm_fmu.datasets import lattice as dataset
from gtm_fmu.datasets import off_lattice
from gtm_fmu.envelopes.envelope import envelope
from gtm_fmu.errors import InputError
from gtm_study.paper import comparisons, pipeline
from gtm_study.paper.rudder_grid import Cells
from gtm_study.paper.stages import STAGES, Sizes
from gtm_study.report.page import PAGE, write_page
from surrogate.rudder.emulator import RudderEmulator
from tests.gtm_study.looks import alike

pytestmark = pytest.mark.slow

PICTURES = {
    f"{name}.png"
    for name in ("envelope_jams", "regression", "performance", "errors", "emulator_jams", "indices", "failures")
}
NETWORKS = {"rudder_speeds.json", "rudder_throttle.json"}
FMUS = {"GtmDynamics.fmu", "GtmSurrogate.fmu"}
PROMISED = {PAGE, *PICTURES, *NETWORKS, *FMUS, "envelopes.zarr", "results.json", "results.md"}
ALTITUDES_FT, GAMMAS_DEG, RUDDERS_DEG = (0.0, 20000.0), (-4.0, 0.0, 4.0), (-20.0, 0.0, 20.0)
TRIMS, EPOCHS, ROUNDS = 6, 5, 2


SMALL = Sizes(
    altitudes_ft=ALTITUDES_FT,
    gammas_deg=GAMMAS_DEG,
    rudders_deg=RUDDERS_DEG,
    trims=TRIMS,
    jams_deg=(0.0, 30.0),
    volume_gammas_deg=(-5.0, 5.0),
    map_altitudes_ft=(0.0, 30000.0),
    map_gammas_deg=(-5.0, 5.0),
    map_jam_step_deg=20.0,
    limit_step_deg=20.0,
    rounds=ROUNDS,
    hidden=3,
    epochs=EPOCHS,
    finer_cells=Cells(4, 4, 12),
)


def quietly(folder: Path, **options) -> dict:
    return pipeline.run(folder, 1, console=Console(file=io.StringIO()), sizes=SMALL, after_stage=write_page, **options)


@pytest.fixture(scope="module")
def drawn() -> list[Figure]:
    """The figures of the run that left `folder`."""
    return []


@pytest.fixture(scope="module")
def folder(tmp_path_factory, drawn) -> Path:
    """What a run leaves."""
    folder, savefig = tmp_path_factory.mktemp("study") / "new", Figure.savefig

    def noted(figure, *arguments, **options) -> None:
        drawn.append(figure)
        savefig(figure, *arguments, **options)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Figure, "savefig", noted)
        quietly(folder)
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

    def test_figures_need_no_colours(self, folder, drawn):
        """What a legend names is told apart in grey too, and so by the colour-blind."""
        assert len(drawn) >= 2 * len(PICTURES)
        assert [pair for figure in drawn for pair in alike(figure)] == []

    def test_fmus(self, folder):
        assert {path.name for path in folder.glob("*.fmu")} == FMUS
        for name in FMUS:
            assert f"{fmpy.read_model_description(folder / name).modelName}.fmu" == name

    def test_data_set(self, folder):
        data = dataset.view(folder / "envelopes.zarr")
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
        data = dataset.view(folder / "envelopes.zarr")
        assert results["lattice"] == {"cases": 36, "feasible": int(data.feasible.sum())}
        assert results["networks"]["samples"] == results["lattice"]["feasible"]
        assert results["trims"]["trims"] == TRIMS
        assert results["networks"]["off_lattice"]["all"]["cases"] == off_lattice.CASES

    def test_methods_agree(self, results):
        """Issues 5 and 8: both trims to 1e-6, the FMU as its network."""
        trims = results["trims"]
        assert trims["same_verdict"] == TRIMS
        assert trims["feasible"] > 0
        assert trims["largest_difference"] < 1e-6
        assert results["surrogate-fmu"]["largest_difference_kt"] < 1e-9

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
        assert set(results["sensitivity"]["failures"]) == {"controls", "everything"}


class TestAgain:
    def test_stopped_and_run_again(self, folder, tmp_path, monkeypatch):
        """A run that is stopped leaves what was finished; the next one ends with the same bytes as one in peace."""

        def stop(*_):
            raise KeyboardInterrupt

        with monkeypatch.context() as patch:
            patch.setattr(comparisons, "speeds_over_jams", stop)
            with pytest.raises(KeyboardInterrupt):
                quietly(tmp_path)
        before = {path: path.stat().st_mtime_ns for path in tmp_path.iterdir() if path.is_file()}
        told = json.loads((tmp_path / "results.json").read_text())
        assert f"{len(told)} of {len(STAGES)} stages are finished" in (tmp_path / PAGE).read_text()
        assert told.keys() == {"trims", "lattice", "jams", "volume", "limits", "surrogate-fmu", "explorer"}
        quietly(tmp_path)
        assert names(tmp_path) == names(folder)
        for name in ("GtmDynamics.fmu", "envelope_jams.png", "volume.html"):
            assert (tmp_path / name).stat().st_mtime_ns == before[tmp_path / name], name
        for name in names(folder) - {"envelopes.zarr", "volume.html", "parts", PAGE}:  # new ids by plotly; times
            assert (tmp_path / name).read_bytes() == (folder / name).read_bytes(), name
        for part in (folder / "parts").iterdir():
            values = [json.loads(path.read_text())["values"] for path in (part, tmp_path / "parts" / part.name)]
            assert values[0] == values[1]
        assert dataset.view(tmp_path / "envelopes.zarr").identical(dataset.view(folder / "envelopes.zarr"))

    def test_only_what_changed_is_done_again(self, folder, tmp_path):
        """A file that was lost brings its stage back, another seed all of them."""
        shutil.copytree(folder, tmp_path / "copy")
        (tmp_path / "copy" / "limits.png").unlink()
        before = {path.name: path.stat().st_mtime_ns for path in (tmp_path / "copy" / "parts").iterdir()}
        quietly(tmp_path / "copy")
        after = {path.name: path.stat().st_mtime_ns for path in (tmp_path / "copy" / "parts").iterdir()}
        assert {name for name, time in after.items() if time != before[name]} == {"limits.json"}
        assert (tmp_path / "copy" / "limits.png").exists()

    def test_only(self, tmp_path):
        """A stage comes with what it needs, and the results are those of the finished ones."""
        found = quietly(tmp_path, only=["networks"])
        assert found.keys() == {"lattice", "networks"}
        assert "Lattice cases" in (tmp_path / "results.md").read_text()

    @pytest.mark.parametrize(
        ("options", "sentence"),
        [({"only": ["oracle"]}, "There is no stage 'oracle': give some of trims"), ({"level": "x"}, "no level 'x'")],
    )
    def test_what_is_not_there(self, tmp_path, options, sentence):
        with pytest.raises(InputError, match=sentence):
            quietly(tmp_path / "study", **options)
        assert not (tmp_path / "study").exists()

    def test_list(self, ask):
        lines = ask("study", "--list").out.splitlines()
        assert [line.split()[0] for line in lines] == [stage.name for stage in STAGES]


def test_without_torch(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "torch", None)
    with pytest.raises(InputError, match="trains networks with torch, which is not here; run pip install"):
        pipeline.run(tmp_path / "study")
    assert not list(tmp_path.iterdir())
