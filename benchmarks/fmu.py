"""Speed of the native FMUs beside the Python FMUs, JSBSim's 737 and FMPy's own floor, all in one run.

    python benchmarks/fmu.py

A step is 0.01 s in two Runge-Kutta parts of 0.005 s, with all four controls set before and twelve states read after
it, by the same ctypes calls for both FMUs. JSBSim steps its own 737 by `run()`, its only way to step, with 0.01 s. The
floor of FMPy is the same pair of calls into a library whose functions only copy numbers. The overhead of the C wrapper
is measured in C (fmu_overhead.c), and so is a question to the manoeuvre's FMU (manoeuvre_query.c). A step of the
envelope's and of the thrust map's FMUs finds V_min and V_max of a new case. Times are processor time, the best of
several rounds; of these, the median over the cases.
"""

import ctypes
import subprocess
import tempfile
import time
from ctypes import c_double, c_void_p
from pathlib import Path

import fmpy
import jsbsim
import numpy as np
from fmpy.fmi2 import FMU2Model
from table import machine, write_json

from fmu_src import build
from fmu_src.packing.native_fmus import NATIVE_MODELS
from gtm_fmu.aircraft.client import FmuClient
from gtm_fmu.units import M_PER_FT, RAD_PER_DEG

STEP_S, ROUNDS = 0.01, 5
STUB = """
#include <stddef.h>
#include <string.h>
static double x[64];
int fmi2SetContinuousStates(void *c, const double v[], size_t n) { (void)c; memcpy(x, v, n * sizeof *v); return 0; }
int fmi2GetDerivatives(void *c, double v[], size_t n) { (void)c; memcpy(v, x, n * sizeof *v); return 0; }
"""


def best(function, count: int) -> float:
    """Seconds of one call of ``function(count)`` per count, the least of some rounds."""
    taken = []
    for _ in range(ROUNDS):
        start = time.process_time()
        function(count)
        taken.append((time.process_time() - start) / count)
    return min(taken)


def seconds_per_step(path: Path, count: int) -> float:
    """One step of a co-simulation FMU with its inputs and states, by raw ctypes calls."""
    with FmuClient(path) as fmu:
        fmu.step(STEP_S)
        library, component = fmu.instance.dll, ctypes.c_void_p(fmu.instance.component)
        u = fmu.get(fmu.controls)
        controls = (ctypes.c_uint * 4)(*(fmu.reference(name) for name in fmu.controls))
        states = (ctypes.c_uint * 12)(*(fmu.reference(name) for name in fmu.states))
        values, record = (c_double * 4)(*u), (c_double * 12)()
        done = 1

        def steps(n):
            nonlocal done
            for i in range(done, done + n):
                library.fmi2SetReal(component, controls, 4, values)
                library.fmi2DoStep(component, c_double(i * STEP_S), c_double(STEP_S), 1)
                library.fmi2GetReal(component, states, 12, record)
            done += n

        return best(steps, count)


def seconds_per_jsbsim_step(count: int) -> float:
    """One step of JSBSim's 737 in flight."""
    simulation = jsbsim.FGFDMExec(jsbsim.get_default_root_dir())
    simulation.set_debug_level(0)
    simulation.load_model("737")
    simulation.set_dt(STEP_S)
    for name, value in (("ic/h-sl-ft", 10000), ("ic/vc-kts", 250), ("ic/gamma-deg", 0)):
        simulation[name] = value
    simulation.run_ic()

    def steps(n):
        for _ in range(n):
            simulation.run()

    return best(steps, count)


def seconds_per_derivative(library: Path | None, folder: Path, count: int) -> float:
    """States set and derivatives read through FMPy, of the FMU in a folder or of another library."""
    description = fmpy.read_model_description(folder, validate=False)
    fmu = FMU2Model(
        guid=description.guid,
        unzipDirectory=str(folder),
        modelIdentifier=description.modelExchange.modelIdentifier,
        instanceName="one",
        **({} if library is None else {"libraryPath": str(library)}),
    )
    if library is None:
        fmu.instantiate()
        fmu.setupExperiment()
        fmu.enterInitializationMode()
        fmu.exitInitializationMode()
        fmu.enterContinuousTimeMode()
    else:
        fmu.component = c_void_p(1)
    x, rates = (c_double * 12)(), (c_double * 12)()
    starts = [variable.start for variable in description.modelVariables[:12]]
    x[:] = [float(start) for start in starts]

    def evaluations(n):
        for i in range(n):
            x[0] = 50.0 + i % 2
            fmu.setContinuousStates(x, 12)
            fmu.getDerivatives(rates, 12)

    return best(evaluations, count)


def milliseconds_per_envelope(path: Path, cases: np.ndarray) -> float:
    """One step of an envelope FMU to altitude in ft, gamma and limits of the rudder in deg, all new."""
    names, taken = ("altitude", "gamma", "rudder.lower", "rudder.upper"), []
    with FmuClient(path) as fmu:
        for case in cases:
            fmu.set(names, case * (M_PER_FT, RAD_PER_DEG, RAD_PER_DEG, RAD_PER_DEG))
            start = time.process_time()
            fmu.step(STEP_S)
            taken.append(time.process_time() - start)
    return 1e3 * float(np.median(taken))


def envelope_cases() -> dict[str, np.ndarray]:
    """Random cases of jams, and of ranges of the rudder."""
    cases = np.random.default_rng(0).uniform((0, -10, -30, -30), (36000, 6, 30, 30), (60, 4))
    jams, ranges = cases.copy(), cases
    jams[:, 3] = jams[:, 2]
    ranges[:, 2:].sort(axis=1)
    return {"jam": jams, "range": ranges}


def compiled(folder: Path, files: list[str], name: str, *flags: str) -> Path:
    """A program or library of C files."""
    subprocess.run(["cc", "-std=c11", "-O2", "-I.", *flags, "-o", name, *files, "-lm"], cwd=folder, check=True)
    return folder / name


def stub_library(folder: Path) -> Path:
    """A library with all functions of FMI 2.0, which do nothing but for two that copy."""
    names = [name for name in dir(FMU2Model) if name.startswith("fmi2")]
    others = [f"int {name}(void) {{ return 0; }}" for name in names if f"int {name}(" not in STUB]
    (folder / "stub.c").write_text(STUB + "\n".join(others) + "\n")
    return compiled(folder, ["stub.c"], "stub.so", "-shared", "-fPIC")


def printed_numbers(model: str, host: str, folder: Path) -> list[float]:
    """What a C program beside this file prints that holds a native FMU."""
    sources = NATIVE_MODELS[model](()).all_sources() | {host: Path(__file__).with_name(host).read_bytes()}
    for name, content in sources.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(content)
    program = compiled(folder, sorted(name for name in sources if name.endswith(".c")), "host")
    return [
        float(word) for word in subprocess.run([program], capture_output=True, text=True, check=True).stdout.split()
    ]


def main() -> None:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        native, python = build("dynamics-native", folder), build("dynamics", folder)
        unpacked = Path(fmpy.extract(native, folder / "native"))
        (folder / "c").mkdir()
        steps = {
            "native": seconds_per_step(native, 20_000),
            "python": seconds_per_step(python, 2_000),
            "jsbsim": seconds_per_jsbsim_step(2_000),
        }
        derivative = seconds_per_derivative(None, unpacked, 50_000)
        floor = seconds_per_derivative(stub_library(folder), unpacked, 50_000)
        alone, through = printed_numbers("dynamics-native", "fmu_overhead.c", folder / "c")
        questions = printed_numbers("manoeuvre-native", "manoeuvre_query.c", folder / "manoeuvre")
        envelopes = {name: build(name, folder) for name in ("envelope", "envelope-native", "thrust-map-native")}
        found = {
            f"{name.replace('-', '_')}_ms_per_{kind}": round(milliseconds_per_envelope(path, cases), 3)
            for name, path in envelopes.items()
            for kind, cases in envelope_cases().items()
        }
    result = {
        "machine": f"{machine()}, JSBSim {jsbsim.__version__}",
        "native_us_per_step": round(1e6 * steps["native"], 2),
        "native_real_time_factor": round(STEP_S / steps["native"]),
        "python_fmu_us_per_step": round(1e6 * steps["python"], 2),
        "jsbsim_737_us_per_step": round(1e6 * steps["jsbsim"], 2),
        "times_faster_than_python_fmu": round(steps["python"] / steps["native"], 1),
        "times_faster_than_jsbsim": round(steps["jsbsim"] / steps["native"], 1),
        "fmpy_us_per_derivative": round(1e6 * derivative, 2),
        "fmpy_floor_us": round(1e6 * floor, 2),
        "c_model_ns_per_step": alone,
        "c_wrapper_ns_per_step": round(through - alone, 1),
        "manoeuvre_us_per_question_jam": questions[0],
        "manoeuvre_us_per_question_range": questions[1],
    } | found
    write_json("fmu", result)
    for name, value in result.items():
        print(f"| {name} | {value} |")


if __name__ == "__main__":
    main()
