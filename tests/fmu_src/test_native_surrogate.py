"""GtmSurrogateNative against the networks that it carries."""

from pathlib import Path

import casadi as ca
import fmpy
import numpy as np
import pytest
from fmpy.validation import validate_fmu

from fmu_src import build
from fmu_src.fmus import build_fmu
from gtm_fmu.errors import InputError
from gtm_fmu.units import M_PER_FT, M_S_PER_KT, RAD_PER_DEG
from tests.fmu_src.conftest import CASE_RANGES
from tests.fmu_src.native_session import DISCARD, OK, SESSIONS

pytestmark = pytest.mark.slow

CASE = ("altitude", "gamma", "rudder.lower", "rudder.upper")
SPEEDS = ("v_min", "v_max", "v_min_std", "v_max_std", "margin.slow", "margin.fast")
SI = np.array([M_PER_FT, RAD_PER_DEG, RAD_PER_DEG, RAD_PER_DEG])
STD_DIGITS = 1e-6  # the FMU keeps the factor of the covariance in single precision


@pytest.fixture(scope="module")
def folders(native_surrogates, tmp_path_factory) -> dict[int, Path]:
    return {
        fmi: Path(fmpy.extract(path, tmp_path_factory.mktemp("unpacked"))) for fmi, path in native_surrogates.items()
    }


@pytest.fixture
def session(folders, fmi):
    with SESSIONS[fmi](folders[fmi], "me") as opened:
        opened.initialize(is_exited=False)
        yield opened


def random_cases(count: int) -> np.ndarray:
    cases = np.random.default_rng(3).uniform(*np.array(CASE_RANGES).T, (count, 4))
    cases[:, 2:].sort(axis=1)
    return cases


def put(session, case: np.ndarray, tas_kt: float = 110.0) -> int:
    references = [session.names[name] for name in (*CASE, "tas")]
    return session.set(references, [*(case * SI), tas_kt * M_S_PER_KT])


def flags(session) -> list[bool]:
    """feasible, in_domain."""
    return session.get_flags("feasible", "in_domain")


def test_fmpy_validation_is_clean(native_surrogates, fmi):
    assert validate_fmu(str(native_surrogates[fmi])) == []


def test_interface_is_that_of_the_python_fmu(native_surrogates, surrogate_fmu, fmi):
    own, other = (
        fmpy.read_model_description(path, validate=False).modelVariables
        for path in (native_surrogates[fmi], surrogate_fmu)
    )
    assert [variable.name for variable in own[len(other) :]] == ["time"]
    for mine, its in zip(own, other, strict=False):
        for attribute in ("name", "valueReference", "causality", "variability", "unit", "displayUnit", "description"):
            assert getattr(mine, attribute) == getattr(its, attribute)


def test_size_with_the_networks_of_the_package(tmp_path):
    """At most 150 kB with the binary of this platform; that of FMI 3.0 is the larger one."""
    path = build_fmu("surrogate-native3", tmp_path, "network")
    assert path.stat().st_size <= 150_000
    assert len([n for n in fmpy.supported_platforms(path) if n not in ("c-code", "other")]) == 1


def test_values_are_those_of_the_networks(session, networks):
    speeds, throttle, _ = networks
    seen = set()
    for case in random_cases(200):
        assert put(session, case) == OK
        v_min, v_max = speeds.predict(case)
        got = np.array(session.get_named(*SPEEDS)) / M_S_PER_KT
        np.testing.assert_allclose(got[[0, 1, 4, 5]], [v_min, v_max, 110 - v_min, v_max - 110], rtol=1e-11, atol=1e-10)
        np.testing.assert_allclose(got[2:4], speeds.predict_std(case), rtol=STD_DIGITS)
        feasible = bool(throttle.predict(case)[0] <= 100 and v_min <= v_max)
        assert flags(session) == [feasible, True]
        seen.add((feasible, bool(v_min <= v_max)))
    assert seen == {(True, True), (False, True), (False, False)}


@pytest.mark.parametrize("place", range(4))
@pytest.mark.parametrize("end", [0, 1])
def test_domain(session, place, end):
    """On the edge of the training data, a rounding beyond it, and outside."""
    case = np.array([1000.0, 0.0, -30.0, 30.0])
    case[2:] = (CASE_RANGES[place][end],) * 2 if place >= 2 else case[2:]
    case[place] = edge = CASE_RANGES[place][end]
    for value, inside in ((edge, True), (edge + (2 * end - 1) * 1e-12, True), (edge + (2 * end - 1) * 0.01, False)):
        case[place] = value
        case[2:].sort()
        put(session, case)
        assert flags(session)[1] is inside


def test_partial_derivatives(session, networks):
    """Exact for speeds and margins; those of the standard deviations against differences of the network."""
    speeds = networks[0]
    unknowns = [session.names[name] for name in SPEEDS]
    for case in random_cases(20):
        put(session, case)
        gradient = speeds.gradient(case)
        steps = np.diag(1e-5 * np.ptp(CASE_RANGES, axis=1))
        rise = np.array([speeds.predict_std(case + h) - speeds.predict_std(case - h) for h in steps])
        std_slopes = (rise / (2 * steps.diagonal()[:, None])).T
        for k, name in enumerate((*CASE, "tas")):
            status, found = session.directional(unknowns, [session.names[name]], [1.0])
            assert status == OK
            if name == "tas":
                np.testing.assert_array_equal(found, [0, 0, 0, 0, 1, -1])
                continue
            unit = M_S_PER_KT / SI[k]
            own = gradient[:, k] * unit
            np.testing.assert_allclose(found[:2], own, rtol=1e-11, atol=1e-13)
            np.testing.assert_allclose(found[4:], [-own[0], own[1]], rtol=1e-11, atol=1e-13)
            np.testing.assert_allclose(np.array(found[2:4]) / unit, std_slopes[:, k], rtol=1e-3, atol=1e-6)


def test_adjoint_derivatives_are_the_transpose(folders):
    with SESSIONS[3](folders[3], "cs") as session:
        session.initialize()
        put(session, random_cases(1)[0])
        unknowns, knowns = ([session.names[n] for n in names] for names in (SPEEDS, (*CASE, "tas")))
        columns = [session.directional(unknowns, [known], [1.0])[1] for known in knowns]
        seed = np.random.default_rng(1).normal(size=len(unknowns))
        status, found = session.adjoint(unknowns, knowns, seed)
        assert status == OK
        np.testing.assert_allclose(found, columns @ seed, rtol=1e-13)


class TestBadInput:
    @pytest.mark.parametrize(
        ("values", "sentence"),
        [
            ({"rudder__lower": 0.2, "rudder__upper": 0.1}, "rudder.lower is above rudder.upper"),
            ({"altitude": float("nan")}, "altitude was given as nan, allowed is a finite number"),
            ({"altitude": 1.7e308, "tas": -1.7e308}, "not finite"),
        ],
    )
    def test_step_is_discarded(self, folders, fmi, values, sentence):
        with SESSIONS[fmi](folders[fmi], "cs") as session:
            session.initialize()
            assert session.step(0.0, 0.1) == OK
            before = session.get_named(*SPEEDS)
            session.set_named(**values)
            assert session.step(0.1, 0.1) == DISCARD
            assert sentence in " ".join(session.texts())
            status, after = session.get([session.names[name] for name in SPEEDS])
            assert (status, after) == (DISCARD, before)
            put(session, random_cases(1)[0])
            assert session.step(0.1, 0.1) == OK

    def test_networks_missing(self, tmp_path):
        with pytest.raises(InputError, match="3 networks were given for the surrogate FMU: give speeds and throttle"):
            build("surrogate-native", tmp_path, [tmp_path] * 3)


def test_casadi_jacobian(native_surrogates, networks, fmi):
    """CasADi's Jacobian over model exchange is made of the FMU's directional derivatives."""
    model = ca.DaeBuilder("surrogate", str(native_surrogates[fmi]))
    model.set_y(list(SPEEDS))  # it reads Booleans as numbers, which an FMU refuses
    results = model.create("results", ["u"], ["y"])
    jacobian = results.factory("slopes", ["u"], ["jac:y:u"])
    rows, columns = ([group.index(n) for n in names] for group, names in ((model.y(), SPEEDS[:2]), (model.u(), CASE)))
    for case in random_cases(10):
        u = np.zeros(len(model.u()))
        u[columns] = case * SI
        np.testing.assert_allclose(results(u).full()[rows, 0] / M_S_PER_KT, networks[0].predict(case), rtol=1e-11)
        slopes = jacobian(u).full()[np.ix_(rows, columns)] * SI / M_S_PER_KT
        np.testing.assert_allclose(slopes, networks[0].gradient(case), rtol=1e-9, atol=1e-12)
