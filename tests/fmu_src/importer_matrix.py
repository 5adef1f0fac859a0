"""Every FMU in every importer: the same flight or case, each in a process of its own, printed as a table.

python -m tests.fmu_src.importer_matrix
"""

import json
import subprocess
import sys
import tempfile
import zipfile
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

import fmpy
import numpy as np

from gtm_fmu.client import FmuClient

STEP_S, STEPS = 0.02, 100
FLIGHT = ("control.elevator", 0.08, ("state.u", "state.w", "state.q", "state.altitude", "path.gamma"))
CASES = {
    "dynamics": FLIGHT,
    "dynamics-native": FLIGHT,
    "dynamics-native3": FLIGHT,
    "surrogate": ("gamma", 0.05, ("v_min", "v_max", "v_min_std", "margin.fast")),
}
"""Input and its value from the start, outputs after `STEPS` steps, by the FMU's short name."""

# Programs find `path`, `name`, `value`, `outputs`, `references`, and leave `values`.
FMPY = f"""
import fmpy
result = fmpy.simulate_fmu(path, stop_time={STEP_S * STEPS}, step_size={STEP_S}, output_interval={STEP_S},
                           start_values={{name: value}}, output=outputs, fmi_type=kind, relative_tolerance=1e-8)
values = [float(result[output][-1]) for output in outputs]
"""
COSIM = f"""
from libcosimpy.CosimExecution import CosimExecution
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
CASADI = f"""
import casadi as ca
import numpy as np

model = ca.DaeBuilder("gtm", path)
rates, results = model.create("rates", ["x", "u"], ["ode"]), model.create("results", ["x", "u"], ["y"])
x, u = np.array(model.start(model.x())), np.array(model.start(model.u()))
u[model.u().index(name)] = value
f, h = lambda x: rates(x, u).full()[:, 0], 0.005
for _ in range(round({STEP_S * STEPS} / h)):
    k1 = f(x)
    k2 = f(x + h / 2 * k1)
    k3 = f(x + h / 2 * k2)
    x = x + h / 6 * (k1 + 2 * k2 + 2 * k3 + f(x + h * k3))
y = results(x, u).full()[:, 0]
values = [float(y[model.y().index(output)]) for output in outputs]
"""


@dataclass(frozen=True)
class Tool:
    """An importer: its package, program, kind of simulation, and how near its own method comes."""

    package: str
    program: str
    kind: str = "CoSimulation"
    tolerance: float = 1e-12


TOOLS = {
    "FMPy CS": Tool("fmpy", FMPY),
    "FMPy ME": Tool("fmpy", FMPY, "ModelExchange", 1e-4),
    "ecospy": Tool("ecospy", ECOS),
    "libcosimpy": Tool("libcosimpy", COSIM),
    "CasADi": Tool("casadi", CASADI, "ModelExchange", 1e-10),
}


def is_offered(tool: str, path: Path) -> bool:
    """Whether the FMU has the kind of simulation that a tool does."""
    description = fmpy.read_model_description(path, validate=False)
    interfaces = {"CoSimulation": description.coSimulation, "ModelExchange": description.modelExchange}
    return interfaces[TOOLS[tool].kind] is not None


def run(tool: str, path: Path, case: tuple) -> tuple[list[float] | None, str, int]:
    """Values, what the tool printed and its exit code (negative: the signal that ended it)."""
    name, value, outputs = case
    variables = fmpy.read_model_description(path, validate=False).modelVariables
    references = {variable.name: variable.valueReference for variable in variables}
    given = {"path": str(path), "name": name, "value": value, "outputs": outputs, "kind": TOOLS[tool].kind}
    given["references"] = {variable: references[variable] for variable in (*outputs, name)}
    with tempfile.TemporaryDirectory() as folder:
        script, result = Path(folder, "importer.py"), Path(folder, "result.json")
        script.write_text(
            f"import json\nglobals().update({given!r})\n{TOOLS[tool].program}\n"
            f"json.dump(values, open({str(result)!r}, 'w'))\n"
        )
        ended = subprocess.run([sys.executable, script], capture_output=True, text=True, cwd=folder)
        values = json.loads(result.read_text()) if result.exists() and ended.returncode == 0 else None
        return values, ended.stdout + ended.stderr, ended.returncode


def crashes_without_binary(tool: str, path: Path, case: tuple) -> bool:
    """Whether a tool is ended by a signal before it can have called an FMU, which then is its own fault."""
    with tempfile.TemporaryDirectory() as folder:
        bare = Path(folder, path.name)
        with zipfile.ZipFile(path) as archive, zipfile.ZipFile(bare, "w") as copy:
            for name in archive.namelist():
                if not name.startswith("binaries/"):
                    copy.writestr(name, archive.read(name))
        return run(tool, bare, case)[2] < 0


def expected_values(path: Path, case: tuple) -> np.ndarray:
    """What this project's client gets from an FMI 2.0 co-simulation FMU."""
    name, value, outputs = case
    with FmuClient(path) as fmu:
        fmu.set((name,), [value])
        for _ in range(STEPS):
            fmu.step(STEP_S)
        return fmu.get(outputs)


def verdict(tool: str, path: Path, case: tuple, expected: np.ndarray, tolerance: float | None = None) -> str:
    """``yes``, or in a few words why not; the tolerance is the tool's own unless another is given."""
    if find_spec(TOOLS[tool].package) is None:
        return "not installed"
    if not is_offered(tool, path):
        return "no model exchange"
    values, printed, code = run(tool, path, case)
    if values is not None:
        tolerance = tolerance or TOOLS[tool].tolerance
        is_equal = np.allclose(values, expected, rtol=tolerance, atol=tolerance)
        return "yes" if is_equal else f"other values: {values}"
    if "libtbb" in printed:
        return "needs libtbb12"
    if code < 0 and crashes_without_binary(tool, path, case):
        return "its own fault"
    return f"fails: {printed.strip().splitlines()[-1] if printed.strip() else code}"


def main() -> None:
    """Build the FMUs and print the table."""
    from study.fmus import build_fmu

    with tempfile.TemporaryDirectory() as folder:
        paths = {name: build_fmu(name, folder) for name in CASES}
        expected = {name: expected_values(paths[name], CASES[name]) for name in ("dynamics", "surrogate")}
        rows = [["", *TOOLS]]
        for name, path in paths.items():
            reference = expected["surrogate" if name == "surrogate" else "dynamics"]
            rows.append([path.name, *(verdict(tool, path, CASES[name], reference) for tool in TOOLS)])
    widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
    for row in rows:
        print("  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip())
    print("its own fault: the tool is ended by a signal also when the FMU has no binary that it could have called")


if __name__ == "__main__":
    main()
