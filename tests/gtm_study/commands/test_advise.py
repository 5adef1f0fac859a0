"""Advice after a failure: what the command says is what envelopes solved anew say."""

import json
import subprocess
import sys

import pytest

from gtm_fmu import ControlLimits, Failure, envelope, envelope_slopes
from gtm_fmu.core.configuration import Configuration
from gtm_study.paper import advice
from gtm_study.paper.advice_figure import plot_advice

pytestmark = pytest.mark.slow

RUDDER = "advise --altitude-ft 10000 --gamma-deg -5 --rudder-deg 5 25"


def width(altitude_ft: float, gamma_deg: float, **limits) -> float:
    found = envelope(altitude_ft, gamma_deg, ControlLimits(**limits))
    return found.v_max_kt - found.v_min_kt


@pytest.fixture(scope="module")
def rudder() -> advice.Advice:
    return advice.advice(envelope_slopes(10000, -5, ControlLimits(rudder_deg=(5, 25))))


class TestWords:
    def test_the_answer_comes_first(self, rudder):
        here = envelope(10000, -5, ControlLimits(rudder_deg=(5, 25)))
        first, most, free, gamma, altitude = advice.sentences(rudder)
        assert f"{here.v_min_kt:.1f} to {here.v_max_kt:.1f} kn" in first
        lost = width(10000, -5, rudder_deg=(5, 25)) - width(10000, -5, rudder_deg=(6, 25))
        assert most == (
            f"What narrows it most when lost is the lower limit of the rudder: at 6° it is {lost:.2f} kn narrower."
        )
        assert free.startswith("Free: the next degree or per cent of the elevator (both limits), the aileron (both ")
        assert "the rudder (upper limit), the throttle (lower limit) costs nothing." in free
        steeper = width(10000, -5, rudder_deg=(5, 25)) - width(10000, -4, rudder_deg=(5, 25))
        lower = width(9000, -5, rudder_deg=(5, 25)) - width(10000, -5, rudder_deg=(5, 25))
        assert f"at -4° it is {steeper:.2f} kn narrower; at -6°" in gamma
        assert f"at 9000 ft it is {lower:.2f} kn wider" in altitude

    def test_jumps_have_no_slope(self):
        found = advice.advice(envelope_slopes(30000, 1, ControlLimits(rudder_deg=(-1.2085, -1.2085))))
        assert "V_max jumps just below the present value of the jam of the rudder: it has no slope there." in (
            advice.sentences(found)
        )

    def test_a_jam_moves_both_ways(self):
        found = advice.advice(envelope_slopes(10000, 0, ControlLimits(rudder_deg=(20, 20))))
        moves = {move.change.to: move for move in found.moves if move.quantity.name == "rudder"}
        for to, move in moves.items():
            lost = width(10000, 0, rudder_deg=(20, 20)) - width(10000, 0, rudder_deg=(to, to))
            assert move.lost_kt == pytest.approx(lost, abs=0.002)
        assert moves[19.0].lost_kt < 0 < moves[21.0].lost_kt
        assert found.narrowing_most.quantity.name == "aileron.lower"  # it holds the slowest flight
        wider, narrower = -moves[19.0].lost_kt, moves[21.0].lost_kt
        words = f"Jam of the rudder: at 21° it is {narrower:.2f} kn narrower; at 19° it is {wider:.2f} kn wider."
        assert words in advice.sentences(found)

    def test_nothing_is_left_of_it(self):
        """All of a range may be needed: without it no envelope is left, which costs more than anything."""
        here = Failure(ControlLimits(rudder_deg=(7.8, 30)))
        found = advice.advice(envelope_slopes(30000, 2, here))
        assert not envelope(30000, 2, ControlLimits(rudder_deg=(8.8, 30))).feasible
        assert found.narrowing_most.lost_kt is None
        assert "lower limit of the rudder: at 8.8° no envelope is left." in advice.sentences(found)[1]


class TestNoEnvelope:
    def test_what_would_have_to_move(self, ask):
        answer = ask("advise --altitude-ft 30000 --gamma-deg 2 --rudder-deg 20 30 --json")
        assert answer.code == 0
        assert not answer.json["feasible"]
        assert [remedy["name"] for remedy in answer.json["remedies"]] == ["altitude", "gamma", "rudder.lower"]
        assert answer.json["quantities"] == []
        words = " ".join(answer.json["words"])
        assert "no envelope; the nearest manoeuvre is outside rudder.lower, throttle.upper" in words
        # what is printed, in two digits, is an envelope too
        assert "lower limit of the rudder at 7.82°" in words
        assert envelope(30000, 2, ControlLimits(rudder_deg=(7.82, 30))).feasible
        assert not envelope(30000, 2, ControlLimits(rudder_deg=(7.85, 30))).feasible

    def test_more_than_one_has_to_move(self, ask):
        answer = ask("advise --altitude-ft 30000 --gamma-deg 2 --engine-out both --throttle-pct 0 0")
        assert answer.code == 0
        assert "no envelope" in answer.out

    def test_there_is_nothing_to_draw(self, ask, tmp_path):
        answer = ask(
            *["advise", "--altitude-ft", "30000", "--gamma-deg", "2", "--rudder-deg", "20", "30", "--plot"],
            tmp_path / "a.png",
        )
        assert (answer.code, list(tmp_path.iterdir())) == (0, [])
        assert "Nothing is drawn" in answer.out


class TestCommand:
    def test_json(self, ask):
        found = ask(f"{RUDDER} --json").json
        assert found["narrowing_most"] == "rudder.lower"
        assert "rudder.upper" in found["free"]
        lower = next(each for each in found["quantities"] if each["name"] == "rudder.lower")
        assert set(lower) >= {"value", "units", "v_min_slope", "v_max_slope", "kinks", "jumps", "moved"}
        assert lower["v_max_slope"]["above"] == pytest.approx(lower["v_max_slope"]["below"], rel=0.01)
        # methods/SENSITIVITY.md, given an envelope: S^T of V_max for altitude
        assert found["global_indices"]["total"]["altitude"]["v_max_kt"] == pytest.approx(0.248, abs=0.0055)

    def test_table(self, ask):
        """A row for every move that costs or gains something, the costliest first."""
        lines = ask(RUDDER).out.splitlines()
        rows = [line.split("  ")[0].strip() for line in lines if " to " in line and "kn" not in line]
        assert rows == [
            "gamma to -4°",
            "rudder.lower to 6°",
            "throttle.upper to 99 %",
            "altitude to 11000 ft",
            "altitude to 9000 ft",
            "gamma to -6°",
        ]
        assert all(len(line) <= 80 for line in lines)

    @pytest.mark.parametrize(
        ("further", "what"), [("", "all four controls"), ("--engine-out left", "controls, engines")]
    )
    def test_other_failures_stand_beside_the_width_of_all_of_them(self, ask, further, what):
        answer = ask(
            f"advise --altitude-ft 3000 --rudder-deg 5 5 --aileron-deg -3 5 {further} --json".replace("  ", " ")
        )
        shares = answer.json["global_indices"]
        assert f"the width of the envelope, where {what}" in shares["of"]
        assert set(shares["total"]) >= {"altitude", "gamma", "rudder", "aileron.lower", "throttle.upper"}
        assert shares["total"]["aileron.lower"] == shares["total"]["aileron.upper"]

    @pytest.mark.parametrize(
        ("words", "message"),
        [
            ("--altitude-ft 99999", "altitude in ft 99999 is outside"),
            ("--altitude-ft 0 --plot advice.pdf", "advice.pdf does not end in .png; name the picture so"),
            ("--altitude-ft 0 --plot no/such/place.png", "there is no folder"),
            ("--altitude-ft 0 --rudder-deg 5", "takes 2 values"),
            ("", "Missing option '--altitude-ft'"),
        ],
    )
    def test_refused(self, ask, words, message):
        answer = ask(f"advise {words}".strip())
        assert (answer.code, answer.out) == (2, "")
        assert message in answer.err

    def test_two_throttles(self):
        """Each is a quantity of its own."""
        failure = Failure(ControlLimits(rudder_deg=(5, 5)), Configuration(), (0, 60), (0, 90))
        found = advice.advice(envelope_slopes(3000, -2, failure))
        assert {"throttle_left.upper", "throttle_right.upper"} <= {move.quantity.name for move in found.moves}
        assert json.dumps(found.to_dict(), allow_nan=False)


def test_figure(rudder):
    """Bars are the exact changes, diamonds the slopes times the step."""
    figure = plot_advice(rudder)
    v_min, v_max, shares = figure.axes
    here, moves = rudder.slopes.envelope, rudder.moves[::-1]
    assert [label.get_text() for label in v_min.get_yticklabels()] == [advice.moved(move) for move in moves]
    for axes, end in ((v_min, "v_min_kt"), (v_max, "v_max_kt")):
        drawn = [bar.get_width() for bar in axes.patches]
        assert drawn == pytest.approx([getattr(move.change, end) - getattr(here, end) for move in moves])
    lost = next(k for k, move in enumerate(moves) if move.quantity.name == "rudder.lower")
    place, row = (line[0] for line in v_max.lines[lost].get_data())
    assert row == lost
    assert place == pytest.approx(v_max.patches[lost].get_width(), rel=0.05)
    assert shares.get_xlabel() == "total index $S^T$"


def test_other_commands_do_not_wait_for_it():
    """What only advice needs is imported when it is asked for."""
    needed = (
        "import sys, gtm_study.commands.cli; sys.exit('sensitivity' in sys.modules or 'scipy.stats' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", needed], timeout=60).returncode == 0
