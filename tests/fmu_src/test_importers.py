"""Other importers load the FMUs, run them and get what FMPy gets: 2 s after a step of one input."""

import re
import subprocess
import sys
from functools import cache

import casadi as ca
import fmpy
import numpy as np
import pytest

from fmu_src.description.dynamics_variables import dynamics_description
from gtm_fmu import core
from tests.fmu_src.importer_matrix import (
    CASES,
    CHECKS,
    COLUMNS,
    SELF_FAULT,
    SIBLINGS,
    check,
    expected_by_siblings,
    verdicts,
)

pytestmark = pytest.mark.slow

GROUPS = dynamics_description().groups
X_SI, U_SI, Y_SI = (np.array([variable.scale for variable in GROUPS[g]]) for g in ("states", "controls", "outputs"))
STEPS_ONLY = (*SIBLINGS, "aircraft-native", "aircraft-native3")
OTHERWISE = {(tool, model): "no model exchange" for tool in ("FMPy ME", "CasADi") for model in STEPS_ONLY}
OTHERWISE |= {("libcosimpy", model): SELF_FAULT for model in CASES if model.endswith("3")}
"""Cells of the table that are not ``yes``."""


@pytest.fixture(scope="module")
def cells(
    dynamics_fmu,
    native_fmus,
    aircraft_fmus,
    envelope_fmus,
    manoeuvre_fmus,
    surrogate_fmu,
    native_surrogates,
    thrust_map_fmus,
):
    """A function that fills a column of the table, once."""
    paths = {"dynamics": dynamics_fmu, **aircraft_fmus, "envelope": envelope_fmus["python"], "surrogate": surrogate_fmu}
    paths["manoeuvre"] = manoeuvre_fmus["python"]
    native = {"dynamics": native_fmus, "envelope": envelope_fmus, "surrogate": native_surrogates}
    native["manoeuvre"] = manoeuvre_fmus
    for model, built in (native | {"thrust-map": thrust_map_fmus}).items():
        paths |= {f"{model}-native": built[2], f"{model}-native3": built[3]}
    assert paths.keys() == CASES.keys()
    expected = expected_by_siblings(paths)

    @cache
    def column(name: str) -> dict[str, str]:
        if name in CHECKS:
            return {model: check(name, path) for model, path in paths.items()}
        return verdicts(name, paths, expected)

    return column


@pytest.mark.parametrize("model", CASES)
@pytest.mark.parametrize("column", COLUMNS)
def test_cell_of_the_table(column, model, cells, record_property):
    found = cells(column)[model]
    record_property("cell", [column, model, found])
    if found in ("not installed", "needs libtbb12"):
        pytest.skip(f"{column}: {found}")
    assert found == OTHERWISE.get((column, model), "yes")


@pytest.mark.parametrize("fmi", [2, 3])
class TestCasadi:
    """CasADi's DaeBuilder over model exchange: its Jacobians are made of our directional derivatives."""

    @pytest.fixture
    def model(self, native_fmus, fmi):
        return ca.DaeBuilder("gtm", str(native_fmus[fmi]))

    def test_jacobians(self, model):
        rates, results = (model.create(part, ["x", "u"], [part]) for part in ("ode", "y"))
        jacobians = [
            function.factory("slopes", ["x", "u"], [f"jac:{part}:x", f"jac:{part}:u"])
            for function, part in ((rates, "ode"), (results, "y"))
        ]
        outputs = [model.y().index(variable.name) for variable in GROUPS["outputs"]]
        rng = np.random.default_rng(11)
        known = np.append(X_SI, U_SI)
        for _ in range(10):
            x = rng.uniform(-1, 1, 12) * (30, 20, 20, 1, 1, 1, 1, 3, 10000, 1, 1, 3) + np.eye(12)[0] * 150
            u = rng.uniform(-1, 1, 4) * (29, 19, 29, 49) + (0, 0, 0, 50)
            si = x * X_SI, u * U_SI
            np.testing.assert_allclose(rates(*si).full()[:, 0] / X_SI, core.derivatives(x, u), rtol=1e-9, atol=1e-9)
            slopes = np.hstack([part.full() for part in jacobians[0](*si)])
            np.testing.assert_allclose(slopes * known / X_SI[:, None], core.jacobian(x, u)[1], rtol=1e-9, atol=1e-9)
            slopes = np.hstack([part.full() for part in jacobians[1](*si)])[outputs]
            exact = core.outputs_jacobian(x, u)[1]
            np.testing.assert_allclose(slopes * known / Y_SI[:, None], exact, rtol=1e-9, atol=1e-9)

    def test_trim_of_the_specification(self, model):
        """IPOPT over the imported FMU finds SPEC 13's level trim at 800 ft and alpha 3 deg from a guess."""
        rates, results = (model.create(part, ["x", "u"], [part]) for part in ("ode", "y"))
        alpha, gamma = (model.y().index(name) for name in ("air.alpha", "path.gamma"))
        free = [0, 1, 2, 9, 10]  # u v w phi theta
        x0 = np.array(model.start(model.x()))
        known = x0.copy()
        known[free] = 0
        y = ca.MX.sym("y", 9)
        x = ca.DM(known) + ca.DM(np.eye(12)[:, free]) @ y[:5]
        F, out = rates(x, y[5:]), results(x, y[5:])
        problem = {"x": y, "f": y[1] ** 2, "g": ca.vertcat(F[:6], out[alpha], out[gamma])}
        options = {"ipopt.print_level": 0, "print_time": False, "ipopt.sb": "yes", "ipopt.tol": 1e-10}
        solver = ca.nlpsol("trim", "ipopt", problem, options | {"ipopt.hessian_approximation": "limited-memory"})
        target = np.append(np.zeros(6), [np.radians(3), 0])
        guess = [45, 0.5, 3, 0.02, 0.08, *(np.array([1, 1, 1, 50]) * U_SI)]
        solution = solver(x0=guess, lbg=target, ubg=target)
        assert solver.stats()["success"]
        found = solution["x"].full()[:, 0]
        np.testing.assert_allclose(found[5:] / U_SI, [2.414942, -0.394239, 0.004192, 39.839881], atol=2e-4)
        assert np.hypot(found[0], found[2]) / 0.3048 == pytest.approx(164.14225, abs=1e-3)


SSD = """<?xml version="1.0" encoding="UTF-8"?>
<ssd:SystemStructureDescription name="flight" version="1.0"
    xmlns:ssd="http://ssp-standard.org/SSP1/SystemStructureDescription"
    xmlns:ssv="http://ssp-standard.org/SSP1/SystemStructureParameterValues">
  <ssd:System name="system"><ssd:Elements>
    <ssd:Component name="gtm" type="application/x-fmu-sharedlibrary" source="{source}">
      <ssd:ParameterBindings><ssd:ParameterBinding><ssd:ParameterValues>
        <ssv:ParameterSet version="1.0" name="initial"><ssv:Parameters>
          <ssv:Parameter name="{name}"><ssv:Real value="3000"/></ssv:Parameter>
        </ssv:Parameters></ssv:ParameterSet>
      </ssd:ParameterValues></ssd:ParameterBinding></ssd:ParameterBindings>
    </ssd:Component>
  </ssd:Elements></ssd:System>
  <ssd:DefaultExperiment startTime="0.0"/>
</ssd:SystemStructureDescription>
"""
FROM_SSP = """
import sys
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimObserver import CosimObserver

execution = CosimExecution.from_ssp_file(sys.argv[1], step_size=10_000_000)
observer = CosimObserver.create_last_value()
execution.add_observer(observer)
assert execution.step(1)
print('altitude', observer.last_real_values(0, [int(sys.argv[2])])[0])
"""


@pytest.mark.parametrize("model", ["dynamics-native", "aircraft-native"])
def test_libcosim_starts_from_parameters(model, built, tmp_path):
    """Of an SSP archive it sets inputs and parameters, and no state itself."""
    pytest.importorskip("libcosimpy")
    path = built(model)
    (tmp_path / path.name).symlink_to(path)
    (tmp_path / "SystemStructure.ssd").write_text(SSD.format(source=path.name, name="start.altitude"))
    (reference,) = (
        v.valueReference for v in fmpy.read_model_description(path).modelVariables if v.name == "state.altitude"
    )
    run = subprocess.run(
        [sys.executable, "-c", FROM_SSP, tmp_path, str(reference)], capture_output=True, text=True, check=True
    )
    (altitude,) = re.findall(r"^altitude (.*)", run.stdout, re.MULTILINE)
    assert float(altitude) == pytest.approx(3000.0, abs=0.01)
