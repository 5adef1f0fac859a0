"""Other importers load the FMUs, step them and get what FMPy gets: 2 s after a step of one input."""

import json
import subprocess
import sys
from importlib.util import find_spec

import numpy as np
import pytest

from gtm_fmu.client import FmuClient

STEP_S, STEPS = 0.02, 100
MODELS = {
    "dynamics": ("control.elevator", 0.08, ("state.u", "state.w", "state.q", "state.altitude", "path.gamma")),
    "surrogate": ("gamma", 0.05, ("v_min", "v_max", "v_min_std", "margin.fast")),
}
"""Input and its value, outputs."""

COSIM = f"""
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimManipulator import CosimManipulator
from libcosimpy.CosimObserver import CosimObserver
from libcosimpy.CosimSlave import CosimLocalSlave

execution = CosimExecution.from_step_size(step_size=int({STEP_S} * 1e9))
index = execution.add_local_slave(CosimLocalSlave(fmu_path=path, instance_name="gtm"))
execution.real_initial_value(index, references[name], value)
observer = CosimObserver.create_last_value()
execution.add_observer(observer)
assert execution.step({STEPS})
values = list(observer.last_real_values(index, [references[output] for output in outputs]))
"""
ECOS = f"""
from ecospy.EcosSimulation import EcosSimulation
from ecospy.EcosSimulationStructure import EcosSimulationStructure

with EcosSimulationStructure() as structure:
    structure.add_model("gtm", path)
    structure.add_parameter_set("start", {{f"gtm::{{name}}": value}})
    with EcosSimulation(structure=structure, step_size={STEP_S}) as simulation:
        simulation.init(parameter_set="start")
        simulation.step({STEPS})
        values = [simulation.get_real(f"gtm::{{output}}") for output in outputs]
"""


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize(
    ("package", "program"), [("libcosimpy", COSIM), ("ecospy", ECOS)], ids=["libcosimpy", "ecospy"]
)
def test_same_result_as_fmpy(package, program, model, request, tmp_path):
    if find_spec(package) is None:
        pytest.skip(f"{package} is not installed")
    path = request.getfixturevalue(f"{model}_fmu")
    name, value, outputs = MODELS[model]
    with FmuClient(path) as fmu:
        before = fmu.get(outputs)
        fmu.set((name,), [value])
        for _ in range(STEPS):
            fmu.step(STEP_S)
        expected = fmu.get(outputs)
        references = {variable: fmu.reference(variable) for variable in (*outputs, name)}
    assert (np.abs(expected - before) > 0.01).all()
    given = {"path": str(path), "outputs": outputs, "references": references, "name": name, "value": value}
    script, result = tmp_path / "importer.py", tmp_path / "result.json"
    script.write_text(
        f"import json\nglobals().update({given!r})\n{program}\njson.dump(values, open({str(result)!r}, 'w'))\n"
    )
    run = subprocess.run([sys.executable, script], capture_output=True, text=True, cwd=tmp_path)
    if "libtbb" in run.stderr:
        pytest.skip(f"{package} needs the system library libtbb12")
    assert run.returncode == 0, run.stdout + run.stderr
    np.testing.assert_allclose(json.loads(result.read_text()), expected, rtol=1e-12, atol=1e-15)
