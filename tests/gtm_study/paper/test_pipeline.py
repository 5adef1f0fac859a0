"""The study end to end at a small size: what it leaves, that it says the same again, and that it can be stopped."""

import html
import inspect
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
from gtm_study.commands.study import study
from gtm_study.paper import comparisons, pipeline
from gtm_study.paper.registry import COUNTERPARTS, ours, verdict
from gtm_study.paper.rudder_grid import Cells
from gtm_study.paper.stages import LEVELS, STAGES, USUAL_LEVEL, Sizes
from gtm_study.report.captions import CAPTIONS
from gtm_study.report.page import PAGE, write_page
from surrogate.rudder.emulator import RudderEmulator
from tests.gtm_study.looks import alike

pytestmark = pytest.mark.slow

PICTURES = {
    f"{name}{ending}"
    for name in ("envelope_jams", "bayesian_regularization_networks", "emulator_jams", "indices", "failures")
    for ending in (".png", ".svg")
}
NETWORKS = {"rudder_speeds.json", "rudder_throttle.json"}
FMUS = {"GtmDynamics.fmu", "GtmSurrogate.fmu"}
PROMISED = {PAGE, *PICTURES, *NETWORKS, *FMUS, "envelopes.zarr", "results.json", "results.md"}
ALTITUDES_FT, GAMMAS_DEG, RUDDERS_DEG = (0.0, 20000.0), (-5.0, 0.0, 5.0), (-20.0, -10.0, 0.0, 10.0, 20.0)
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
    path_levels=(2, 3),
    most_local_models=2,
    neuron_counts=(1, 2),
    neuron_iterations=2,
    splits=2,
    data_set_splits=1,
    trajectories=16,
    base_rows=256,
    mirrored_cases=4,
    scanned_cases=1,
)


def quietly(folder: Path, after_stage=write_page, **options) -> dict:
    return pipeline.run(folder, 1, console=Console(file=io.StringIO()), sizes=SMALL, after_stage=after_stage, **options)


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
            if path.name.startswith(("effects", "neurons", "outlier")):
                continue  # little ink at this size
            pixels = matplotlib.image.imread(path)
            assert min(pixels.shape[:2]) > 300
            assert pixels[..., :3].std() > 0.02, f"{path.name} is blank"

    def test_the_page_shows_every_counterpart(self, folder, results):
        """The figure or the table that the registry names is what its stage leaves, and is in the page."""
        page = (folder / PAGE).read_text()
        for each in COUNTERPARTS:
            if each.stage:
                assert not each.figure or f'alt="{each.number}: ' in page, each.number
                assert not each.table or f"<caption>{each.number}, ours: " in page, each.number
                assert not each.table or each.table in results[each.stage], each.number

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
        assert dict(data.sizes) == {"altitude": 2, "gamma": 3, "failure": 15}
        assert sorted(set(data.rudder_lower.values)) == list(RUDDERS_DEG)
        exact = envelope(20000, -5, ControlLimits(rudder_deg=(0, 20)))
        failure = np.flatnonzero((data.rudder_lower == 0) & (data.rudder_upper == 20)).item()
        found = data.sel(altitude=20000, gamma=-5).isel(failure=failure)
        assert (float(found.v_min), float(found.v_max)) == (exact.v_min_kt, exact.v_max_kt)

    def test_networks(self, folder):
        emulator = RudderEmulator.load(folder)
        for network in (emulator.speeds, emulator.throttle):
            assert network.provenance["seed"] == 1
            assert network.provenance["restart"] in range(ROUNDS)
            assert network.provenance["epochs"] <= EPOCHS
            assert len(network.provenance["aerodynamic_data_sha256"]) == 64
            np.testing.assert_array_equal(network.input_ranges, [(0, 20000), (-5, 5), (-20, 20), (-20, 20)])


class TestResults:
    def test_counts(self, folder, results):
        data = dataset.view(folder / "envelopes.zarr")
        assert results["lattice"]["cases"] == 90
        assert results["lattice"]["feasible"] == int(data.feasible.sum())
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


class TestRegistry:
    """Every figure and table of the paper that has a counterpart is there once its stage is finished."""

    def test_each_is_judged(self, results):
        for each in COUNTERPARTS:
            if each.stage is None:
                assert verdict(each, results) == "none"
            else:
                assert verdict(each, results) in ("same", "better", "different"), each.number
                assert re.search(r"\d", ours(each, results)), each.number

    def test_each_has_its_picture_or_table(self, folder, results):
        for each in COUNTERPARTS:
            if each.figure is not None:
                assert (folder / f"{each.figure}.svg").read_text().count("<svg") == 1, each.number
                assert (folder / f"{each.figure}.png").stat().st_size > 5000, each.number
            if each.table is not None:
                found = results[each.stage][each.table]
                assert found["rows"], each.number
                assert {len(row) for row in found["rows"]} == {len(found["heads"])}, each.number
                assert all(isinstance(cell, str | float | int) for row in found["rows"] for cell in row), each.number

    def test_what_goes_beyond_has_words(self, folder):
        page = (folder / PAGE).read_text()
        beyond = page.split('id="beyond"')[1].split('id="left-out"')[0]
        told = re.findall(r"<figcaption[^>]*>(.*?)</figcaption>|<caption>(.*?)</caption>", beyond)
        words = {html.unescape(re.sub("<.*?>", "", picture or table)).replace("Vm", "V_m") for picture, table in told}
        assert len(words) > 10
        assert words <= set(CAPTIONS.values())

    def test_what_is_not_computed_yet(self, results):
        some = {name: values for name, values in results.items() if name in ("trims", "lattice", "networks")}
        later = next(each for each in COUNTERPARTS if each.number == "Figure 41")
        assert later.finding(some) == ("", "none", "Not computed yet: gtm-fmu study --only neurons")

    def test_networks_are_trained_once(self, folder, results):
        """The stage of the networks hands them to the comparison, whose errors are then the same."""
        part = json.loads((folder / "parts" / "bayesian_regularization-set6-split1.json").read_text())["values"]
        assert part["mse_independent"] == results["networks"]["mse_independent"]


class TestAgain:
    def test_stopped_and_run_again(self, folder, tmp_path, monkeypatch):
        """A run that is stopped leaves what was finished; the next one ends with the same bytes as one in peace."""

        def stop(*_):
            raise KeyboardInterrupt

        wanted = {"only": ["jams", "volume", "networks", "effects"]}
        told = []

        def tell(run, finished) -> None:
            told.append([*finished])
            write_page(run, finished)

        with monkeypatch.context() as patch:
            patch.setattr(comparisons, "speeds_over_jams", stop)
            with pytest.raises(KeyboardInterrupt):
                quietly(tmp_path, after_stage=tell, **wanted)
        assert told == [[], ["lattice"], ["lattice", "jams"], ["lattice", "jams", "volume"]]
        before = {path: path.stat().st_mtime_ns for path in tmp_path.iterdir() if path.is_file()}
        assert f"3 of {len(STAGES)} stages are finished" in (tmp_path / PAGE).read_text()
        assert json.loads((tmp_path / "results.json").read_text()).keys() == {"lattice", "jams", "volume"}
        found = quietly(tmp_path, **wanted)
        whole = json.loads((folder / "results.json").read_text())
        assert found == {name: whole[name] for name in ("lattice", "jams", "volume", "networks", "effects")}
        for name in ("envelope_jams.png", "envelope_jams.svg", "volume.html"):
            assert (tmp_path / name).stat().st_mtime_ns == before[tmp_path / name], name
        drawn = {path.name for path in tmp_path.glob("*.png")} | {path.name for path in tmp_path.glob("*.svg")}
        assert {"volume_unimpaired.svg", "networks_by_output.png", "effects_v_max.png"} <= drawn
        for name in drawn | NETWORKS:
            assert (tmp_path / name).read_bytes() == (folder / name).read_bytes(), name
        assert dataset.view(tmp_path / "envelopes.zarr").identical(dataset.view(folder / "envelopes.zarr"))

    def test_only_what_changed_is_done_again(self, folder, tmp_path):
        """A file that was lost brings its stage back, another seed all of them."""
        shutil.copytree(folder, tmp_path / "copy")
        (tmp_path / "copy" / "limits.svg").unlink()
        before = {path.name: path.stat().st_mtime_ns for path in (tmp_path / "copy" / "parts").iterdir()}
        quietly(tmp_path / "copy")
        after = {path.name: path.stat().st_mtime_ns for path in (tmp_path / "copy" / "parts").iterdir()}
        assert {name for name, time in after.items() if time != before[name]} == {"limits.json"}
        assert (tmp_path / "copy" / "limits.svg").exists()

    def test_only_one_stage_after_a_whole_run(self, folder, tmp_path):
        """The results tell of all that is kept, not of what was asked for last."""
        shutil.copytree(folder, tmp_path / "copy")
        found = quietly(tmp_path / "copy", only=["certainty", "splits"])
        told = json.loads((tmp_path / "copy" / "results.json").read_text())
        assert told == found
        assert told.keys() == {stage.name for stage in STAGES if stage.level != "full"} | {"certainty", "splits"}
        assert "Lattice cases" in (tmp_path / "copy" / "results.md").read_text()
        assert found["certainty"]["missed"] == []
        assert found["certainty"]["manoeuvres"] > 1000
        assert len(found["splits"]["best"]["local_models"]) == 2

    def test_levels(self):
        """A level holds the stages of those before it, and the command's default is the pipeline's."""
        names = [{stage.name for stage in pipeline.chosen(level, ())} for level in LEVELS]
        assert names[0] < names[1] < names[2]
        assert names[2] == {stage.name for stage in STAGES}
        assert inspect.signature(study).parameters["level"].default == USUAL_LEVEL
        assert inspect.signature(pipeline.run).parameters["level"].default == USUAL_LEVEL

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
