"""Figures of one envelope: what they show comes from the grid and the boundary, and both files can be opened."""

import json

import numpy as np
import pytest

from gtm_fmu.envelope import FlightCondition
from gtm_fmu.errors import InputError
from gtm_fmu.failures import ControlLimits
from gtm_fmu.grid import envelope_grid
from study.envelope_figures import LIMIT_COLOURS, envelope_page, plot_envelope, save_envelope


@pytest.fixture(scope="module")
def envelope():
    condition = FlightCondition(10000.0, -5.0, ControlLimits(rudder_deg=(5.0, 25.0)))
    return envelope_grid(condition, 4.0, 1.0), condition.boundary()


@pytest.fixture(scope="module")
def nothing():
    condition = FlightCondition(30000.0, 5.0, ControlLimits(rudder_deg=(30.0, 30.0)))
    return envelope_grid(condition), condition.boundary()


def test_picture_names_the_limits_of_the_boundary(envelope):
    axes = plot_envelope(*envelope).axes[0]
    shown = {text.get_text() for text in axes.get_legend().get_texts()}
    held = {name.split(".")[0] for names in envelope[1].limits_min + envelope[1].limits_max for name in names}
    assert {"alpha limit", "throttle limit", "aileron limit"} <= shown
    assert {name.removesuffix(" limit") for name in shown if name.endswith("limit")} <= held & set(LIMIT_COLOURS)
    low, high = axes.get_ylim()
    assert low < np.nanmin(envelope[1].tas_kt)
    assert high > np.nanmax(envelope[1].tas_kt)


def test_page_holds_every_accepted_trim(envelope):
    points = sum(len(trace["customdata"]) for trace in _traces(envelope) if "customdata" in trace)
    assert points == envelope[0].accepted.sum()


def _traces(envelope):
    page = envelope_page(*envelope)
    start = page.index("[", page.index("Plotly.newPlot("))
    text, _ = json.JSONDecoder().raw_decode(page[start:])
    return [trace for trace in text if _is_points(trace)]


def _is_points(trace):
    if isinstance(trace.get("customdata"), dict):  # plotly's binary form: dtype, bdata, shape
        rows = int(trace["customdata"]["shape"].split(",")[0])
        trace["customdata"] = [None] * rows
    return True


@pytest.mark.parametrize("ending", ["png", "html"])
def test_files_are_written(envelope, nothing, ending, tmp_path):
    for k, found in enumerate((envelope, nothing)):
        path = tmp_path / f"{k}.{ending}"
        save_envelope(*found, path)
        start = path.read_bytes()[:16]
        assert start.startswith(b"\x89PNG" if ending == "png" else b"<!doctype html>")


def test_another_ending_is_refused(envelope, tmp_path):
    with pytest.raises(InputError, match=r"neither \.png nor \.html"):
        save_envelope(*envelope, tmp_path / "envelope.pdf")
    assert not list(tmp_path.iterdir())
