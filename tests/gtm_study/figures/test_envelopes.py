"""Figures of one envelope: what they show comes from the grid and the boundary, and both files can be opened."""

import json
import re

import numpy as np
import pytest

from gtm_fmu.aircraft.failures import Failure
from gtm_fmu.aircraft.inputs import LIMITED
from gtm_fmu.aircraft.limits import ControlLimits
from gtm_fmu.core.configuration import Configuration
from gtm_fmu.envelopes.boundary import envelope_boundary
from gtm_fmu.envelopes.envelope import FlightCondition
from gtm_fmu.envelopes.grid import envelope_grid
from gtm_fmu.errors import InputError
from gtm_study.figures import captions
from gtm_study.figures.envelopes import envelope_page, plot_envelope, save_envelope, strokes
from tests.gtm_study.looks import alike


@pytest.fixture(scope="module")
def envelope():
    condition = FlightCondition(10000.0, -5.0, ControlLimits(rudder_deg=(5.0, 25.0)))
    return envelope_grid(condition, 4.0, 1.0), envelope_boundary(condition)


@pytest.fixture(scope="module")
def nothing():
    return FlightCondition(30000.0, 5.0, ControlLimits(rudder_deg=(30.0, 30.0)))


def test_picture_names_the_limits_of_the_boundary(envelope):
    figure = plot_envelope(*envelope)
    assert alike(figure) == []
    (axes,), (legend,) = figure.axes, figure.legends
    shown = {text.get_text() for text in legend.get_texts()}
    for name in ("alpha", "throttle", "aileron", "phi", "rudder"):
        assert captions.quantity(name).tex in shown
    assert captions.quantity("elevator").tex not in shown
    assert {"stable", "unstable, controllable"} < shown
    (rates, speeds), ((left, right), (low, high)) = envelope[1].outlines[0], (axes.get_xlim(), axes.get_ylim())
    assert left < rates.min() < rates.max() < right
    assert low < speeds.min() < speeds.max() < high


def test_every_piece_is_drawn_in_the_colours_of_its_limits(envelope):
    drawn = [(stroke.label, stroke.is_second, len(stroke.tas_kt)) for stroke in strokes(envelope[1])]
    for piece in envelope[1].polygons[0]:
        for limit in piece.limits[:2]:
            label = captions.quantity(limit.split(".")[0])
            assert any(drawn_label == label and count == len(piece.tas_kt) for drawn_label, _, count in drawn)
    assert {second for _, second, _ in drawn} == {True, False}


def test_page_holds_every_accepted_trim(envelope):
    page = envelope_page(*envelope)
    start = page.index("[", page.rindex("Plotly.newPlot("))  # the library before it holds the words too
    traces, _ = json.JSONDecoder().raw_decode(page[start:])
    (cells,) = [trace for trace in traces if trace["type"] == "heatmap"]
    rows, columns, values = (int(count) for count in cells["customdata"]["shape"].split(","))
    assert (rows, columns) == envelope[0].feasible.shape
    assert values == 7  # alpha, beta, phi and the four controls
    assert len(re.findall(r"customdata\[", cells["hovertemplate"])) == values
    legend = [trace["name"] for trace in traces if trace.get("showlegend", True) and trace["type"] == "scatter"]
    assert len(legend) == len(set(legend)) > 5


@pytest.mark.parametrize("ending", ["png", "html"])
def test_files_are_written(nothing, ending, tmp_path):
    for k, condition in enumerate((nothing, FlightCondition(10000.0, 0.0, ControlLimits(rudder_deg=(9.0, 9.0))))):
        path = tmp_path / f"{k}.{ending}"
        save_envelope(condition, path)
        start = path.read_bytes()[:16]
        assert start.startswith(b"\x89PNG" if ending == "png" else b"<!doctype html>")


def test_another_ending_is_refused(nothing, tmp_path):
    with pytest.raises(InputError, match=r"neither \.png nor \.html"):
        save_envelope(nothing, tmp_path / "envelope.pdf")
    assert not list(tmp_path.iterdir())


def test_captions_tell_the_failure():
    assert captions.failure(Failure()) == "no failure"
    failure = Failure(
        ControlLimits((-1, 2.5), rudder_deg=(5, 5)),
        Configuration(damage_case=4, engine_running=(False, True), flap_deg=(20.0,) * 4),
    )
    told = captions.failure(failure)
    for part in (
        "elevator -1 .. 2.5\N{DEGREE SIGN}",
        "rudder jammed at 5\N{DEGREE SIGN}",
        "left engine out",
        "flap 20",
    ):
        assert part in told
    assert "rudder" not in captions.failure(Failure(ControlLimits(rudder_deg=(5, 5))), LIMITED["rudder"][0])
    apart = captions.failure(Failure(throttle_left_pct=(20, 60)))
    assert apart == "left throttle 20 .. 60 %"
    assert captions.condition(10000, -5) == "h = 10000 ft, \N{GREEK SMALL LETTER GAMMA} = -5\N{DEGREE SIGN}"
    assert np.all([captions.quantity(name).tex.count("$") == 2 for name in ("alpha", "rudder", "throttle_left")])
