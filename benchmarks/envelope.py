"""Seconds for the paper's lattice of envelopes, and milliseconds of one V_max beside IPOPT's on the same equations.

    python benchmarks/envelope.py

IPOPT (through CasADi) gets the core's accelerations with their exact slopes, the same bounds, scaled unknowns and one
start, the level trim at 120 kt or the next speed that has one; it has no way to know whether another start would do
better. Both seek V_max with jammed rudders at random flight conditions that have an envelope.
"""

import statistics
import sys
import time
from pathlib import Path

import casadi as ca
import numpy as np

sys.path.insert(0, str(Path(__file__).parent))
from table import row, write

from gtm_fmu import core, dataset, manoeuvre
from gtm_fmu.airframe.atmosphere import atmosphere
from gtm_fmu.airframe.names import STATES, TRIM_UNKNOWNS
from gtm_fmu.airframe.steady_manoeuvre import steady_manoeuvre
from gtm_fmu.core import solver
from gtm_fmu.failures import ControlLimits
from gtm_fmu.manoeuvre import PHI, RUDDER, V
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
    """V_max in kt (not a number if IPOPT finds no solution) and seconds of the solution alone."""
    F = Accelerations(state, altitude, gamma)
    y = ca.MX.sym("y", NT)
    problem = ca.nlpsol("v_max", "ipopt", {"x": y, "f": -y[V], "g": F(y)}, OPTIONS)
    began = time.perf_counter()
    found = problem(x0=start / SCALE, lbx=lower / SCALE, ubx=upper / SCALE, lbg=0, ubg=0)
    taken = time.perf_counter() - began
    solved = problem.stats()["success"]
    return (float(found["x"][V]) * SCALE[V] * KT_PER_FT_S if solved else np.nan), taken


def compare() -> tuple[float, float, int, int]:
    """Median ms of one V_max by the core and by IPOPT, in how many cases IPOPT agrees, and goes beyond."""
    rng, state = np.random.default_rng(0), state_function()
    objective = -np.eye(NT)[V]
    core_ms, ipopt_ms, agree, beyond = [], [], 0, 0
    while len(core_ms) < CASES:
        altitude, gamma = rng.uniform(0, 30000), rng.uniform(-5, 5) * RAD_PER_DEG
        jam = rng.uniform(-22, 22)
        lower, upper = manoeuvre.bounds(ControlLimits(rudder_deg=(jam, jam)))
        began = time.perf_counter()
        found = solver.envelope_end(altitude, gamma, lower, upper, objective)
        taken = time.perf_counter() - began
        if found.status != solver.TRIMMED:
            continue
        core_ms.append(1e3 * taken)
        held = [[speed * FT_S_PER_KT, 0.0, jam] for speed in (120, 140, 100, 160)]
        start = solver.cold_starts(altitude, gamma, held)[0]
        assert start[RUDDER] == jam
        v_max_kt, taken = ipopt_v_max(state, altitude, gamma, lower, upper, start)
        ipopt_ms.append(1e3 * taken)
        difference = v_max_kt - found.y[V] * KT_PER_FT_S
        agree += abs(difference) <= SAME_KT
        beyond += difference > SAME_KT
    return statistics.median(core_ms), statistics.median(ipopt_ms), agree, beyond


def lattice_seconds(workers: int) -> tuple[float, float, int]:
    """Wall-clock and processor seconds of the paper's lattice, and the number of cases."""
    wall, processor = time.perf_counter(), time.process_time()
    cases = dataset.lattice(workers=workers).feasible.size
    return time.perf_counter() - wall, time.process_time() - processor, cases


def main() -> None:
    core_ms, ipopt_ms, agree, beyond = compare()
    assert beyond == 0
    peer = f"IPOPT, one start, exact slopes; the same V_max in {agree} of {CASES}, beyond it in none; ms"
    rows = [row("V_max of a jam from all starts, median", core_ms, "ms", peer, ipopt_ms, ipopt_ms / core_ms)]
    for workers in (1, 2):
        wall, processor, cases = lattice_seconds(workers)
        name = f"lattice of {cases} envelopes, {workers} worker{'s' if workers > 1 else ''}"
        rows += [row(name, wall, "s"), row(f"{name}, processor time", processor, "s")]
        if workers == 1:
            rows.append(row("one envelope (V_min, V_max, t_min), processor time", 1e3 * processor / cases, "ms"))
    write("envelope", rows)


if __name__ == "__main__":
    main()
