"""Every FMU in every importer: the same flight or case in each, as a table.

python -m tests.fmu_src.importer_matrix
"""

import json
import subprocess
import sys
import tempfile
import zipfile
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from importlib.resources import files
from importlib.util import find_spec
from pathlib import Path

import fmpy
import numpy as np
from fmpy.validation import validate_fmu
from lxml import etree

from gtm_fmu.aircraft.client import FmuClient

STEP_S, STEPS = 0.02, 100
FLIGHT = ("control.elevator", 0.08, ("state.u", "state.w", "state.q", "state.altitude", "path.gamma"))
LIMITS = ("gamma", 0.05, ("v_min", "v_max", "margin.slow", "margin.fast"))
SAFE_LIMITS = (*LIMITS[:2], (*LIMITS[2], "v_min_safe", "v_max_safe"))
TURN = ("gamma", 0.05, ("trim.alpha", "trim.bank", "margin.throttle.left.upper", "trim.thrust", "turn_rate.greatest"))
SIBLINGS = {"dynamics": FLIGHT, "aircraft": FLIGHT, "envelope": LIMITS, "manoeuvre": TURN, "surrogate": LIMITS}
NATIVE_ONLY = {"thrust-map": SAFE_LIMITS}
CASES = {f"{name}{made}": case for name, case in SIBLINGS.items() for made in ("", "-native", "-native3")}
CASES |= {f"{name}{made}": case for name, case in NATIVE_ONLY.items() for made in ("-native", "-native3")}
"""Input and its value from the start, outputs after `STEPS` steps, by the FMU's short name."""

SELF_FAULT = "its own fault"
NOTE = f"{SELF_FAULT}: the tool is ended by a signal also when the FMU has no binary that it could have called"

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
model.set_y(list(outputs))
x, u = np.array(model.start(model.x())), np.array(model.start(model.u()))
u[model.u().index(name)] = value
if len(x):
    rates, h = model.create("rates", ["x", "u"], ["ode"]), 0.005
    f = lambda x: rates(x, u).full()[:, 0]
    for _ in range(round({STEP_S * STEPS} / h)):
        k1 = f(x)
        k2 = f(x + h / 2 * k1)
        k3 = f(x + h / 2 * k2)
        x = x + h / 6 * (k1 + 2 * k2 + 2 * k3 + f(x + h * k3))
values = model.create("results", ["x", "u"], ["y"])(x, u).full()[:, 0].tolist()
"""
SCRIPT = """
import json, sys, traceback
for given in json.loads(sys.argv[1]):
    globals().update(given)
    try:
        exec(program)
        found = {"values": values}
    except Exception as error:
        found = {"error": " ".join(str(error).split()) or type(error).__name__}
    with open("found.jsonl", "a") as file:
        print(json.dumps(found), file=file)
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
CHECKS = ("schema", "FMPy validate")
COLUMNS = (*CHECKS, *TOOLS)


def check(column: str, path: Path) -> str:
    """``yes``, or the first problem that the schema of the standard or FMPy's validation has."""
    if column == "FMPy validate":
        problems = validate_fmu(str(path))
    else:
        with zipfile.ZipFile(path) as archive:
            document = etree.fromstring(archive.read("modelDescription.xml"))
        fmi = document.get("fmiVersion", "")[0]
        schema = etree.XMLSchema(file=str(files("fmpy") / "schema" / f"fmi{fmi}" / f"fmi{fmi}ModelDescription.xsd"))
        problems = [] if schema.validate(document) else [str(schema.error_log.last_error)]
    return problems[0] if problems else "yes"


def is_offered(tool: str, path: Path) -> bool:
    """Whether the FMU has the kind of simulation that a tool does."""
    description = fmpy.read_model_description(path, validate=False)
    interfaces = {"CoSimulation": description.coSimulation, "ModelExchange": description.modelExchange}
    return interfaces[TOOLS[tool].kind] is not None


def _given(tool: str, path: Path, case: tuple) -> dict:
    name, value, outputs = case
    variables = fmpy.read_model_description(path, validate=False).modelVariables
    references = {variable.name: variable.valueReference for variable in variables}
    asked = {variable: references[variable] for variable in (*outputs, name)}
    given = {"path": str(path), "name": name, "value": value, "outputs": outputs, "references": asked}
    return given | {"program": TOOLS[tool].program, "kind": TOOLS[tool].kind}


def run(tool: str, jobs: list[tuple[Path, tuple]]) -> list[dict]:
    """What a tool finds for FMUs with their cases, one after the other in one process.

    Each has ``values``, or an ``error``, or the ``signal`` that ended the process; then a new one takes the rest.
    """
    found: list[dict] = []
    while len(found) < len(jobs):
        given = json.dumps([_given(tool, path, case) for path, case in jobs[len(found) :]])
        with tempfile.TemporaryDirectory() as folder:
            command = [sys.executable, "-c", SCRIPT, given]
            ended = subprocess.run(command, capture_output=True, text=True, cwd=folder)
            lines = Path(folder, "found.jsonl")
            found += [json.loads(line) for line in lines.read_text().splitlines()] if lines.exists() else []
        if len(found) < len(jobs):
            found.append({"signal": -ended.returncode, "error": ended.stderr.strip()[-300:]})
    return found


def crashes_without_binary(tool: str, path: Path, case: tuple) -> bool:
    """Whether a tool is ended by a signal before it can have called an FMU, which then is its own fault."""
    with tempfile.TemporaryDirectory() as folder:
        bare = Path(folder, path.name)
        with zipfile.ZipFile(path) as archive, zipfile.ZipFile(bare, "w") as copy:
            for name in archive.namelist():
                if not name.startswith("binaries/"):
                    copy.writestr(name, archive.read(name))
        return run(tool, [(bare, case)])[0].get("signal", 0) > 0


def expected_values(path: Path, case: tuple) -> np.ndarray:
    """What this project's client gets from an FMI 2.0 co-simulation FMU."""
    name, value, outputs = case
    with FmuClient(path) as fmu:
        fmu.set((name,), [value])
        for _ in range(STEPS):
            fmu.step(STEP_S)
        return fmu.get(outputs)


def expected_by_siblings(paths: Mapping[str, Path]) -> dict[str, np.ndarray]:
    """What the FMU in Python of the same model gives, or else the native one of FMI 2.0, by the FMUs' short names."""
    siblings = {name: expected_values(paths[name], case) for name, case in SIBLINGS.items()}
    siblings |= {name: expected_values(paths[f"{name}-native"], case) for name, case in NATIVE_ONLY.items()}
    return {name: siblings[name.partition("-native")[0]] for name in CASES}


def verdicts(tool: str, paths: Mapping[str, Path], expected: Mapping[str, np.ndarray]) -> dict[str, str]:
    """``yes``, or in a few words why not, by the FMUs' short names."""
    if find_spec(TOOLS[tool].package) is None:
        return dict.fromkeys(paths, "not installed")
    offered = [name for name, path in paths.items() if is_offered(tool, path)]
    results = dict.fromkeys(paths, "no model exchange")
    for name, found in zip(offered, run(tool, [(paths[name], CASES[name]) for name in offered]), strict=True):
        if "values" in found:
            is_equal = np.allclose(
                found["values"], expected[name], rtol=TOOLS[tool].tolerance, atol=TOOLS[tool].tolerance
            )
            results[name] = "yes" if is_equal else f"other values: {found['values']}"
        elif "libtbb" in found["error"]:
            results[name] = "needs libtbb12"
        elif found.get("signal", 0) > 0 and crashes_without_binary(tool, paths[name], CASES[name]):
            results[name] = SELF_FAULT
        else:
            results[name] = f"fails: {found['error']}"
    return results


def table(cells: Mapping[tuple[str, str], str], models: Iterable[str]) -> str:
    """The verdicts by column and FMU, as text."""
    rows = [["", *COLUMNS], *([model, *(cells.get((column, model), "") for column in COLUMNS)] for model in models)]
    widths = [max(len(row[place]) for row in rows) for place in range(len(rows[0]))]
    lines = ["  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip() for row in rows]
    return "\n".join([*lines, NOTE])


def main() -> None:
    """Build the FMUs and print the table."""
    from fmu_src.fmus import build_fmu

    with tempfile.TemporaryDirectory() as folder:
        paths = {name: build_fmu(name, folder) for name in CASES}
        expected = expected_by_siblings(paths)
        cells = {(column, name): check(column, path) for column in CHECKS for name, path in paths.items()}
        for tool in TOOLS:
            cells |= {(tool, name): verdict for name, verdict in verdicts(tool, paths, expected).items()}
    print(table(cells, CASES))


if __name__ == "__main__":
    main()
