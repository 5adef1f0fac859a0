"""GtmThrustMapNative against the thrust map in this process."""

import math
import subprocess
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.validation import validate_fmu

from fmu_src import build
from fmu_src.description.map_variables import map_source
from fmu_src.fmus import build_fmu
from fmu_src.packing.native_sources import source_files
from gtm_fmu.aircraft.client import FmuClient
from gtm_fmu.core.sources import THRUST_MAP
from gtm_fmu.envelopes.thrust_map import THRUST_MAPS, ThrustMap
from gtm_fmu.errors import InputError
from tests.fmu_src.conftest import sessions
from tests.fmu_src.native_session import DISCARD, ERROR, OK

pytestmark = pytest.mark.slow

SPEEDS = ("v_min", "v_max", "v_min_std", "v_max_std", "margin.slow", "margin.fast", "v_min_safe", "v_max_safe")
FLAGS = ("feasible", "in_domain", "fold", "feasible_safe")
SI = np.array([0.3048, *[math.pi / 180] * 3])
KN = 0.3048 / 0.592487  # SPEC 1
TAS_KT = 90.0


@pytest.fixture(scope="module")
def folders(thrust_map_fmus, tmp_path_factory) -> dict[int, Path]:
    folder = tmp_path_factory.mktemp("unpacked")
    return {fmi: Path(fmpy.extract(path, folder / str(fmi))) for fmi, path in thrust_map_fmus.items()}


@pytest.fixture
def start(fmi, folders):
    yield from sessions(folders[fmi], fmi)


@pytest.fixture(scope="module")
def cases() -> np.ndarray:
    """Jams and restrictions in SI, some outside the map, and cases just beside folds."""
    rng = np.random.default_rng(5)
    cases = rng.uniform((0, -6, -30, -30), (36089, 6, 30, 30), (5000, 4))
    cases[::2, 3] = cases[::2, 2]
    cases[:, 2:].sort(axis=1)
    folds = np.flatnonzero(ThrustMap.load().predict(cases).fold)
    return np.concatenate([cases[:300], cases[folds]]) * SI


def asked(session, case) -> tuple[int, np.ndarray, list[bool]]:
    """Status, speeds in kn and flags of a case."""
    assert session.set(range(5), [*case, TAS_KT * KN]) == OK
    status, speeds = session.get([session.names[name] for name in SPEEDS])
    if session.kind == "me":
        session.handle_event()
    return status, np.array(speeds) / KN, session.get_flags(*FLAGS)


def told(expected) -> np.ndarray:
    """Speeds (n, 6) in kn that an FMU tells: those of the case, their deviations, and the safe ones."""
    speeds = np.nan_to_num(np.column_stack(expected[:4]))
    speeds[expected.feasible & ~expected.in_domain, 2:] = 1000.0  # kn, where nobody knows
    v_min, v_max = np.nan_to_num(expected.v_min_safe_kt, nan=1000.0), np.nan_to_num(expected.v_max_safe_kt)
    return np.column_stack([speeds, v_min, v_max])  # where nothing is promised no speed is safe


@pytest.mark.parametrize("kind", ["cs", "me"])
def test_values_are_those_of_the_map(start, kind, cases):
    session = start(kind)
    if kind == "me":
        session.call("EnterContinuousTimeMode")
    expected = ThrustMap.load().predict(cases / SI)
    speeds = told(expected)
    flags = np.column_stack([getattr(expected, name) for name in FLAGS])
    assert {tuple(row) for row in flags[:, :2]} == {(a, b) for a in (False, True) for b in (False, True)}
    assert flags[:, 2].sum() > 5
    for k, case in enumerate(cases):
        if kind == "cs":
            assert session.step(0.1 * k, 0.1) == OK
        status, got, got_flags = asked(session, case)
        assert status == OK
        wanted = [*speeds[k, :4], TAS_KT - speeds[k, 0], speeds[k, 1] - TAS_KT, *speeds[k, 4:]]
        np.testing.assert_allclose(got, wanted, rtol=1e-12, atol=1e-12)
        assert got_flags == flags[k].tolist()


def test_gtm_surrogate_carries_the_map(built, cases):
    """GtmSurrogate by default, in Python and in C: the interface with fold, the values of the map."""
    expected = ThrustMap.load().predict(cases[:60] / SI)
    wanted = told(expected)
    for name, model in (("surrogate", "GtmSurrogate"), ("surrogate-native", "GtmSurrogateNative")):
        path = build(name, built("thrust-map-native").parent / "default")
        assert fmpy.read_model_description(path).modelName == model
        with FmuClient(path) as fmu:
            for k, case in enumerate(cases[:60]):
                fmu.set(("altitude", "gamma", "rudder.lower", "rudder.upper"), case)
                asked = fmu.get((*SPEEDS[:4], *SPEEDS[6:])) / KN
                np.testing.assert_allclose(asked, wanted[k], rtol=1e-12, atol=1e-12)
                for flag in FLAGS:
                    assert fmu.get_boolean(flag) == getattr(expected, flag)[k]


def test_small_stack_and_traps(tmp_path, cases):
    """Start values, cases in and outside the map: no trap, and 64 KiB of stack are enough."""
    sources = source_files((), THRUST_MAP, 2) | map_source(ThrustMap.load())
    sources["map_host.c"] = Path(__file__).with_name("map_host.c").read_bytes()
    for name, content in sources.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_bytes(content)
    files = [name for name in sources if name.endswith(".c") and not name.startswith("fmi")]
    command = ["cc", "-std=gnu99", "-O1", "-I.", *files, "-o", "host", "-lm", "-lpthread"]
    subprocess.run(command, cwd=tmp_path, check=True)
    start = [[10000.0, 0.0, -30.0, 30.0], [0.0, -45.0, -30.0, 30.0], [36089.0, 45.0, 7.0, 7.0]]
    asked = np.concatenate([start, cases[:400] / SI])
    asked[:, 2:] = np.clip(asked[:, 2:], -30, 30)
    text = "\n".join(" ".join(map(repr, case)) for case in asked.tolist())
    ended = subprocess.run([tmp_path / "host"], input=text, capture_output=True, text=True)
    assert ended.returncode == 0
    expected = np.nan_to_num(ThrustMap.load().predict(asked).v_max_kt)
    np.testing.assert_allclose(np.array(ended.stdout.split(), dtype=float), expected, rtol=1e-12)


def test_fmpy_validation_is_clean(thrust_map_fmus, fmi):
    assert validate_fmu(str(thrust_map_fmus[fmi])) == []


@pytest.mark.parametrize(("gamma_deg", "is_inside"), [(-5.0, True), (5.0, True), (5.001, False), (-45.0, False)])
def test_domain(start, gamma_deg, is_inside):
    status, speeds, flags = asked(start(), np.array([36089.0, gamma_deg, -30.0, 30.0]) * SI)
    assert status == OK
    assert np.isfinite(speeds).all()
    assert flags[1] is is_inside


@pytest.mark.parametrize("ends", [(-30, 30), (30, 30), (-30, -30)])
def test_rounding_beyond_the_deflections(start, ends):
    """A limit may be off by a rounding; the map ends where the rudder does."""
    session = start()
    case = np.array([8000.0, 1.0, *ends]) * SI
    at_the_end = asked(session, case)
    case[2:] += 5e-10 * np.sign(case[2:])
    beyond = asked(session, case)
    np.testing.assert_array_equal(beyond[1], at_the_end[1])
    assert (beyond[0], beyond[2]) == (OK, at_the_end[2])


class TestBadInput:
    @pytest.mark.parametrize(
        ("values", "sentence"),
        [
            ({"rudder__lower": 0.2, "rudder__upper": 0.1}, "rudder.lower is above rudder.upper"),
            ({"altitude": math.nan}, "altitude was given as nan, allowed is 0 .. "),
            ({"altitude": 12000.0}, "altitude was given as 12000, allowed is 0 .. "),
            ({"gamma": -0.8}, "gamma was given as -0.8, allowed is "),
            ({"rudder__upper": 0.53}, "rudder.upper was given as 0.53, allowed is "),
            ({"tas": math.inf}, "tas was given as inf, allowed is "),
        ],
    )
    def test_step_is_discarded(self, start, cases, values, sentence):
        session = start()
        assert session.step(0.0, 0.1) == OK
        before = session.get_named(*SPEEDS)
        session.set_named(**values)
        assert session.step(0.1, 0.1) == DISCARD
        assert sentence in " ".join(session.texts())
        assert session.get([session.names[name] for name in SPEEDS]) == (DISCARD, before)
        assert asked(session, cases[0])[0] == OK
        assert session.step(0.1, 0.1) == OK

    def test_no_partial_derivatives(self, start):
        session = start("me")
        assert session.directional([session.names["v_min"]], [session.names["gamma"]], [1.0])[0] == ERROR
        assert session.texts() == ["The FMU has no partial derivatives."]

    def test_networks_are_not_taken(self, tmp_path):
        with pytest.raises(InputError, match="Networks were given for the thrust map FMU, which uses none"):
            build("thrust-map-native", tmp_path, ["speeds.json", "throttle.json"])
        with pytest.raises(InputError, match=r"'speeds\.json' is no readable thrust map"):
            build("thrust-map-native", tmp_path, ["speeds.json"])

    def test_a_surrogate_is_of_the_rudder(self, tmp_path):
        for name in ("surrogate", "surrogate-native"):
            with pytest.raises(InputError, match="is a thrust map of the elevator: give one of the rudder"):
                build_fmu(name, tmp_path, "elevator")


@pytest.mark.parametrize("control", ["elevator", "aileron"])
def test_maps_of_other_controls(control, tmp_path):
    """Inputs named as in GtmEnvelope; values of the map; a range without manoeuvres; reversed limits are told."""
    path = build_fmu("thrust-map-native", tmp_path, control)
    assert path.name == f"GtmThrustMap{control.capitalize()}Native.fmu"
    assert validate_fmu(str(path)) == []
    shipped = ThrustMap.load(THRUST_MAPS[control])
    rng = np.random.default_rng(2)
    widest = 30 if control == "elevator" else 20  # SPEC 9, deg
    cases = rng.uniform((0, -5, -6, -6), (36089, 5, 6, 6), (60, 4))
    cases[:, 2:].sort(axis=1)
    cases[::3, 3] = cases[::3, 2]
    cases[1, 2:] = (widest,) * 2
    expected = shipped.predict(cases)
    wanted = told(expected)
    names = ("altitude", "gamma", f"limits.{control}.lower", f"limits.{control}.upper")
    with FmuClient(path) as fmu:
        for k, case in enumerate(cases * SI):
            fmu.set(names, case)
            asked = fmu.get((*SPEEDS[:4], *SPEEDS[6:])) / KN
            np.testing.assert_allclose(asked, wanted[k], rtol=1e-12, atol=1e-12)
            assert fmu.get_boolean("feasible") == expected.feasible[k]
            assert fmu.get_boolean("fold") == expected.fold[k]
            assert fmu.get_boolean("feasible_safe") == expected.feasible_safe[k]
        fmu.set(names, (1000.0, 0.0, 0.1, 0.0))
        with pytest.raises(Exception, match=f"limits.{control}.lower is above limits.{control}.upper"):
            fmu.get(SPEEDS)
