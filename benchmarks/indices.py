"""Speed and memory of first and total indices of a network, with intervals, and of the network itself.

    python benchmarks/indices.py

Three million evaluations of the paper's 4-10-2 network: altitude and flight path, and both limits of the rudder in
order, so that they depend on each other; first and total index of each and of both limits, of V_min and V_max; 100
bootstrap samples. Peer of the same run: SALib's ``sobol`` with as many evaluations and resamples, of V_max alone,
with inputs taken as independent, since it knows no others; evaluated by the same network. Each runs in a process of
its own, whose greatest memory is told with its libraries in it. Times are processor time, the best of several rounds;
of the peer, which takes most of a minute, one. (A script of the name of the package would be imported in its place.)
"""

import json
import resource
import subprocess
import sys
import time
from collections.abc import Callable

import numpy as np
from table import row, write

from surrogate.rudder.emulator import RudderEmulator
from surrogate.rudder.names import PAPER

ROWS, ROUNDS, RESAMPLES = 2**18, 5, 100
SALIB_ROWS = 2**19


def ours(sampling: str) -> Callable[[], int]:
    import sensitivity

    network = RudderEmulator.load(PAPER).speeds
    altitude, gamma, lower, _ = network.input_ranges.tolist()
    law = sensitivity.Distribution(
        [
            sensitivity.Uniform("altitude", *altitude),
            sensitivity.Uniform("gamma", *gamma),
            sensitivity.OrderedUniform(("lower", "upper"), *lower),
        ]
    )

    def indices() -> int:
        design = sensitivity.variance_design(law, ROWS, sampling=sampling)
        sensitivity.variance_indices(design.evaluate(network.predict, ["v_min", "v_max"]), n_bootstrap=RESAMPLES)
        return design.n_evaluations

    return indices


def salib() -> Callable[[], int]:
    from SALib.analyze import sobol as analysis
    from SALib.sample import sobol as sample

    network = RudderEmulator.load(PAPER).speeds
    problem = {"num_vars": 4, "names": list("abcd"), "bounds": network.input_ranges.tolist()}

    def indices() -> int:
        X = sample.sample(problem, SALIB_ROWS, calc_second_order=False, seed=1)
        y = network.predict(X)[:, 1]
        analysis.analyze(problem, y, calc_second_order=False, num_resamples=RESAMPLES, seed=1)
        return len(X)

    return indices


WAYS: dict[str, Callable[[], Callable[[], int]]] = {
    "random": lambda: ours("random"),
    "sobol": lambda: ours("sobol"),
    "SALib": salib,
}


def measured(way: str, rounds: int) -> dict[str, float]:
    """Processor seconds, megabytes and evaluations, of a process of its own."""
    done = subprocess.run([sys.executable, __file__, way, str(rounds)], capture_output=True, text=True, check=True)
    return json.loads(done.stdout)


def measure(way: str, rounds: int) -> None:
    indices, taken = WAYS[way](), []
    for _ in range(rounds):
        start = time.process_time()
        evaluations = indices()
        taken.append(time.process_time() - start)
    megabytes = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 / 1e6
    print(json.dumps({"seconds": min(taken), "megabytes": megabytes, "evaluations": evaluations}))


def network_rows() -> list[dict]:
    """A case of a million from Python, in C and in NumPy, and how far they are apart."""
    from surrogate.models import network as networks

    network = RudderEmulator.load(PAPER).speeds
    X = np.random.default_rng(0).uniform(*network.input_ranges.T, (1_000_000, 4))

    def nanoseconds() -> float:
        taken = []
        for _ in range(ROUNDS):
            start = time.process_time()
            network.predict(X)
            taken.append(time.process_time() - start)
        return 1e9 * min(taken) / len(X)

    compiled, outputs = nanoseconds(), network.predict(X)
    library = networks.library
    networks.library = lambda: None
    plain, same = nanoseconds(), network.predict(X)
    networks.library = library
    apart = float((np.abs(outputs - same) / np.ptp(network.target_ranges, axis=1)).max())
    return [
        row("network in batches, a case", compiled, "ns", "NumPy", plain, plain / compiled),
        row("largest difference of the two, of the outputs' range", apart, ""),
    ]


def main() -> None:
    found = {way: measured(way, 1 if way == "SALib" else ROUNDS) for way in WAYS}
    peer, rows = found["SALib"], []
    for way, what in (("random", "random rows, 100 resamples"), ("sobol", "8 Sobol sequences")):
        mine = found[way]
        millions = mine["evaluations"] / 1e6
        name = f"{millions:.2f} million evaluations, 2 outputs, {what}"
        for key, unit in (("seconds", "s"), ("megabytes", "MB")):
            ratio = peer[key] / mine[key]
            rows.append(row(name, mine[key], unit, "SALib, 1 output", peer[key], ratio))
    write("indices", rows + network_rows())


if __name__ == "__main__":
    measure(sys.argv[1], int(sys.argv[2])) if len(sys.argv) > 2 else main()
