"""What matters for a failed rudder: exact indices against those found otherwise, and what explains the paper's."""

import sys
from pathlib import Path

import numpy as np
import pytest

import sensitivity
from gtm_fmu.aircraft.failures import Failure
from gtm_fmu.aircraft.limits import ControlLimits
from gtm_fmu.core.configuration import Configuration
from gtm_fmu.envelopes.envelope import FlightCondition, envelope
from gtm_fmu.envelopes.thrust_map import ThrustMap
from gtm_study.paper import published, rudder_grid
from gtm_study.paper.rudder_grid import EXACT_CELLS, Cells, RudderGrid, mapped
from gtm_study.paper.rudder_sensitivity import (
    AS_IN_THE_PAPER,
    LIMITS,
    NAMES,
    WHETHER,
    WITH_AN_ENVELOPE,
    answers,
    apart,
    of_network,
)
from sensitivity import TabulatedIndices
from surrogate.rudder.emulator import RudderEmulator
from surrogate.rudder.names import PAPER

pytestmark = pytest.mark.slow

ALTITUDE, LOWER, UPPER, BOTH = NAMES[0], *LIMITS, ",".join(LIMITS)
EVERY_LIMIT = range(-30, 31, 10)


def index(found: TabulatedIndices, output: str, factor: str, kind: str = "first") -> float:
    return found.to_dict()[output]["indices"][factor][kind]


@pytest.fixture(scope="module")
def network() -> RudderEmulator:
    return RudderEmulator.load(PAPER)


@pytest.fixture(scope="module")
def truth() -> RudderGrid:
    return rudder_grid.exact()


@pytest.fixture(scope="module")
def exact(truth, network) -> dict[str, TabulatedIndices]:
    return answers(truth, network)


@pytest.mark.parametrize(
    ("question", "output", "factor", "kind", "expected"),
    [
        (AS_IN_THE_PAPER, "v_min_kt", ALTITUDE, "first", 0.729),
        (AS_IN_THE_PAPER, "v_min_kt", LOWER, "first", 0.184),
        (AS_IN_THE_PAPER, "v_min_kt", UPPER, "first", 0.102),
        (AS_IN_THE_PAPER, "v_max_kt", ALTITUDE, "first", 0.171),
        (AS_IN_THE_PAPER, "v_max_kt", BOTH, "first", 0.248),
        (AS_IN_THE_PAPER, "v_max_kt", ALTITUDE, "total", 0.315),
        (WITH_AN_ENVELOPE, "v_min_kt", ALTITUDE, "first", 0.821),
        (WITH_AN_ENVELOPE, "v_min_kt", LOWER, "first", 0.079),
        (WITH_AN_ENVELOPE, "v_min_kt", UPPER, "first", 0.043),
        (WITH_AN_ENVELOPE, "v_max_kt", ALTITUDE, "first", 0.080),
        (WITH_AN_ENVELOPE, "v_max_kt", BOTH, "first", 0.240),
        (WITH_AN_ENVELOPE, "v_max_kt", ALTITUDE, "total", 0.248),
    ],
)
def test_exact_indices(exact, question, output, factor, kind, expected):
    """methods/SENSITIVITY.md, found by sampling the thrust map."""
    assert index(exact[question], output, factor, kind) == pytest.approx(expected, abs=0.0055)


def test_the_thrust_map_has_hardly_an_error_of_its_own(exact, network):
    on_the_same_cells = answers(mapped(EXACT_CELLS, ThrustMap.load()), network)
    assert apart(on_the_same_cells[AS_IN_THE_PAPER], exact[AS_IN_THE_PAPER]) < 0.001
    assert apart(on_the_same_cells[WITH_AN_ENVELOPE], exact[WITH_AN_ENVELOPE]) < 0.003


def test_the_same_by_sampling(exact, network):
    """Redrawn limits at random cases instead of cells: within four standard errors."""
    thrust_map = ThrustMap.load()
    (low, high), pair = rudder_grid.ALTITUDE_FT, sensitivity.OrderedUniform(LIMITS, -30.0, 30.0)
    distribution = sensitivity.Distribution(
        [sensitivity.Uniform(NAMES[0], low, high), sensitivity.Uniform(NAMES[1], *rudder_grid.GAMMA_DEG), pair]
    )

    def speeds(cases):
        found = thrust_map.predict(cases)
        by_map = np.column_stack([found.v_min_kt, found.v_max_kt])
        return np.where(found.feasible[:, None], by_map, network.speeds.predict(cases))

    design = sensitivity.variance_design(distribution, 512, sampling="random")
    sampled = sensitivity.variance_indices(design.evaluate(speeds))
    for kind in ("first", "total"):
        by_cells, by_sampling = exact[AS_IN_THE_PAPER].estimates[kind], sampled.estimates[kind]
        assert (abs(by_cells.value - by_sampling.value) < 4 * by_sampling.standard_error + 0.002).all()


def test_kept_jams_are_those_of_the_solver(truth):
    """The file is as old as the solver, or as good."""
    places = np.random.default_rng(1).integers(0, EXACT_CELLS, (8, 3))
    for h, gamma, jam in places:
        altitude_ft, gamma_deg, deflection = (
            axis[k] for axis, k in zip(EXACT_CELLS.axes, (h, gamma, jam), strict=True)
        )
        found = FlightCondition(altitude_ft, gamma_deg).envelope((deflection, deflection))
        kept = truth.speeds_kt[h, gamma, jam, jam]
        np.testing.assert_allclose(kept, np.array([found.v_min_kt, found.v_max_kt], dtype=float), atol=0.001)
        assert truth.t_min_pct[h, gamma, jam, jam] == pytest.approx(found.t_min_pct, abs=0.001)


def test_ranges_are_unions_of_jams(truth):
    """Jams a degree apart miss little of what a range leaves."""
    rng = np.random.default_rng(2)
    altitude, gamma, rudder = EXACT_CELLS.axes
    for _ in range(6):
        h, g = rng.integers(0, EXACT_CELLS[:2])
        low, high = np.sort(rng.choice(60, 2, replace=False))
        found = FlightCondition(altitude[h], gamma[g]).envelope((rudder[low], rudder[high]))
        v_min, v_max = truth.speeds_kt[h, g, low, high]
        assert found.feasible == np.isfinite(v_min)
        if found.feasible:
            assert -1e-3 < v_min - found.v_min_kt < 0.15
            assert -0.15 < v_max - found.v_max_kt < 1e-3


def test_the_table_of_the_page(exact, truth, network):
    """docs/sensitivity.md: V_min and V_max as in the paper, by a network and with an envelope; and whether."""
    page = (Path(__file__).parents[3] / "docs/sensitivity.md").read_text()
    table = page.split("| index | as in the paper: exact |")[1].split("\n\n")[0].splitlines()[2:]
    factors = {"altitude": ALTITUDE, "flight path": NAMES[1], "the lower limit": LOWER, "the upper limit": UPPER}
    by_network, output = of_network(truth, network)[AS_IN_THE_PAPER], ""
    for line in table:
        name, *cells = (cell.strip() for cell in line.strip("|").split("|"))
        output = f"{name[:5].lower()}_kt" if name.startswith("V_m") else output
        kind, factor = name.rpartition(": ")[2].split(" of ", 1)
        asked = output, factors.get(factor, BOTH), {"S": "first", "S^T": "total"}[kind]
        found = [index(answer, *asked) for answer in (exact[AS_IN_THE_PAPER], by_network, exact[WITH_AN_ENVELOPE])]
        assert [float(cells[k]) for k in (0, 1, 3)] == pytest.approx(found, abs=0.0011)
        if cells[4]:
            whether = index(exact[WHETHER], "has_envelope", *asked[1:])
            assert float(cells[4]) == pytest.approx(whether, abs=0.0011)
    assert len(table) == 13


class KnownSpeeds:
    """V_min = h / 1000 + LL, V_max = 2 gamma + UL."""

    def predict(self, X):
        h, gamma, lower, upper = X.T
        return np.column_stack([h / 1000 + lower, 2 * gamma + upper])


def test_a_known_function():
    """Shares of variance in closed form.

    A limit of the triangle on [-30, 30] has the variance 60^2 / 18, and UL given LL is uniform on what is left, so its
    mean follows LL with half the slope: of V[UL] a quarter is explained by LL.
    """
    cells = Cells(20, 20, 40)
    everywhere = RudderGrid.of_jams(cells, np.zeros(cells), np.ones(cells))
    emulator = RudderEmulator(KnownSpeeds(), None)  # type: ignore[arg-type]
    limit, altitude, gamma = 60.0**2 / 18, 30.0**2 / 12, 20.0**2 / 12
    for found in of_network(everywhere, emulator).values():
        for output, factor, expected in (
            ("v_min_kt", ALTITUDE, altitude / (altitude + limit)),
            ("v_min_kt", LOWER, limit / (altitude + limit)),
            ("v_max_kt", NAMES[1], gamma / (gamma + limit)),
            ("v_max_kt", LOWER, limit / 4 / (gamma + limit)),
        ):
            assert index(found, output, factor) == pytest.approx(expected, abs=0.003)


def test_with_a_centred_cg_both_limits_matter_alike(centred, network):
    """The cg lies 0.0118 ft to the left (SPEC 3). On the plane of symmetry, the limits' indices of V_min are equal."""
    cells = Cells(3, 3, 20)

    def limits_indices(configuration: Configuration) -> tuple[float, float]:
        ends = []
        for altitude_ft, gamma_deg, jam, _ in cells.jams:
            failure = Failure(ControlLimits(rudder_deg=(jam, jam)), configuration)
            found = envelope(altitude_ft, gamma_deg, failure)
            ends.append((found.v_min_kt, found.v_max_kt) if found.feasible else (np.nan, np.nan))
        found = answers(RudderGrid.of_jams(cells, *np.array(ends).T), network)[WITH_AN_ENVELOPE]
        return index(found, "v_min_kt", LOWER), index(found, "v_min_kt", UPPER)

    lower, upper = limits_indices(Configuration())
    assert lower > 1.7 * upper
    lower, upper = limits_indices(centred)
    assert lower == pytest.approx(upper, rel=0.04)


def test_the_papers_totals_of_one_limit_are_those_of_both(truth, network):
    """Table 15 breaks an identity; its S^T of one limit are what redrawing both limits gives, by the same network."""
    found = of_network(truth, network)[AS_IN_THE_PAPER]
    for output, factors in published.VARIANCE_INDICES.items():
        both = index(found, output, BOTH, "total")
        for limit in LIMITS:
            known = factors[limit]["total"]
            assert known == pytest.approx(both, abs=0.012)
            assert known - index(found, output, limit, "total") > 0.09


def test_made_anew(tmp_path, monkeypatch, capsys):
    """The command that made the file, for fewer cells."""
    monkeypatch.setattr(rudder_grid, "EXACT_CELLS", Cells(1, 1, 2))
    monkeypatch.setattr(rudder_grid.solve, "__defaults__", (Cells(1, 1, 2), 1, None))
    monkeypatch.setattr(sys, "argv", ["rudder_grid", str(tmp_path), "--workers", "1"])
    assert rudder_grid.main() == 0
    with np.load(tmp_path / rudder_grid.FILE.name) as content:
        found = envelope(15000, 0, ControlLimits(rudder_deg=(-15, -15)))
        assert content["v_max"].ravel()[0] == pytest.approx(found.v_max_kt, abs=0.001)
    (tmp_path / "file").touch()
    monkeypatch.setattr(sys, "argv", ["rudder_grid", str(tmp_path / "file")])
    assert rudder_grid.main() == 2
    assert "choose a folder you may write to" in capsys.readouterr().err
