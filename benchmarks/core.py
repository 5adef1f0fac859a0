"""Nanoseconds of the core's state derivatives and Jacobian from C, beside CasADi's own table look-up.

    python benchmarks/core.py

The peer is `casadi.interpolant` (linear) of the basic table alone with its Jacobian, generated to C and compiled alike
by the same compiler: one of the eight tables that the core looks up in each call, and none of the equations of motion.
"""

import subprocess
import sys
import tempfile
from pathlib import Path

import casadi as ca
import numpy as np

sys.path.insert(0, str(Path(__file__).parent))
from table import row, write

from gtm_fmu.airframe.tables import load_tables
from gtm_fmu.core import library_path

HERE = Path(__file__).parent
CORE = library_path().parent
PEER = """
#define _POSIX_C_SOURCE 199309L
#include <stdio.h>
#include <stdlib.h>
#include <time.h>
#include "peer.h"
static double seconds(void) { struct timespec t; clock_gettime(CLOCK_MONOTONIC, &t); return t.tv_sec + 1e-9*t.tv_nsec; }
int main(void) {
  static double k[1000][2], w[4096], c[6], s[12]; static casadi_int iw[4096]; double least[2] = {1, 1};
  for (int i = 0; i < 1000; i++) { k[i][0] = 10.0*rand()/RAND_MAX; k[i][1] = -20 + 40.0*rand()/RAND_MAX; }
  for (int round = 0; round < 200; round++) for (int which = 0; which < 2; which++) {
    double start = seconds();
    for (int i = 0; i < 1000; i++) {
      const double *arg[8] = {k[i]}; double *res[8] = {which ? s : c};
      if (which) slopes(arg, res, iw, w, 0); else values(arg, res, iw, w, 0);
    }
    double taken = (seconds() - start) / 1000; if (taken < least[which]) least[which] = taken;
  }
  printf("%.1f %.1f\\n", 1e9*least[0], 1e9*least[1]); return 0; }
"""


def compiled(folder: Path, sources: list[Path], *flags: str) -> list[float]:
    """Build with -O2, run, and read the numbers that the program prints."""
    program = folder / "program"
    subprocess.run(["cc", "-O2", "-std=c99", *flags, *map(str, sources), "-lm", "-o", str(program)], check=True)
    return [float(word) for word in subprocess.run([program], check=True, capture_output=True).stdout.split()]


def interpolant_ns(folder: Path) -> list[float]:
    """Value and Jacobian of the basic table by CasADi's interpolant."""
    table = load_tables()["C6_bas"]
    values = np.transpose(table.values, (2, 0, 1)).ravel(order="F")
    axes = [table.axis(name).tolist() for name in ("alpha", "beta")]
    function = ca.interpolant("values", "linear", axes, values.tolist())
    point = ca.MX.sym("point", 2)
    generator = ca.CodeGenerator("peer.c", {"with_header": True})
    generator.add(ca.Function("values", [point], [function(point)]))
    generator.add(ca.Function("slopes", [point], [ca.jacobian(function(point), point)]))
    generator.generate(f"{folder}/")
    (folder / "main.c").write_text(PEER)
    return compiled(folder, [folder / "peer.c", folder / "main.c"], f"-I{folder}", "-w")


def main() -> None:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        library = library_path()
        xdot, jacobian = compiled(folder, [HERE / "core.c", library], f"-I{CORE}", f"-Wl,-rpath,{CORE}")
        value, slope = interpolant_ns(folder)
    peer = "casadi interpolant, one of eight tables"
    write(
        "core",
        [
            row("state derivatives", xdot, "ns", peer, value, value / xdot),
            row("state derivatives and 12 x 16 Jacobian", jacobian, "ns", peer, slope, slope / jacobian),
        ],
    )


if __name__ == "__main__":
    main()
