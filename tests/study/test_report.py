"""The table of results: the study's numbers and the paper's, each in its place; the figures; how files are written."""

import re

import numpy as np
import pytest
from matplotlib.figure import Figure

from gtm_fmu.errors import InputError
from gtm_fmu.files import writable_folder
from study import published
from study.comparisons import SpeedsOverJams
from study.figures import plot_speeds
from study.files import save_figure, write_text
from study.report import markdown


def estimate(value: float) -> dict:
    return {"value": value, "lower": value - 0.01, "upper": value + 0.01}


FACTORS = ("altitude_ft", "gamma_deg", "rudder_lower_deg", "rudder_upper_deg", "rudder_lower_deg,rudder_upper_deg")
RESULTS = {
    "trims": {
        "trims": 211, "same_verdict": 210, "feasible": 137, "largest_difference": 3.21e-9, "stable": 99,
        "uncontrollable": 2,
    },
    "envelopes": {"cases": 1231, "feasible": 1043},
    "networks": {"mse_independent": [4e-4, 1.25e-4, 2e-4, 3e-4], "speeds": {"r_independent": 0.99876}},
    "off_lattice": {
        "cases": 303, "same_verdict": 299, "feasible": 271, "compared": 268, "mse": 0.00717,
        "median_error_kt": [0.31, 1.92], "percentile_95_error_kt": [2.03, 14.14], "largest_error_kt": [3.65, 28.56],
    },
    "off_lattice_test_set": {
        name: {
            "all": {
                "cases": 4321, "mse": mse, "percentile_95_kt": 0.111, "percentile_99_kt": 0.222, "largest_kt": 3.333,
                "same_verdict": 0.9876,
            },
            "inside_95": 0.9512,
        }
        for name, mse in (("thrust map (GtmSurrogate.fmu)", 1.25e-7), ("the paper's networks", 1.5e-3))
    },
    "surrogate_fmu": {"cases": 50, "largest_difference_kt": 1.5e-13},
    "sensitivity": {
        "n_evaluations": 123456,
        "without_envelope": 0.0567,
        "outputs": {
            output: {
                "indices": {
                    factor: {"first": estimate(0.1 + 0.02 * k + shift), "total": estimate(0.5 + 0.02 * k + shift)}
                    for k, factor in enumerate(FACTORS)
                },
                "identities": [{"sum": {"value": 0.9 + shift}}, {"sum": {"value": 0.95}}],
            }
            for output, shift in (("v_min_kt", 0.0), ("v_max_kt", 0.003))
        },
    },
}  # fmt: skip


@pytest.fixture(scope="module")
def rows() -> dict[str, list[str]]:
    """Cells of each row of the tables by the first one."""
    lines = [line.strip("| ").split(" | ") for line in markdown(RESULTS).splitlines() if line.startswith("| ")]
    return {first: cells for first, *cells in lines}


class TestTable:
    @pytest.mark.parametrize(
        ("start", "here", "paper"),
        [
            ("Lattice cases", "1231", "1232"),
            ("of them with an envelope", "1043", "1102"),
            ("Best of 4 networks", "0.000125", "9.43e-05"),
            ("Median of 4 networks", "0.00025", "1e-4"),
            ("R, independent test", "0.99876", "close to 1"),
            ("Its MSE between the lattice's nodes, 268", "0.00717", "not studied"),
            ("Feasibility", "299 of 303", "not studied"),
            ("Error of V_min", "0.31 / 2.03 / 3.65 kn", "not studied"),
            ("Error of V_max", "1.92 / 14.14 / 28.56 kn", "not studied"),
            ("Trims over the FMU", "210 of 211", "-"),
            ("their largest difference", "3.21e-09", "-"),
            ("Stable", "99 of 137", "-"),
            ("Uncontrollable", "2", "Fig. 8"),
            ("Surrogate FMU", "1.5e-13 kn", "-"),
        ],
    )
    def test_row(self, rows, start, here, paper):
        ((ours, theirs),) = [cells for first, cells in rows.items() if first.startswith(start)]
        assert ours == here
        assert paper in theirs

    def test_indices_beside_those_of_table_15(self, rows):
        for output, factors in published.VARIANCE_INDICES.items():
            for factor, known in factors.items():
                ours = RESULTS["sensitivity"]["outputs"][output]["indices"][factor]
                first, paper_first, total, paper_total = rows[f"{output}: {factor}"]
                assert first.startswith(f"{ours['first']['value']:.4f} (")
                assert total.startswith(f"{ours['total']['value']:.4f} (")
                assert (paper_first, paper_total) == (f"{known['first']:.4f}", f"{known['total']:.4f}")

    def test_group_without_published_index(self, rows):
        cells = rows["v_max_kt: rudder_lower_deg, rudder_upper_deg"]
        assert cells == ["0.1830 (0.1730 .. 0.1930)", "-", "0.5830 (0.5730 .. 0.5930)", "-"]

    def test_room_left_by_the_identity(self):
        text = markdown(RESULTS)
        assert "123456 evaluations" in text
        assert "here 0.050 is left" in text  # 1 - 0.95
        assert "5.7% of these cases have no envelope" in text

    def test_it_is_markdown(self):
        widths = [line.count("|") for line in markdown(RESULTS).splitlines() if line.startswith("|")]
        assert set(widths) == {4, 6, 8}
        assert len(re.findall(r"^\| --- \|", markdown(RESULTS), re.MULTILINE)) == 3

    def test_which_model_is_whose(self, rows):
        """What GtmSurrogate carries is told from the paper's networks, each with its errors off the lattice."""
        text = markdown(RESULTS)
        assert "`GtmSurrogate.fmu` carries the thrust map; `rudder_speeds.json` and `rudder_throttle.json` are" in text
        assert "On 4321 random cases" in text
        assert rows["the paper's networks"] == ["0.0015", "0.11", "0.22", "3.33", "98.76%", "95.1%"]


class TestFigures:
    def test_speeds(self):
        exact, emulated = np.array([[70.0, 120], [66, 160], [np.nan] * 2]), np.array([[71.0, 118], [67, 161], [90, 95]])
        figure = plot_speeds(SpeedsOverJams(10000, 0, [-20.0, 0, 28], exact, emulated))
        (axes,) = figure.axes
        assert axes.get_ylabel() == "true airspeed, kn"
        assert axes.get_title() == "10000 ft, $\\gamma$ = 0$\\degree$"
        drawn = {line.get_label(): line for line in axes.lines}
        for end, name in enumerate(("$V_{min}$", "$V_{max}$")):
            np.testing.assert_array_equal(drawn[f"{name} exact"].get_ydata(), exact[:, end])
            np.testing.assert_array_equal(drawn[f"{name} emulated"].get_ydata(), emulated[:, end])
            assert drawn[f"{name} exact"].get_xdata().tolist() == [-20, 0, 28]
            assert drawn[f"{name} emulated"].get_linestyle() == "--"


class TestFiles:
    def test_folder(self, tmp_path):
        assert writable_folder(tmp_path / "a" / "b").is_dir()
        assert not list((tmp_path / "a" / "b").iterdir())
        (tmp_path / "file").touch()
        for path in (tmp_path / "file", tmp_path / "file" / "below"):
            with pytest.raises(InputError, match=r"Cannot write .*choose a folder you may write to"):
                writable_folder(path)

    def test_whole_or_not_at_all(self, tmp_path):
        class Broken(Figure):
            def savefig(self, fname, **_):
                fname.write_text("half")
                raise OSError(28, "No space left on device")

        path = tmp_path / "figure.png"
        write_text("old", path)
        with pytest.raises(InputError, match=r"Cannot write .*figure.png \(No space left on device\)"):
            save_figure(Broken(), path)
        assert path.read_text() == "old"
        assert [found.name for found in tmp_path.iterdir()] == ["figure.png"]

    def test_place_that_is_taken(self, tmp_path):
        (tmp_path / "folder").mkdir()
        (tmp_path / "file").touch()
        for place in ("folder", "file/below", "none/below"):
            with pytest.raises(InputError, match=rf"{place} (\(.*\); choose|is) a folder"):
                write_text("text", tmp_path / place)
        assert sorted(found.name for found in tmp_path.iterdir()) == ["file", "folder"]
