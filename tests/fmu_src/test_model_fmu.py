"""A user's own model as a native FMU: names and units of its own, values of its own `predict`."""

from dataclasses import replace

import fmpy
import numpy as np
import pytest
from fmpy.validation import validate_fmu
from lxml import etree

from fmu_src.packing.model_fmu import build_model
from gtm_fmu.aircraft.client import FmuClient
from gtm_fmu.errors import InputError
from surrogate import Network, Variable
from tests.fmu_src.native_session import OK, SESSIONS
from tests.surrogate.exports.test_exports import INPUTS, MODELS, OUTPUTS, RANGES, X

pytestmark = pytest.mark.slow

NAMES = [variable.name for variable in INPUTS]
RESULTS = [variable.name for variable in OUTPUTS]
SAFE = ["speed_safe", "lift_N_safe"]


@pytest.fixture(
    scope="module", params=[("one hidden layer", 2), ("axes, quadratic", 3)], ids=["network", "local_models"]
)
def built(request, tmp_path_factory):
    """A model, the FMI version, its FMU."""
    name, fmi = request.param
    return MODELS[name], fmi, build_model(MODELS[name], tmp_path_factory.mktemp("own") / "wing.fmu", fmi)


def test_description(built):
    model, fmi, path = built
    assert validate_fmu(str(path)) == []
    assert path.stat().st_size < 100_000
    description = fmpy.read_model_description(path, validate=False)
    assert (description.fmiVersion, description.modelName) == (f"{fmi}.0", "wing")
    deviations = [f"{name}_std" for name in RESULTS] if isinstance(model, Network) else []
    variables = {variable.name: variable for variable in description.modelVariables}
    assert list(variables) == [*NAMES, *RESULTS, *deviations, "in_domain", *SAFE, "time"]
    assert [variables[name].unit for name in SAFE] == ["kn", "N"]
    assert "not above the true one with a probability of at least 0.999" in variables["speed_safe"].description
    assert [variables[name].unit for name in (*NAMES, *RESULTS)] == ["mm", "deg", "1", "N", "kn"]
    assert [float(variables[name].start) for name in NAMES] == RANGES.mean(axis=1).tolist()
    units = {unit.name: unit.baseUnit for unit in description.unitDefinitions}
    assert units["mm"] is None
    assert units["deg"].factor == pytest.approx(np.pi / 180)


def test_values_and_derivatives(built, tmp_path):
    model, fmi, path = built
    folder = fmpy.extract(path, tmp_path)
    with SESSIONS[fmi](folder, "me") as session:
        session.initialize(is_exited=False)
        knowns, unknowns, safe = ([session.names[name] for name in names] for names in (NAMES, RESULTS, SAFE))
        for x in X:
            assert session.set(knowns, x) == OK
            np.testing.assert_allclose(session.get(unknowns)[1], model.predict(x), rtol=1e-11, atol=1e-13)
            np.testing.assert_allclose(session.get(safe)[1], model.predict_safe(x), rtol=1e-11, atol=1e-13)
            if isinstance(model, Network):
                deviations = session.get_named(*(f"{name}_std" for name in RESULTS))
                np.testing.assert_allclose(deviations, model.predict_std(x), rtol=1e-6)
            slopes = np.column_stack([session.directional(unknowns, [known], [1.0])[1] for known in knowns])
            of_safe = np.column_stack([session.directional(safe, [known], [1.0])[1] for known in knowns])
            np.testing.assert_array_equal(of_safe, slopes[::-1])  # the second output's first
            scale = np.ptp(model.target_ranges, axis=1)[:, None] / np.ptp(RANGES, axis=1)
            np.testing.assert_allclose(slopes / scale, model.gradient(x) / scale, rtol=1e-11, atol=1e-12)


def test_domain(tmp_path):
    with FmuClient(build_model(MODELS["without deviations"], tmp_path / "wing.fmu")) as fmu:
        for values, inside in ((RANGES[:, 1], True), (RANGES[:, 0], True), (RANGES[:, 1] + [1, 0, 0], False)):
            fmu.set(NAMES, values)
            assert fmu.get_boolean("in_domain") is inside


def test_documentation_says_where_it_comes_from(tmp_path):
    model = replace(MODELS["without deviations"], provenance={"data": "tunnel <3>"}, metrics={"mse_test": 0.5})
    folder = fmpy.extract(build_model(model, tmp_path / "wing.fmu"), tmp_path)
    page = etree.parse(f"{folder}/documentation/index.html", etree.HTMLParser())
    text = " ".join(page.getroot().itertext())
    assert "data: tunnel <3>" in text
    assert "mse_test: 0.5" in text
    assert "NASA" not in text


def test_names_are_text(tmp_path):
    """Trigraphs, quotes, comments and markup in names and provenance stay what they are, in C, XML and HTML."""
    names = ("v??/", 'a"b\\', "<x */ #1# ??' // \u00fc")
    model = MODELS["without deviations"]
    inputs = tuple(Variable(name, "m") for name in names)
    path = build_model(replace(model, inputs=inputs, provenance={"data": "\udcff.csv"}), tmp_path / "wing.fmu")
    assert validate_fmu(str(path)) == []
    folder = fmpy.extract(path, tmp_path)
    page = etree.parse(f"{folder}/documentation/index.html", etree.HTMLParser()).getroot()
    assert set(names) < {" ".join(code.itertext()) for code in page.iter("code")}
    with SESSIONS[2](folder, "cs") as session:
        session.initialize(is_exited=False)
        for name in names:
            session.set([session.names[name]], [np.nan])
            assert session.texts()[0].startswith(f"{name.replace('#', '##')} was given as nan")


class TestBadInput:
    def test_name(self, tmp_path):
        for name in ("my wing.fmu", "3d.fmu", "wing.zip", "flügel.fmu"):
            with pytest.raises(InputError, match=r"choose letters, digits and _, and the ending \.fmu"):
                build_model(MODELS["one hidden layer"], tmp_path / name)

    @pytest.mark.parametrize(
        ("names", "sentence"),
        [
            (("time", "b", "c"), "two variables called 'time'"),
            (("lift_N_std", "b", "c"), "two variables called 'lift_N_std'"),
            (("a", "in_domain", "c"), "two variables called 'in_domain'"),
            (("a", "b\n", "c"), r"cannot have 'b\\n' as a name"),
            (("a", "b", " "), "cannot have ' ' as a name"),
        ],
    )
    def test_names_of_variables(self, tmp_path, names, sentence):
        model = replace(MODELS["one hidden layer"], inputs=tuple(Variable(name, "m") for name in names))
        with pytest.raises(InputError, match=sentence):
            build_model(model, tmp_path / "wing.fmu")
        assert list(tmp_path.iterdir()) == []
