"""The table of results: the study's numbers and the paper's, each in its place; the figures; how files are written."""

import re

import numpy as np
import pytest
from matplotlib.figure import Figure

from gtm_fmu.errors import InputError
from gtm_fmu.files import writable_folder
from gtm_study.files import save_figure, write_text
from gtm_study.paper import published
from gtm_study.paper.comparisons import SpeedsOverJams
from gtm_study.paper.figures import plot_speeds
from gtm_study.paper.report import study_report


def estimate(value: float) -> dict:
    return {"value": value, "lower": value - 0.01, "upper": value + 0.01}


def answer(outputs: tuple[str, ...], shift: float) -> dict:
    """Indices that rise from factor to factor, by steps of 0.02 from 0.1 (first) and 0.5 (total)."""
    return {
        output: {
            "indices": {
                factor: {"first": 0.1 + 0.02 * k + shift + 0.003 * j, "total": 0.5 + 0.02 * k + shift + 0.003 * j}
                for k, factor in enumerate(FACTORS)
            }
        }
        for j, output in enumerate(outputs)
    }


def off_lattice_scores(mse: float) -> dict:
    whole = {
        "cases": 4321, "mse": mse, "percentile_95_kt": 0.111, "percentile_99_kt": 0.222, "largest_kt": 3.333,
        "same_verdict": 0.9876,
    }  # fmt: skip
    return {"all": whole, "inside_95": 0.9512}


SPEEDS = ("v_min_kt", "v_max_kt")
FACTORS = ("altitude_ft", "gamma_deg", "rudder_lower_deg", "rudder_upper_deg", "rudder_lower_deg,rudder_upper_deg")
RESULTS = {
    "trims": {
        "trims": 211, "same_verdict": 210, "feasible": 137, "largest_difference": 3.21e-9, "stable": 99,
        "uncontrollable": 2,
    },
    "lattice": {"cases": 1231, "feasible": 1043},
    "networks": {
        "mse_independent": [4e-4, 1.25e-4, 2e-4, 3e-4], "speeds": {"r_independent": 0.99876},
        "off_lattice": off_lattice_scores(1.5e-3),
    },
    "surrogate-fmu": {"cases": 50, "largest_difference_kt": 1.5e-13, "off_lattice": off_lattice_scores(1.25e-7)},
    "sensitivity": {
        "cells": {"altitude": 7, "gamma": 8, "rudder": 9},
        "finer_cells": {"altitude": 11, "gamma": 12, "rudder": 13},
        "without_envelope": 0.0567,
        "questions": {
            "as in the paper": {
                "answers": {"exact": answer(SPEEDS, 0.0), "thrust map": answer(SPEEDS, 0.001)},
                "own_error": {"thrust map": 0.00123}, "cells_error": 0.00456,
            },
            "whether": {
                "answers": {"exact": answer(("has_envelope",), 0.2), "thrust map": answer(("has_envelope",), 0.25)},
                "own_error": {"thrust map": 0.00234}, "cells_error": 0.00567,
            },
        },
        "failures": {
            "controls": {
                "n_evaluations": 123456,
                "least_surfaces": {"has_envelope": ["rudder", "aileron"]},
                "outputs": {
                    "has_envelope": {
                        "mean": 0.2345, "indices": {"engine_out": {"first": estimate(0.31), "total": estimate(0.72)}},
                    },
                },
            },
        },
    },
}  # fmt: skip


@pytest.fixture(scope="module")
def rows() -> dict[str, list[str]]:
    """Cells of each row of the tables by the first one."""
    lines = [line.strip("| ").split(" | ") for line in study_report(RESULTS).splitlines() if line.startswith("| ")]
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

    @pytest.fixture
    def tables(self) -> list[list[list[str]]]:
        """Cells of every table, the heads first."""
        blocks = re.findall(r"(?:^\|.*\n)+", study_report(RESULTS), re.MULTILINE)
        return [[line.strip("| ").split(" | ") for line in block.splitlines()] for block in blocks]

    def test_indices_beside_those_of_table_15(self, tables):
        for (heads, _, *lines), kind, least in zip(tables[2:4], ("first", "total"), (0.1, 0.5), strict=True):
            assert heads[1:] == ["exact", "thrust map", "paper"]
            rows = {name: cells for name, *cells in lines}
            for j, (output, factors) in enumerate(sorted(published.VARIANCE_INDICES.items(), reverse=True)):
                assert output == SPEEDS[j]
                for k, (factor, known) in enumerate(factors.items()):
                    ours = least + 0.02 * k + 0.003 * j
                    assert rows[f"{output}: {factor}"] == [f"{ours:.3f}", f"{ours + 0.001:.3f}", f"{known[kind]:.4f}"]

    def test_group_without_published_index(self, tables):
        assert ["v_max_kt: rudder_lower_deg, rudder_upper_deg", "0.183", "0.184", "-"] in tables[2]

    def test_whether_there_is_an_envelope(self, tables):
        assert ["has_envelope: gamma_deg", "0.320", "0.370"] in tables[4]

    def test_errors_are_told_apart(self):
        """A surrogate's own, what the cells do, and sampling."""
        text = study_report(RESULTS)
        assert "of the thrust map 0.0012. With 11 x 12 x 13 cells" in text
        assert "no index moves by more than 0.0057" in text
        assert "sums over 7 x 8 x 9 cells" in text
        assert "5.7% of the cases have no envelope" in text
        assert "The 95 % intervals are of the sampling; there is no surrogate" in text

    def test_everything_that_may_fail(self, tables):
        text = study_report(RESULTS)
        assert "Controls: 123456 exact envelopes, 23% of the cases have one" in text
        assert "matter least (S^T): rudder (not told apart from aileron) for has_envelope." in text
        assert tables[-1][-1] == ["has_envelope: engine_out", "0.310 (0.300 .. 0.320)", "0.720 (0.710 .. 0.730)"]

    def test_it_is_markdown(self):
        widths = [line.count("|") for line in study_report(RESULTS).splitlines() if line.startswith("|")]
        assert set(widths) == {4, 5, 8}
        assert len(re.findall(r"^\| --- \|", study_report(RESULTS), re.MULTILINE)) == 7

    def test_which_model_is_whose(self, rows):
        """What GtmSurrogate carries is told from the paper's networks, each with its errors off the lattice."""
        text = study_report(RESULTS)
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
