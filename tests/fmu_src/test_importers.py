"""Other importers load the FMU, step it and get what FMPy gets: 2 s after an elevator step."""

import json
import subprocess
import sys
from importlib.util import find_spec

import numpy as np
import pytest

from gtm_fmu.client import FmuClient

OUTPUTS = ("state.u", "state.w", "state.q", "state.theta", "state.altitude", "air.alpha", "path.gamma")
ELEVATOR, STEP_S, STEPS = 0.08, 0.02, 100

COSIM = f"""
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimManipulator import CosimManipulator
from libcosimpy.CosimObserver import CosimObserver
from libcosimpy.CosimSlave import CosimLocalSlave

execution = CosimExecution.from_step_size(step_size=int({STEP_S} * 1e9))
index = execution.add_local_slave(CosimLocalSlave(fmu_path=path, instance_name="gtm"))
execution.real_initial_value(index, references["control.elevator"], {ELEVATOR})
observer = CosimObserver.create_last_value()
execution.add_observer(observer)
assert execution.step({STEPS})
values = list(observer.last_real_values(index, [references[name] for name in outputs]))
"""
ECOS = f"""
from ecospy.EcosSimulation import EcosSimulation
from ecospy.EcosSimulationStructure import EcosSimulationStructure

with EcosSimulationStructure() as structure:
    structure.add_model("gtm", path)
    structure.add_parameter_set("start", {{"gtm::control.elevator": {ELEVATOR}}})
    with EcosSimulation(structure=structure, step_size={STEP_S}) as simulation:
        simulation.init(parameter_set="start")
        simulation.step({STEPS})
        values = [simulation.get_real(f"gtm::{{name}}") for name in outputs]
"""


@pytest.mark.parametrize(
    ("package", "program"), [("libcosimpy", COSIM), ("ecospy", ECOS)], ids=["libcosimpy", "ecospy"]
)
def test_same_result_as_fmpy(package, program, dynamics_fmu, tmp_path):
    if find_spec(package) is None:
        pytest.skip(f"{package} is not installed")
    with FmuClient(dynamics_fmu, start_values={"control.elevator": ELEVATOR}) as fmu:
        for _ in range(STEPS):
            fmu.step(STEP_S)
        expected = fmu.get(OUTPUTS)
        references = {name: fmu.reference(name) for name in (*OUTPUTS, "control.elevator")}
    given = {"path": str(dynamics_fmu), "outputs": OUTPUTS, "references": references}
    script = tmp_path / "importer.py"
    result = tmp_path / "result.json"
    script.write_text(
        f"import json\nglobals().update({given!r})\n{program}\njson.dump(values, open({str(result)!r}, 'w'))\n"
    )
    run = subprocess.run([sys.executable, script], capture_output=True, text=True, cwd=tmp_path)
    if "libtbb" in run.stderr:
        pytest.skip(f"{package} needs the system library libtbb12")
    assert run.returncode == 0, run.stdout + run.stderr
    np.testing.assert_allclose(json.loads(result.read_text()), expected, rtol=1e-12, atol=1e-15)
    assert abs(expected[OUTPUTS.index("state.theta")] - 0.05236) > 0.05
