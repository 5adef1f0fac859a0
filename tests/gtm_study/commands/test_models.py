"""`gtm-fmu train`, `predict` and `export` on a table that is not the aircraft's, and on the aircraft's."""

import ctypes
import json
import shutil
import subprocess

import numpy as np
import pandas as pd
import pytest

from gtm_fmu.aircraft.client import FmuClient
from gtm_fmu.datasets import lattice as dataset
from gtm_fmu.datasets import results
from gtm_fmu.datasets.store import CaseStore
from gtm_fmu.units import M_S_PER_KT
from gtm_study.commands.cli import main
from surrogate import LocalModelNetwork, Network, load_model
from surrogate.rudder.emulator import INPUTS, SPEEDS
from surrogate.training.samples import read_samples

pytestmark = pytest.mark.slow

COLUMNS = ["--inputs", "span_mm,alpha_deg", "--outputs", "lift:N,drag"]
ROWS = 240


def table() -> pd.DataFrame:
    """Lift and drag of a wing; one row without lift, one column that is not of numbers."""
    rng = np.random.default_rng(0)
    span, alpha = rng.uniform(500, 2000, ROWS), rng.uniform(-5, 12, ROWS)
    lift = 0.07 * span * np.tanh((alpha + 2) / 8)
    values = {"span_mm": span, "alpha_deg": alpha, "lift": lift, "drag": 1 + (lift / 50) ** 2, "wing": "a"}
    frame = pd.DataFrame(values)
    frame.loc[3, "lift"] = np.nan
    return frame


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The table in both forms, and one of its models."""
    path = tmp_path_factory.mktemp("wing")
    table().to_csv(path / "wing.csv", index=False)
    table().to_parquet(path / "wing.parquet")
    return path


@pytest.fixture
def command(capsys, monkeypatch):
    """Run `gtm-fmu` with some arguments: exit code, standard output, standard error."""

    def run(*arguments):
        monkeypatch.setattr("sys.argv", ["gtm-fmu", *map(str, arguments)])
        with pytest.raises(SystemExit) as ended:
            main()
        printed = capsys.readouterr()
        return ended.value.code or 0, printed.out, printed.err

    return run


@pytest.fixture(scope="module")
def trained(folder):
    """A small network with standard deviations, trained by the command."""
    options = ["--hidden", "4", "--splits", "2", "--seed", "5", "--output", folder / "wing.json"]
    arguments = ["train", folder / "wing.csv", *COLUMNS, *options]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("sys.argv", ["gtm-fmu", *map(str, arguments)])
        with pytest.raises(SystemExit, match="0"):
            main()
    return folder / "wing.json"


class TestTrain:
    def test_model_file(self, trained):
        model = load_model(trained)
        assert isinstance(model, Network)
        assert model.inputs == (("span_mm", "mm"), ("alpha_deg", "deg"))
        assert model.outputs == (("lift", "N"), ("drag", ""))
        assert model.sizes == (2, 4, 2)
        whole = table().drop(columns="wing").dropna()
        for ranges, names in ((model.input_ranges, ["span_mm", "alpha_deg"]), (model.target_ranges, ["lift", "drag"])):
            np.testing.assert_array_equal(ranges, whole[names].agg(["min", "max"]).T)
        facts = model.provenance
        assert (facts["rows"], facts["rows_left_out"], facts["seed"], facts["splits"]) == (ROWS - 1, 1, 5, 2)
        assert {"gtm-fmu", "numpy", "torch", "python"} <= facts["versions"].keys()
        assert (
            facts["data_sha256"]
            == read_samples(trained.with_name("wing.csv"), ["span_mm", "alpha_deg"], ["lift:N", "drag"]).sha256()
        )

    def test_it_has_learnt(self, trained):
        """Errors on rows that no training saw, and on the function itself."""
        model, wing = load_model(trained), table().dropna()
        assert model.metrics["mse_independent"] < 1e-4
        errors = model.predict(wing[["span_mm", "alpha_deg"]]) - wing[["lift", "drag"]]
        assert (np.sqrt((errors**2).mean()) < 0.02 * np.ptp(wing[["lift", "drag"]], axis=0)).all()

    def test_same_seed_gives_the_same_bytes(self, trained, folder, command):
        again = folder / "again.json"
        options = ["--hidden", "4", "--splits", "2", "--output", again]
        for source, seed, is_same in (("wing.parquet", 5, True), ("wing.csv", 6, False)):
            code, printed, _ = command("train", folder / source, *COLUMNS, *options, "--seed", seed, "--json")
            assert code == 0
            assert json.loads(printed)["rows_left_out"] == 1
            assert (again.read_bytes() == trained.read_bytes()) is is_same

    def test_safe_values(self, folder, command, tmp_path):
        """Half of the rows are held back; `predict` gives the safe values of a case and of a table, and the promise."""
        wing, model = folder / "wing.csv", tmp_path / "safe.json"
        options = ["--method", "lolimot", "--splits", "1", "--output", model, "--json"]
        safe = ["--calibrate", 0.5, "--epsilon", 0.05, "--never-high", "lift", "--never-low", "drag"]
        code, printed, _ = command("train", wing, *COLUMNS, *options, *safe)
        assert code == 0
        shift = json.loads(printed)["safe_shift lift [N]"]
        assert shift < 0
        code, printed, _ = command("predict", model, "--at", "span_mm=900", "--at", "alpha_deg=2", "--json")
        found = json.loads(printed)
        assert found["lift_safe"] == pytest.approx(found["lift"] + shift)
        assert found["drag_safe"] > found["drag"]
        assert "lift_safe is not above the true one with a probability of at least 0.95" in found["promise"]
        table_of = tmp_path / "answers.csv"
        assert command("predict", model, "--data", wing, "--output", table_of)[0] == 0
        answers = pd.read_csv(table_of)
        moved = answers["lift_safe"] - answers["lift_predicted"]
        np.testing.assert_allclose(moved, shift, rtol=1e-9)
        few = ["--calibrate", 0.5, "--never-high", "lift"]
        for wrong, sentence in (
            (few, f"holds {round((ROWS - 1) / 2)} of {ROWS - 1} different rows back, but epsilon = 0.001 needs 999"),
            ([*few, "--never-low", "lift,drag"], "An output was given twice"),
            (["--never-low", "drag"], "are for --calibrate"),
            (["--calibrate", "half"], "is not a number"),
        ):
            code, printed, told = command("train", wing, *COLUMNS, *options, *wrong)
            assert (code, printed) == (2, "")
            assert sentence in told

    @pytest.mark.parametrize("method", ["lm", "lolimot", "hilomot"])
    def test_methods(self, folder, command, method, tmp_path):
        options = ["--method", method, "--splits", "2", "--hidden", "4,3", "--output", tmp_path / "m.json", "--json"]
        code, printed, _ = command("train", folder / "wing.csv", *COLUMNS, *options)
        assert code == 0
        told = json.loads(printed)
        assert told["mse_independent"] < 1e-3
        assert told["r2_independent lift"] > 0.99
        assert 0 < told["rmse_independent lift [N]"] < 0.05 * np.ptp(table()["lift"].dropna())
        assert told["rmse_independent drag"] > 0
        model = load_model(tmp_path / "m.json")
        assert isinstance(model, Network if method == "lm" else LocalModelNetwork)
        assert method != "lm" or model.sizes == (2, 4, 3, 2)

    def test_data_sets_of_the_aircraft(self, command, tmp_path):
        """A store of `gtm-fmu dataset` and arrays over its axes: the same columns, and none need be named."""
        jams = [(float(d), float(d)) for d in range(-5, 6)]
        cases = dataset.lattice((0.0, 9000.0), (-1.0, 1.0), jams)
        CaseStore(tmp_path / "store.zarr", cases, {}).write(
            range(len(cases)), results.evaluate(cases.rows(0, len(cases)))
        )
        dataset.view(tmp_path / "store.zarr").to_zarr(tmp_path / "lattice.zarr", consolidated=False)
        models = []
        for name in ("lattice", "store"):
            options = ["--method", "lolimot", "--splits", 1, "--output", tmp_path / "m.json"]
            assert command("train", tmp_path / f"{name}.zarr", *options)[0] == 0
            models.append(load_model(tmp_path / "m.json"))
            assert (models[-1].inputs, models[-1].outputs) == (INPUTS, SPEEDS)
        assert models[0].provenance["data_sha256"] == models[1].provenance["data_sha256"]
        shutil.rmtree(tmp_path / "store.zarr" / "v_max" / "c")  # lost chunks would read as NaN
        code, _, error = command("train", tmp_path / "store.zarr", "--output", tmp_path / "m.json")
        assert code == 2
        assert "the values are not those that were written" in error

    @pytest.mark.parametrize(
        ("arguments", "sentence"),
        [
            (["wing.csv", "--inputs", "span_mm"], "give both, or none"),
            (["wing.csv"], "has no column 'altitude_ft': it has span_mm, alpha_deg"),
            (
                ["wing.csv", "--inputs", "span_mm,wing", "--outputs", "lift"],
                "'wing' holds words, .* has 2 to 32 .* these are 1:",
            ),
            (["wing.csv", "--inputs", "span_mm", "--outputs", "wing"], "'wing' holds more than numbers"),
            (["wing.csv", "--inputs", "span_mm", "--outputs", "span_mm"], "given twice"),
            (["wing.csv", "--inputs", ",", "--outputs", "lift"], "name at least one column of each"),
            (["wing.csv", *COLUMNS, "--hidden", "4,x"], "give numbers of neurons"),
            (["wing.csv", *COLUMNS, "--splits", "0"], "--splits"),
            (["wing.csv", *COLUMNS, "--splits", "1000000000"], "splits is 1000000000, but must be"),
            (["wing.csv", *COLUMNS, "--hidden", "0"], "hidden is .0,., but must be a whole number"),
            (["wing.csv", *COLUMNS, "--hidden", "999999999"], "hidden is .999999999,., but must be"),
            (["wing.csv", *COLUMNS, "--hidden", ",".join(["4"] * 201)], "at most 20 hidden layers"),
            (["wing.csv", *COLUMNS, "--hidden", "10000,10000"], "GiB for normal matrices"),
            (["wing.csv", *COLUMNS, "--hidden", "9" * 400], "hidden is .9+ ..., but must be"),
            (["wing.csv", *COLUMNS, "--hidden", "9" * 5000], "--hidden was given as"),
            (["wing.csv", *COLUMNS, "--device", "gpu"], "torch cannot use the device 'gpu'"),
            (["wing.csv", *COLUMNS, "--device", "privateuseone"], "torch cannot use the device 'privateuseone'"),
            (["wing.csv", *COLUMNS, "--device", "abacus"], "torch cannot use the device 'abacus'"),
            (["wing.csv", *COLUMNS, "--device", "meta"], "torch cannot use the device 'meta'"),
            (["wing.csv", *COLUMNS, "--method", "magic"], "--method"),
            (["absent.csv", *COLUMNS], "Cannot read .*No such file"),
            (["wing.txt", *COLUMNS], "give one ending in .csv, .parquet, .zarr"),
            (["bad.parquet", *COLUMNS], "Cannot read"),
            (["few.csv", *COLUMNS], "give more samples"),
        ],
    )
    def test_bad_input(self, folder, command, tmp_path, arguments, sentence):
        (folder / "bad.parquet").write_text("nothing")
        table().head(3).to_csv(folder / "few.csv")
        code, printed, error = command("train", folder / arguments[0], *arguments[1:], "--output", tmp_path / "m.json")
        assert (code, printed) == (2, "")
        assert pd.Series([error.splitlines()[-1]]).str.contains(sentence, regex=True).all(), error
        assert list(tmp_path.iterdir()) == []

    def test_a_folder_is_no_file(self, folder, command, tmp_path):
        code, _, error = command("train", folder / "wing.csv", *COLUMNS, "--output", tmp_path)
        assert code == 2
        assert "is a folder; name a file in it." in error

    def test_too_many_neurons_are_refused(self, folder, command, tmp_path, monkeypatch):
        def greedy(*_, **__):
            raise RuntimeError("DefaultCPUAllocator: can't allocate memory: you tried to allocate 1280006400008 bytes.")

        monkeypatch.setattr("surrogate.training.train.train_networks", greedy)
        code, _, error = command("train", folder / "wing.csv", *COLUMNS, "--output", tmp_path / "m.json")
        assert code == 2
        assert "too much memory: take fewer" in error


class TestPredict:
    def test_one_case(self, trained, command):
        code, printed, _ = command("predict", trained, "--at", "alpha_deg=3", "--at", "span_mm=1000", "--json")
        assert code == 0
        model, found = load_model(trained), json.loads(printed)
        assert [found["lift"], found["drag"]] == model.predict([1000, 3]).tolist()
        assert [found["lift_std"], found["drag_std"]] == model.predict_std([1000, 3]).tolist()
        assert found["in_domain"] is True
        code, printed, _ = command("predict", trained, "--at", "alpha_deg=3", "--at", "span_mm=10", "--json")
        assert json.loads(printed)["in_domain"] is False

    def test_table(self, trained, folder, command, tmp_path):
        code, _, _ = command("predict", trained, "--data", folder / "wing.csv", "--output", tmp_path / "found.csv")
        assert code == 0
        found, wing = pd.read_csv(tmp_path / "found.csv"), table()
        expected = load_model(trained).predict(wing[["span_mm", "alpha_deg"]])
        np.testing.assert_allclose(found[["lift_predicted", "drag_predicted"]], expected, rtol=1e-15)
        pd.testing.assert_frame_equal(found[wing.columns], pd.read_csv(folder / "wing.csv"))  # what was measured stays
        assert found["in_domain"].tolist() == load_model(trained).in_range(wing[["span_mm", "alpha_deg"]]).tolist()

    def test_rudder_of_the_package(self, command):
        code, printed, _ = command("predict", "--altitude-ft", 10000, "--rudder-deg", -10, 20, "--json")
        assert code == 0
        assert set(json.loads(printed)) >= {
            "feasible",
            "in_domain",
            "v_min_kt",
            "v_max_kt",
            "v_min_std_kt",
            "v_max_std_kt",
        }

    @pytest.mark.parametrize(
        ("arguments", "sentence"),
        [
            ([], "Missing option '--altitude-ft'"),
            (["--altitude-ft", "0", "--at", "a=1"], "for a model of your own"),
            (["MODEL", "--altitude-ft", "0"], "unexpected extra argument"),
            (["MODEL", "--gamma-deg", "0", "--at", "a=1"], "unexpected extra argument"),
            (["MODEL"], "--at gives nothing: give one for each of span_mm, alpha_deg"),
            (["MODEL", "--at", "span_mm"], "give NAME=VALUE, for instance span_mm=1"),
            (["MODEL", "--at", "span_mm=1", "--at", "alpha_deg=nan"], "not finite"),
            (["MODEL", "--at", "span_mm=1", "--at", "span_mm=2"], "give each input once"),
            (["MODEL", "--data", "wing.csv"], "give --data and --output"),
            (["MODEL", "--at", "span_mm=1", "--at", "alpha_deg=1", "--output", "x.csv"], "give --data and --output"),
            (["MODEL", "--data", "MODEL", "--output", "x.csv"], "no table that can be read"),
            (["absent.json", "--at", "span_mm=1"], "cannot read the model file"),
        ],
    )
    def test_bad_input(self, trained, command, arguments, sentence):
        given = [trained if argument == "MODEL" else argument for argument in arguments]
        code, printed, error = command("predict", *given)
        assert (code, printed) == (2, "")
        assert sentence in error


class TestExport:
    def test_every_form(self, trained, command, tmp_path):
        for form in ("c", "js", "numpy", "onnx", "onnx32", "latex", "text", "json"):
            code, printed, _ = command("export", trained, f"--{form}", "--output", tmp_path / f"wing.{form}")
            assert (code, printed.strip()) == (0, str(tmp_path / f"wing.{form}"))
            assert (tmp_path / f"wing.{form}").stat().st_size > 500

    def test_without_standard_deviations(self, trained, command, tmp_path):
        whole, part = tmp_path / "whole.c", tmp_path / "part.c"
        assert command("export", trained, "--c", "--output", whole)[0] == 0
        assert command("export", trained, "--c", "--without-std", "--output", part)[0] == 0
        assert "whole_std" in whole.read_text()
        assert "#define part_has_std 0" in part.with_suffix(".h").read_text()
        assert "part_std(" not in part.read_text()

    def test_c_runs(self, trained, command, tmp_path):
        command("export", trained, "--c", "--output", tmp_path / "wing.c")
        flags = ["-std=c99", "-shared", "-fPIC", "-o", "wing.so", "wing.c", "-lm"]
        subprocess.run(["cc", *flags], cwd=tmp_path, check=True)
        y = (ctypes.c_double * 2)()
        ctypes.CDLL(str(tmp_path / "wing.so")).wing_predict((ctypes.c_double * 2)(1000, 3), y)
        np.testing.assert_allclose(list(y), load_model(trained).predict([1000, 3]), rtol=1e-12)

    def test_fmu_runs(self, trained, command, tmp_path):
        assert command("export", trained, "--fmu", "--output", tmp_path / "wing.fmu")[0] == 0
        with FmuClient(tmp_path / "wing.fmu") as fmu:
            fmu.set(("span_mm", "alpha_deg"), [1000, 3])
            np.testing.assert_allclose(fmu.get(("lift", "drag")), load_model(trained).predict([1000, 3]), rtol=1e-12)

    def test_native_surrogate_of_a_study(self, command, tmp_path):
        code, printed, _ = command("build", "surrogate-native", "--output", tmp_path, "--json")
        assert code == 0
        with FmuClient(json.loads(printed)["fmus"][0]) as fmu:
            v_min = fmu.get(("v_min",))[0] / M_S_PER_KT
        predicted = json.loads(command("predict", "--altitude-ft", 10000, "--json")[1])
        assert v_min == pytest.approx(predicted["v_min_kt"], rel=1e-12)

    @pytest.mark.parametrize(
        ("arguments", "sentence"),
        [
            (["MODEL", "--output", "x"], "0 forms were chosen: give one of --fmu, --fmu3, --c"),
            (["MODEL", "--c", "--js", "--output", "x"], "2 forms were chosen"),
            (["MODEL", "--c", "--all-platforms", "--output", "x"], "--all-platforms is for an FMU"),
            (["MODEL", "--fmu", "--output", "my wing.fmu"], "choose letters, digits and _"),
            (["MODEL", "--c", "--output", "my wing.c"], "choose letters, digits and _, and the ending .c"),
            (["MODEL", "--c", "--output", "absent/folder/x.c"], "choose a folder you may write to"),
            (["DAMAGED", "--c", "--output", "x"], "is damaged"),
            (["FOREIGN", "--c", "--output", "x"], "holds no model"),
        ],
    )
    def test_bad_input(self, trained, command, tmp_path, monkeypatch, arguments, sentence):
        monkeypatch.chdir(tmp_path)
        (tmp_path / "damaged.json").write_text(trained.read_text().replace("0.1", "0.2"))
        (tmp_path / "foreign.json").write_text("{}")
        files = {"MODEL": trained, "DAMAGED": "damaged.json", "FOREIGN": "foreign.json"}
        code, printed, error = command("export", *(files.get(argument, argument) for argument in arguments))
        assert (code, printed) == (2, "")
        assert sentence in error
        assert sorted(path.name for path in tmp_path.iterdir()) == ["damaged.json", "foreign.json"]
