"""People's own tables: foreign stores, names with colons and commas, words as inputs, files that stay."""

import json
import re
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from gtm_fmu.datasets import results
from gtm_fmu.errors import InputError
from surrogate import LocalModelNetwork, Variable, load_model
from surrogate.training.samples import read_samples
from tests.gtm_fmu.datasets.rudder_store import CHUNK, TABLE, fill

pytestmark = pytest.mark.slow

QUICK = ("--method", "lolimot", "--splits", 1)
RNG = np.random.default_rng(0)


@pytest.fixture
def train(ask, tmp_path):
    """Train on a table into model.json."""

    def run(data, inputs, outputs, *options):
        given = [option for name in inputs for option in ("--inputs", name)]
        given += [option for name in outputs for option in ("--outputs", name)]
        options = options or QUICK
        return ask("train", data, *given, *options, "--output", tmp_path / "model.json", "--json")

    return run


def refused(answer, sentence: str) -> None:
    """One sentence, exit code 2."""
    assert (answer.code, answer.out) == (2, "")
    assert re.search(sentence, answer.err), answer.err
    assert "Traceback" not in answer.err


def write(path: Path, columns: dict) -> Path:
    pd.DataFrame(columns).to_csv(path, index=False)
    return path


class TestForeignStores:
    def test_a_row_a_point_of_the_columns_dimensions(self, train, tmp_path):
        """Noise over a, b, c cannot be predicted, whatever else the store holds over a dimension of its own."""
        data = xr.Dataset(
            {"y": (("a", "b", "c"), RNG.normal(size=(3, 4, 5))), "unused": ("station", np.arange(8.0))},
            {"a": np.arange(3.0), "b": np.arange(4.0), "c": np.arange(5.0)},
        )
        data.to_zarr(tmp_path / "noise.zarr", consolidated=False)
        answer = train(tmp_path / "noise.zarr", ["a,b,c"], ["y"], "--method", "lolimot", "--splits", 3)
        assert answer.code == 0
        found = json.loads(answer.out)
        assert found["rows"] == 60
        assert 0.01 < found["mse_independent"] < 0.3
        samples = read_samples(tmp_path / "noise.zarr", ["c", "a", "b"], ["y"])
        for x, [y] in zip(samples.X, samples.Y, strict=True):
            assert data["y"].sel(c=x[0], a=x[1], b=x[2]) == y

    def test_unrelated_columns(self, train, tmp_path):
        values = {name: (name, np.arange(20_000.0)) for name in "pq"}
        xr.Dataset(coords=values).to_zarr(tmp_path / "apart.zarr", consolidated=False)
        answer = train(tmp_path / "apart.zarr", ["p"], ["q"])
        refused(answer, r"'q' and 'p' of '.*apart.zarr' share no dimension \(q; p\): name columns of one lattice")

    def test_what_is_no_number(self, train, tmp_path):
        columns = {
            "when": np.array(["2026-01-01", "2026-01-02"], "M8[ns]"),
            "wave": np.array([1 + 2j, 3.0]),
            "x": np.array([1.0, 2.0]),
        }
        data = xr.Dataset({name: ("row", values) for name, values in columns.items()})
        data.to_zarr(tmp_path / "kinds.zarr", consolidated=False)
        refused(train(tmp_path / "kinds.zarr", ["when"], ["x"]), "'when' holds dates: store it as numbers")
        refused(train(tmp_path / "kinds.zarr", ["x"], ["wave"]), "'wave' holds complex numbers: store it as numbers")
        pd.DataFrame(columns).drop(columns="wave").to_parquet(tmp_path / "kinds.parquet")
        refused(train(tmp_path / "kinds.parquet", ["when"], ["x"]), "'when' holds dates: store it as numbers")

    def test_groups(self, ask, tmp_path):
        data = xr.Dataset({"x": ("row", RNG.uniform(size=40))}).assign(y=lambda d: 2 * d.x)
        data.to_zarr(tmp_path / "outer.zarr", group="run 1", consolidated=False)
        columns = ["--inputs", "x", "--outputs", "y", *QUICK, "--output", tmp_path / "m.json"]
        refused(
            ask("train", tmp_path / "outer.zarr", *columns), "holds no arrays at its top: give the folder of a group"
        )
        assert ask("train", tmp_path / "outer.zarr" / "run 1", *columns).code == 0

    def test_prediction(self, train, ask, tmp_path):
        """All columns that have a value a row come along."""
        data = xr.Dataset(
            {"y": (("a", "b"), RNG.normal(size=(6, 7))), "of_a": ("a", np.arange(6)), "of_s": ("s", np.arange(3))},
            {"a": np.arange(6.0), "b": np.arange(7.0)},
        )
        data.to_zarr(tmp_path / "data.zarr", consolidated=False)
        assert train(tmp_path / "data.zarr", ["a,b"], ["y"]).code == 0
        asked = ["predict", tmp_path / "model.json", "--data", tmp_path / "data.zarr", "--output", tmp_path / "p.csv"]
        assert ask(*asked).code == 0
        found = pd.read_csv(tmp_path / "p.csv")
        assert (len(found), "of_s" in found) == (42, False)
        np.testing.assert_array_equal(found["y"], data["y"].values.ravel())
        np.testing.assert_array_equal(found["of_a"], found["a"])
        shutil.rmtree(tmp_path / "data.zarr" / "y")
        refused(ask(*asked), r"'b' and 'a' of .* share no dimension")


class TestUnfinishedDataSets:
    @pytest.fixture
    def found(self):
        return results.evaluate(TABLE.rows(0, len(TABLE)))

    def test_rows_are_not_dropped(self, ask, tmp_path, found):
        store = fill(tmp_path / "part.zarr", found, range(CHUNK))
        answer = ask("train", store, *QUICK, "--output", tmp_path / "m.json")
        refused(answer, "is not finished: 4 of 6 cases are there; give the command that made it once more")

    @pytest.mark.parametrize(("name", "sentence"), [("v_max", "is damaged at cases"), ("finished", "2 of 6 cases")])
    def test_a_lost_chunk(self, ask, tmp_path, found, name, sentence):
        store = fill(tmp_path / "lost.zarr", found)
        (store / name / "c" / "0").unlink()
        refused(ask("train", store, *QUICK, "--output", tmp_path / "m.json"), sentence)


class TestNames:
    def test_the_whole_name_wins(self, tmp_path):
        """Colons of OpenMDAO's paths, commas, and a unit after either."""
        names = ["data:geometry:wing:span", "data:geometry", "lift, total", "x:m", "x"]
        path = write(tmp_path / "t.csv", {name: np.arange(3.0) * k for k, name in enumerate(names, start=1)})
        samples = read_samples(path, ["data:geometry:wing:span,data:geometry:m", "x:m"], ["lift, total:N", "x"])
        assert samples.inputs == (("data:geometry:wing:span", ""), ("data:geometry", "m"), ("x:m", ""))
        assert samples.outputs == (("lift, total", "N"), ("x", ""))
        np.testing.assert_array_equal(samples.X[1], [1, 2, 4])
        np.testing.assert_array_equal(samples.Y[1], [3, 5])
        with pytest.raises(
            InputError, match="has no column 'data:geometry:wing:spam': it has data:geometry:wing:span,"
        ):
            read_samples(path, ["data:geometry:wing:spam"], ["x"])

    def test_command(self, train, ask, tmp_path):
        x = np.linspace(0, 1, 40)
        table = write(tmp_path / "t.csv", {"a:b,c": x, "d": x**2, "lift, total": x})
        assert train(table, ["a:b,c:m", "d"], ["lift, total:N"]).code == 0
        model = load_model(tmp_path / "model.json")
        assert (model.inputs, model.outputs) == ((("a:b,c", "m"), ("d", "")), (("lift, total", "N"),))
        answer = ask("predict", tmp_path / "model.json", "--at", "a:b,c=0.5", "--at", "d=0.25", "--json")
        assert answer.json["lift, total"] == pytest.approx(0.5, abs=0.05)

    @pytest.mark.parametrize(
        ("inputs", "outputs", "sentence"),
        [
            ("x", "lift,lift_std", "'lift_std' is what a model calls the standard deviation of 'lift': rename"),
            ("x,lift_std", "lift", "'lift_std' is what a model calls the standard deviation of 'lift': rename"),
            ("x", "in_domain", "'in_domain' is what a model calls whether a case lies in the training data: rename"),
            ("x:\udcff", "lift", r"'\\udcff' is the name or unit of a variable, but is no text"),
        ],
    )
    def test_names_of_results_are_kept(self, train, tmp_path, inputs, outputs, sentence):
        columns = {name: RNG.uniform(size=40) for name in ("x", "lift", "lift_std", "in_domain")}
        refused(train(write(tmp_path / "t.csv", columns), [inputs], [outputs]), sentence)

    def test_halves_of_characters(self, ask, tmp_path, linear):
        """In no model, and in no file of one."""
        for part in ("inputs", "outputs"):
            with pytest.raises(ValueError, match="is no text: give another one"):
                replace(linear, **{part: (Variable("\ud800", "m"),)})
        linear.save(tmp_path / "m.json")
        text = (tmp_path / "m.json").read_text().replace('["x",', '["\\ud800",')
        (tmp_path / "m.json").write_text(text)
        for form in ("--latex", "--fmu", "--c", "--json"):
            answer = ask("export", tmp_path / "m.json", form, "--output", tmp_path / "m.fmu")
            assert (answer.code, "Traceback" in answer.err) == (2, False)


class TestWords:
    """A column of words is an input for each level."""

    @pytest.fixture
    def flights(self, train, tmp_path):
        """Speed falls by 30 with the damage 'wing', by 10 with 'tail = half'."""
        damage = np.array(["none", "wing", "tail = half"])[np.arange(90) % 3]
        x = RNG.uniform(0, 10, 90)
        speed = 100 + x - 30.0 * (damage == "wing") - 10.0 * (damage == "tail = half")
        table = write(tmp_path / "flights.csv", {"x": x, "damage_case": damage, "speed": speed})
        assert train(table, ["x,damage_case"], ["speed"], "--method", "hilomot", "--splits", 1).code == 0
        return tmp_path / "model.json"

    def test_case(self, flights, ask):
        names = [name for name, _ in load_model(flights).inputs]
        assert names == ["x", "damage_case=none", "damage_case=tail = half", "damage_case=wing"]
        for damage, speed in (("none", 105), ("wing", 75), ("tail = half", 95)):
            answer = ask("predict", flights, "--at", "x=5", "--at", f"damage_case={damage}", "--json")
            assert answer.json["speed"] == pytest.approx(speed, abs=0.5)
            assert answer.json["in_domain"] is True
        answer = ask("predict", flights, "--at", "x=5", "--at", "damage_case=rudder")
        refused(answer, "the levels of damage_case are none, tail = half, wing")

    def test_table(self, flights, ask, tmp_path):
        asked = {"damage_case": ["wing", "none"], "x": [0.5, 9.0]}
        table = write(tmp_path / "asked.csv", asked)
        answer = ask("predict", flights, "--data", table, "--output", tmp_path / "found.csv")
        assert answer.code == 0
        np.testing.assert_allclose(pd.read_csv(tmp_path / "found.csv")["speed"], [70.5, 109], atol=0.5)
        for damage, sentence in (
            ("rudder", "Row 2 .* has the damage_case 'rudder', but the model learnt none, tail"),
            (None, "Row 2 .* has nothing for 'damage_case': fill it in"),
        ):
            write(table, asked | {"damage_case": ["wing", damage]})
            refused(ask("predict", flights, "--data", table, "--output", tmp_path / "found.csv"), sentence)

    def test_too_many_and_mixed(self, tmp_path):
        columns = {"id": [f"n{k}" for k in range(40)], "mixed": ["1.5", "n/s"] * 20, "y": np.arange(40.0)}
        path = write(tmp_path / "t.csv", columns)
        with pytest.raises(InputError, match=r"'id' holds words, of which an input has 2 to 32 .*, but these are 40"):
            read_samples(path, ["id"], ["y"])
        with pytest.raises(InputError, match="'mixed' holds numbers and words: correct it"):
            read_samples(path, ["mixed"], ["y"])


@pytest.fixture(scope="module")
def linear(tmp_path_factory) -> LocalModelNetwork:
    """Lift = 2 x."""
    from surrogate import train_local_models

    x = np.linspace(0.0, 1.0, 30)[:, None]
    rows = np.arange(30)
    return train_local_models(
        x,
        2 * x,
        inputs=(Variable("x", "m"),),
        outputs=(Variable("lift", "N"),),
        rows=rows,
        validation_rows=rows,
        algorithm="lolimot",
    )[0]


class TestNothingIsReplaced:
    @pytest.fixture(autouse=True)
    def here(self, tmp_path, monkeypatch, linear):
        """A model and a table that has measured what it predicts."""
        monkeypatch.chdir(tmp_path)
        linear.save(tmp_path / "wing.json")
        write(tmp_path / "wing.csv", {"x": [0.25, 0.5], "lift": [7.0, 8.0]})

    def test_measurements(self, ask):
        assert ask("predict wing.json --data wing.csv --output found.csv").code == 0
        found = pd.read_csv("found.csv")
        assert found["lift"].tolist() == [7.0, 8.0]
        np.testing.assert_allclose(found["lift_predicted"], [0.5, 1.0], atol=1e-6)
        refused(ask("predict wing.json --data found.csv --output more.csv"), "columns of an earlier prediction")

    @pytest.mark.parametrize(
        "command",
        [
            "predict wing.json --data wing.csv --output wing.csv",
            "predict wing.json --data wing.csv --output ./link.csv",
            "predict wing.json --data wing.csv --output hard.csv",
            "predict --data wing.csv --output wing.csv",
            "train wing.csv --inputs x --outputs lift --output wing.csv",
            "train wing.csv --inputs x --outputs lift --output link.csv",
            "export wing.json --text --output wing.json",
            "export wing.json --latex --output ../{folder}/wing.json",
        ],
    )
    def test_what_is_read(self, ask, command):
        Path("link.csv").symlink_to("wing.csv")
        Path("hard.csv").hardlink_to("wing.csv")
        before = {name: Path(name).read_bytes() for name in ("wing.csv", "wing.json")}
        refused(ask(command.format(folder=Path.cwd().name)), "is read by this command and is kept; name another file")
        assert {name: Path(name).read_bytes() for name in before} == before

    def test_into_a_store_that_is_read(self, ask):
        xr.Dataset({"x": ("row", [0.1])}).to_zarr("data.zarr", consolidated=False)
        answer = ask("predict wing.json --data data.zarr --output data.zarr/x/found.csv")
        refused(answer, "is read by this command and is kept")

    def test_header_of_another(self, ask):
        Path("wing.h").write_text("#define MINE 1\n")
        refused(ask("export wing.json --c --output wing.c"), "wing.h would be replaced .* choose another name")
        assert (Path("wing.h").read_text(), Path("wing.c").exists()) == ("#define MINE 1\n", False)
        for _ in range(2):  # an export's own is replaced
            assert ask("export wing.json --c --output lift.c").code == 0
            Path("lift.c").write_text("")

    def test_missing_numbers_are_named(self, ask):
        write(Path("gaps.csv"), {"x": [0.1, np.nan, 0.3]})
        refused(ask("predict wing.json --data gaps.csv --output found.csv"), "Row 2 of 'gaps.csv' has nan for 'x'")
