"""Speed of the rudder's emulator: in exported C, in batches from Python, as an FMU through FMPy, and of its loading.

    python benchmarks/emulator.py

All evaluate the same 4-10-2 network. Peers of the same run: onnxruntime and scikit-learn's MLPRegressor with the same
weights, the FMU of pythonfmu, and FMPy's own floor, the same calls into a library whose functions only copy numbers.
Times are processor time, the best of several rounds. A rate over two cores is that of two threads at work together, two
over the processor time of a case: the clock's rate where nothing else runs.
"""

import ctypes
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import fmpy
import numpy as np
import onnxruntime
from fmpy.fmi2 import FMU2Slave
from sklearn.neural_network import MLPRegressor
from table import row, write

from fmu_src.fmus import build_fmu
from gtm_fmu.aircraft.client import FmuClient
from surrogate import Network
from surrogate.exports.c_source import c_header, c_source
from surrogate.exports.closed_form import closed_form
from surrogate.exports.onnx_model import onnx_model
from surrogate.rudder.emulator import RudderEmulator
from surrogate.rudder.names import PAPER, SPEEDS_FILE
from surrogate.scaling import to_symmetric

ROUNDS, BATCH, BLOCK, THREADS = 5, 1_000_000, 4096, 2
INPUTS = ("altitude", "gamma", "rudder.lower", "rudder.upper", "tas")
SPEEDS, DEVIATIONS = ("v_min", "v_max", "margin.slow", "margin.fast"), ("v_min_std", "v_max_std")
STUB = """
#include <stddef.h>
#include <string.h>
static double x[64];
int fmi2SetReal(void *c, const unsigned r[], size_t n, const double v[])
{ (void)c, (void)r; memcpy(x, v, n * sizeof *v); return 0; }
int fmi2GetReal(void *c, const unsigned r[], size_t n, double v[])
{ (void)c, (void)r; memcpy(v, x, n * sizeof *v); return 0; }
"""


def best(function: Callable[[], object], count: int = 1, clock: Callable[[], float] = time.process_time) -> float:
    """Seconds of one of `count` things that a call does, the least of some rounds."""
    taken = []
    for _ in range(ROUNDS):
        start = clock()
        function()
        taken.append((clock() - start) / count)
    return min(taken)


def c_nanoseconds(network: Network, folder: Path) -> list[float]:
    """Outputs, outputs with slopes, standard deviations of a case in exported C."""
    form = closed_form(network)
    (folder / "model.h").write_text(c_header(form))
    (folder / "model.c").write_text(c_source(form))
    driver = Path(__file__).with_name("emulator_cases.c")
    command = ["cc", "-std=c99", "-O2", "-I.", "-o", "cases", "model.c", driver, "-lm"]
    subprocess.run(command, cwd=folder, check=True)
    ends = [str(end) for end in network.input_ranges.ravel()]
    printed = subprocess.run([folder / "cases", *ends], capture_output=True, text=True, check=True).stdout
    return [float(line) for line in printed.split()]


def scikit_learn(network: Network) -> MLPRegressor:
    """The same layers; inputs and outputs on [-1, 1]."""
    model = MLPRegressor(hidden_layer_sizes=network.sizes[1:-1], activation="tanh", max_iter=1)
    X = np.random.default_rng(0).uniform(-1, 1, (10, len(network.inputs)))
    with np.errstate(all="ignore"):
        model.partial_fit(X, np.zeros((10, len(network.outputs))))
    model.coefs_ = [W.T.copy() for W in network.weights]
    model.intercepts_ = [b.copy() for b in network.biases]
    return model


def in_blocks(evaluate: Callable[[np.ndarray], object], X: np.ndarray) -> Callable[[], object]:
    """Evaluation of blocks that stay in the processor's cache, as those here do by themselves."""
    return lambda: [evaluate(X[start : start + BLOCK]) for start in range(0, len(X), BLOCK)]


def on_two_cores(evaluate: Callable[[np.ndarray], object], X: np.ndarray) -> float:
    """Cases a second in two threads."""
    parts = np.array_split(X, len(X) // BLOCK)
    with ThreadPoolExecutor(THREADS) as pool:
        return THREADS / best(lambda: list(pool.map(evaluate, parts)), len(X))


def stub_library(folder: Path) -> Path:
    """A library with all functions of FMI 2.0, which do nothing but for two that copy."""
    names = [name for name in dir(FMU2Slave) if name.startswith("fmi2")]
    others = [f"int {name}(void) {{ return 0; }}" for name in names if f"int {name}(" not in STUB]
    (folder / "stub.c").write_text(STUB + "\n".join(others) + "\n")
    subprocess.run(["cc", "-O2", "-shared", "-fPIC", "-o", "stub.so", "stub.c"], cwd=folder, check=True)
    return folder / "stub.so"


def fmpy_seconds(path: Path, folder: Path, names: Sequence[str], library: Path | None = None) -> float:
    """A case through FMPy: five inputs set, some outputs read."""
    description = fmpy.read_model_description(path, validate=False)
    references = {variable.name: variable.valueReference for variable in description.modelVariables}
    fmu = FMU2Slave(
        guid=description.guid,
        unzipDirectory=fmpy.extract(path, folder / f"{path.stem}{len(names)}{bool(library)}"),
        modelIdentifier=description.coSimulation.modelIdentifier,
        instanceName="one",
        **({"libraryPath": str(library)} if library else {}),
    )
    if library:
        fmu.component = ctypes.c_void_p(1)
    else:
        fmu.instantiate()
        fmu.setupExperiment()
        fmu.enterInitializationMode()
        fmu.exitInitializationMode()
    inputs, outputs = ([references[name] for name in group] for group in (INPUTS, names))
    values = [[3000.0 + n, 0.01, -0.3, 0.3, 60.0] for n in range(5000)]

    def cases() -> None:
        for case in values:
            fmu.setReal(inputs, case)
            fmu.getReal(outputs)

    return best(cases, len(values))


def python_fmu_seconds(path: Path) -> float:
    """The same of a pythonfmu FMU by this project's client, with standard deviations."""
    with FmuClient(path) as fmu:

        def cases() -> None:
            for n in range(200):
                fmu.set(INPUTS, [3000.0 + n, 0.01, -0.3, 0.3, 60.0])
                fmu.get((*SPEEDS, *DEVIATIONS))

        return best(cases, 200)


def loading_milliseconds(code: str) -> float:
    """Processor time of a fresh Python that runs some code, without that of its own start."""

    def once() -> float:
        program = f"import time; start = time.process_time()\n{code}\nprint(time.process_time() - start)"
        return float(subprocess.run([sys.executable, "-c", program], capture_output=True, text=True).stdout)

    return 1e3 * min(once() for _ in range(ROUNDS))


def main() -> None:
    network = RudderEmulator.load(PAPER).speeds
    X = np.random.default_rng(0).uniform(*network.input_ranges.T, (BATCH, 4))
    X_p, few = to_symmetric(X, network.input_ranges), X[:100]
    one_thread = onnxruntime.SessionOptions()
    one_thread.intra_op_num_threads = 1
    bare = closed_form(network, has_std=False)  # onnxruntime computes all outputs, whichever are asked for
    double, single = (
        onnxruntime.InferenceSession(onnx_model(bare, dtype).SerializeToString(), one_thread)
        for dtype in ("float64", "float32")
    )
    X_single, mlp = X.astype(np.float32), scikit_learn(network)
    np.testing.assert_allclose(double.run(["outputs"], {"inputs": few})[0], network.predict(few), rtol=1e-12)
    np.testing.assert_allclose(
        mlp.predict(X_p[:100]), to_symmetric(network.predict(few), network.target_ranges), rtol=1e-9, atol=1e-12
    )
    rows = []

    def add(name: str, value: float, unit: str, peer: str = "", peer_value: float = 0.0) -> None:
        beside = (peer, peer_value, peer_value / value) if peer else ()
        rows.append(row(name, value, unit, *beside))

    batch = {
        "here": best(lambda: network.predict(X), BATCH),
        "onnxruntime": best(in_blocks(lambda x: double.run(["outputs"], {"inputs": x}), X), BATCH),
        "onnxruntime, single precision": best(
            in_blocks(lambda x: single.run(["outputs"], {"inputs": x}), X_single), BATCH
        ),
        "scikit-learn MLPRegressor": best(in_blocks(mlp.predict, X_p), BATCH),
    }
    alone = best(lambda: [double.run(["outputs"], {"inputs": few[:1]}) for _ in range(500)], 500)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        predict, gradient, std = c_nanoseconds(network, folder)
        native, python = (build_fmu(model, folder, PAPER) for model in ("surrogate-native", "surrogate"))
        stub = stub_library(folder)
        floor, through = (fmpy_seconds(native, folder, SPEEDS, library) for library in (stub, None))
        more = (*SPEEDS, *DEVIATIONS)
        floor_std, through_std = (fmpy_seconds(native, folder, more, library) for library in (stub, None))
        slave = python_fmu_seconds(python)
    add("C: a case", predict, "ns", "onnxruntime, one case from Python", 1e9 * alone)
    add("C: a case with its slopes", gradient, "ns")
    add("C: standard deviations", std, "ns")
    for peer in ("onnxruntime", "onnxruntime, single precision", "scikit-learn MLPRegressor"):
        add("in batches: a case of a million, one thread", 1e9 * batch["here"], "ns", peer, 1e9 * batch[peer])
    rate = on_two_cores(network.predict, X)
    peer_rate = on_two_cores(lambda part: double.run(["outputs"], {"inputs": part}), X)
    rows.append(
        row("in batches on two cores", rate / 1e6, "million/s", "onnxruntime", peer_rate / 1e6, rate / peer_rate)
    )
    deviations = best(lambda: network.predict_std(X[:20_000]), 20_000)
    add("NumPy: standard deviations, one thread", 1e9 * deviations, "ns")
    add("FMU through FMPy: five inputs, speeds and margins", 1e6 * through, "us", "FMPy's floor", 1e6 * floor)
    add("the same with standard deviations", 1e6 * through_std, "us", "FMPy's floor", 1e6 * floor_std)
    add("the same with standard deviations", 1e6 * through_std, "us", "FMU of pythonfmu", 1e6 * slave)
    ready = f"from surrogate import load_model; load_model({str(PAPER / SPEEDS_FILE)!r}).predict([0, 0, -9, 9])"
    numpy_ms, all_ms = loading_milliseconds("import numpy"), loading_milliseconds(ready)
    add("Import, load and first case, NumPy's import included", all_ms, "ms", "NumPy's import alone", numpy_ms)
    write("emulator", rows)


if __name__ == "__main__":
    main()
