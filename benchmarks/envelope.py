"""Seconds for the paper's lattice of envelopes and grids, and milliseconds of one V_max beside IPOPT's and SLSQP's.

    python benchmarks/envelope.py

IPOPT (through CasADi) and SLSQP (SciPy) get the core's accelerations with their exact slopes, the same bounds, scaled
unknowns and one start, the level trim at 120 kn or the next speed that has one; neither can know whether another start
would do better. All seek V_max with jammed rudders at random flight conditions that have an envelope.

Times of one V_max are processor times. Each lattice is computed in a process of its own, which remembers nothing.
"""

import multiprocessing
import statistics
import sys
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from pathlib import Path
from tempfile import TemporaryDirectory

import casadi as ca
import numpy as np
from scipy.optimize import minimize

sys.path.insert(0, str(Path(__file__).parent))
from table import row, write

from gtm_fmu import core
from gtm_fmu.aircraft.limits import ControlLimits
from gtm_fmu.airframe.atmosphere import atmosphere
from gtm_fmu.airframe.names import PHI, RUDDER, STATES, TRIM_UNKNOWNS, V
from gtm_fmu.airframe.steady_manoeuvre import steady_manoeuvre
from gtm_fmu.core import solver
from gtm_fmu.datasets import lattice as dataset
from gtm_fmu.datasets import paper
from gtm_fmu.envelopes.envelope import FlightCondition
from gtm_fmu.envelopes.grid import envelope_grid
from gtm_fmu.trims import manoeuvre
from gtm_fmu.units import FT_S_PER_KT, KT_PER_FT_S, RAD_PER_DEG

CASES, SAME_KT = 60, 0.01
NT, SCALE = len(TRIM_UNKNOWNS), solver.scale()
OPTIONS = {
    "print_time": False,
    "error_on_fail": False,
    "show_eval_warnings": False,
    "calc_lam_p": False,
    "ipopt.print_level": 0,
    "ipopt.sb": "yes",
    "ipopt.hessian_approximation": "limited-memory",
    "ipopt.max_iter": 200,
    "ipopt.tol": 1e-8,
}


def state_function() -> ca.Function:
    """State x (12) of unknowns y at altitude and gamma, and its slopes: the closed form that the core takes, too."""
    y, altitude, gamma = ca.SX.sym("y", NT), ca.SX.sym("altitude"), ca.SX.sym("gamma")
    steady = steady_manoeuvre(y, gamma, atmosphere(altitude))
    x = ca.vertcat(steady.velocity, steady.rates, 0, 0, altitude, y[PHI], steady.theta, 0)
    return ca.Function("state", [y, altitude, gamma], [x, ca.jacobian(x, y)])


class Accelerations(ca.Callback):
    """The six accelerations at scaled unknowns, with exact slopes from the core."""

    def __init__(self, state: ca.Function, altitude: float, gamma: float):
        super().__init__()
        self.state, self.at, self.outer = state, (altitude, gamma), None
        self.construct("accelerations", {})

    def get_sparsity_in(self, i):
        return ca.Sparsity.dense(NT, 1)

    def get_sparsity_out(self, i):
        return ca.Sparsity.dense(6, 1)

    def slopes(self, scaled):
        y = np.array(scaled)[:, 0] * SCALE
        x, dx_dy = (np.array(value) for value in self.state(y, *self.at))
        dx, J = core.jacobian(x[:, 0], y[5:])
        dF_dy = J[:6, : len(STATES)] @ dx_dy
        dF_dy[:, 5:] += J[:6, len(STATES) :]
        return dx[:6], dF_dy * SCALE

    def eval(self, arguments):
        return [self.slopes(arguments[0])[0]]

    def has_jacobian(self):
        return True

    def get_jacobian(self, name, inames, onames, options):
        accelerations = self

        class Slopes(ca.Callback):
            def __init__(self):
                super().__init__()
                self.construct(name, {})

            def get_n_in(self):
                return 2

            def get_sparsity_in(self, i):
                return ca.Sparsity.dense(NT, 1) if i == 0 else ca.Sparsity(6, 1)

            def get_sparsity_out(self, i):
                return ca.Sparsity.dense(6, NT)

            def eval(self, arguments):
                return [accelerations.slopes(arguments[0])[1]]

        self.outer = Slopes()
        return self.outer


def ipopt_v_max(state, altitude, gamma, lower, upper, start) -> tuple[float, float]:
    """V_max in kn (not a number if IPOPT finds no solution) and seconds of the solution alone."""
    F = Accelerations(state, altitude, gamma)
    y = ca.MX.sym("y", NT)
    problem = ca.nlpsol("v_max", "ipopt", {"x": y, "f": -y[V], "g": F(y)}, OPTIONS)
    began = time.process_time()
    found = problem(x0=start / SCALE, lbx=lower / SCALE, ubx=upper / SCALE, lbg=0, ubg=0)
    taken = time.process_time() - began
    solved = problem.stats()["success"]
    return (float(found["x"][V]) * SCALE[V] * KT_PER_FT_S if solved else np.nan), taken


def slsqp_v_max(state, altitude, gamma, lower, upper, start) -> tuple[float, float]:
    """The same by `scipy.optimize.minimize`."""
    F = Accelerations(state, altitude, gamma)
    downhill = -np.eye(NT)[V]

    def accelerations(y):
        return F.slopes(y[:, None])[0]

    on_manifold = {"type": "eq", "fun": accelerations, "jac": lambda y: F.slopes(y[:, None])[1]}
    began = time.process_time()
    found = minimize(
        lambda y: -y[V],
        start / SCALE,
        jac=lambda y: downhill,
        bounds=np.column_stack([lower, upper]) / SCALE[:, None],
        constraints=on_manifold,
        method="SLSQP",
        options={"maxiter": 300, "ftol": 1e-10},
    )
    taken = time.process_time() - began
    solved = found.success and np.abs(accelerations(found.x)).max() < 1e-6
    return (found.x[V] * SCALE[V] * KT_PER_FT_S if solved else np.nan), taken


PEERS: dict[str, Callable[..., tuple[float, float]]] = {"IPOPT": ipopt_v_max, "SciPy's SLSQP": slsqp_v_max}


def compare() -> list[dict]:
    """Median ms of one V_max by the core beside each peer's, and in how many cases the peer gives the same."""
    rng, state = np.random.default_rng(0), state_function()
    objective = -np.eye(NT)[V]
    core_ms: list[float] = []
    peer_ms: dict[str, list[float]] = {name: [] for name in PEERS}
    agree = dict.fromkeys(PEERS, 0)
    while len(core_ms) < CASES:
        altitude, gamma = rng.uniform(0, 30000), rng.uniform(-5, 5) * RAD_PER_DEG
        jam = rng.uniform(-22, 22)
        lower, upper = manoeuvre.bounds(ControlLimits(rudder_deg=(jam, jam)))
        began = time.process_time()
        found = solver.envelope_end(altitude, gamma, lower, upper, objective)
        taken = time.process_time() - began
        if found.status != solver.TRIMMED:
            continue
        core_ms.append(1e3 * taken)
        held = [[speed * FT_S_PER_KT, 0.0, jam] for speed in (120, 140, 100, 160)]
        start = solver.cold_starts(altitude, gamma, held)[0]
        assert start[RUDDER] == jam
        for name, seek in PEERS.items():
            v_max_kt, taken = seek(state, altitude, gamma, lower, upper, start)
            peer_ms[name].append(1e3 * taken)
            difference = v_max_kt - found.y[V] * KT_PER_FT_S
            assert not difference > SAME_KT, "a peer goes beyond"
            agree[name] += bool(abs(difference) <= SAME_KT)
    core = statistics.median(core_ms)
    rows = []
    for name, times in peer_ms.items():
        peer = f"{name}, one start, exact slopes; the same V_max in {agree[name]} of {CASES}, beyond it in none; ms"
        median = statistics.median(times)
        rows.append(row("V_max of a jam from all starts, median", core, "ms", peer, median, median / core))
    return rows


def ranges(cases: int = 200) -> dict:
    """Median ms of V_min and V_max of random ranges of the rudder that leave an envelope, nothing shared or known."""
    rng, objective = np.random.default_rng(1), np.eye(NT)[V]
    times: list[float] = []
    while len(times) < cases:
        altitude, gamma = rng.uniform(0, 30000), rng.uniform(-5, 5) * RAD_PER_DEG
        lower, upper = np.sort(rng.uniform(-30, 30, 2)).tolist()
        bounds = manoeuvre.bounds(ControlLimits(rudder_deg=(lower, upper)))
        began = time.process_time()
        found = [solver.envelope_end(altitude, gamma, *bounds, sign * objective) for sign in (1, -1)]
        taken = time.process_time() - began
        if all(end.status == solver.TRIMMED for end in found):
            times.append(1e3 * taken)
    return row(f"V_min and V_max of a range of the rudder, cold, median of {cases}", statistics.median(times), "ms")


def lattice(workers: int) -> int:
    """Number of envelopes of the paper's lattice."""
    with TemporaryDirectory() as folder:
        return dataset.solved(Path(folder, "lattice.zarr"), dataset.lattice(), workers=workers).feasible.size


def masks(workers: int) -> int:
    """Number of trims in all grids of 1 kn x 1 deg/s of the paper's lattice, with stability and controllability."""

    def points(condition: tuple[float, float]) -> int:
        failures = (ControlLimits(rudder_deg=limits) for limits in dataset.rudder_failures(paper.RUDDERS_DEG))
        grids = (envelope_grid(FlightCondition(*condition, limits)) for limits in failures)
        return sum(int(np.count_nonzero(grid.feasible)) for grid in grids)

    conditions = [(h, gamma) for h in paper.ALTITUDES_FT for gamma in paper.GAMMAS_DEG]
    with ThreadPoolExecutor(workers) as pool:
        return sum(pool.map(points, conditions))


def _timed(work: Callable[[int], int], workers: int) -> tuple[int, float, float]:
    wall, processor = time.perf_counter(), time.process_time()
    count = work(workers)
    return count, time.perf_counter() - wall, time.process_time() - processor


def measure(work: Callable[[int], int], workers: int) -> tuple[int, float, float]:
    """Count, wall-clock and processor seconds of a piece of work in a new process."""
    with ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as process:
        return process.submit(_timed, work, workers).result()


def main() -> None:
    rows = [*compare(), ranges()]
    for workers in (1, 2):
        cases, wall, processor = measure(lattice, workers)
        name = f"lattice of {cases} envelopes with t_min and the trims at both ends, {_threads(workers)}"
        rows += [row(name, wall, "s"), row(f"{name}, processor time", processor, "s")]
    points, wall, processor = measure(masks, 2)
    name = f"all grids of the lattice, {points} trims with stability and controllability, {_threads(2)}"
    rows += [row(name, wall, "s"), row(f"{name}, processor time", processor, "s")]
    rows.append(row("one trim of a grid, processor time", 1e6 * processor / points, "us"))
    write("envelope", rows)


def _threads(count: int) -> str:
    return f"{count} thread{'s' if count > 1 else ''}"


if __name__ == "__main__":
    main()
