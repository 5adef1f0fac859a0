"""The table wing.csv: lift and drag of 400 wings in air at sea level, to train a surrogate on.

python examples/tables/wing.py examples/tables/wing.csv

A wing of elliptic planform, mean chord c = 0.3 m, span b, at angle of attack alpha and speed V. Prandtl's lifting line
has a closed form for it (J. D. Anderson, Fundamentals of Aerodynamics, 5.3.1):

    AR  = b / c                                   aspect ratio
    C_L = 2 pi (alpha - alpha_0) / (1 + 2 / AR)   lift
    C_D = C_D0 + C_L^2 / (pi AR)                  profile and induced drag
    L, D = rho V^2 / 2 b c (C_L, C_D)
"""

import argparse
from pathlib import Path

import numpy as np

CHORD_M, ALPHA_0_DEG, C_D0, DENSITY_KG_M3 = 0.3, -2.0, 0.02, 1.225
LOWER, UPPER = (500.0, -5.0, 10.0), (2000.0, 10.0, 40.0)
"""Of span in mm, angle of attack in deg and speed in m/s."""
ROWS = 400


def lift_and_drag(span_mm, alpha_deg, speed_m_s):
    """Lift and drag in N, of numbers or arrays."""
    span_m = np.asarray(span_mm) / 1000
    aspect_ratio = span_m / CHORD_M
    c_l = 2 * np.pi * np.radians(np.asarray(alpha_deg) - ALPHA_0_DEG) / (1 + 2 / aspect_ratio)
    c_d = C_D0 + c_l**2 / (np.pi * aspect_ratio)
    force = DENSITY_KG_M3 / 2 * np.asarray(speed_m_s) ** 2 * span_m * CHORD_M
    return force * c_l, force * c_d


def write(path: Path) -> None:
    """Write the table; 400 random wings, the same ones each time."""
    wings = np.random.default_rng(0).uniform(LOWER, UPPER, (ROWS, 3)).round(2)
    rows = np.column_stack([wings, *lift_and_drag(*wings.T)])
    lines = ["span_mm,alpha_deg,speed_m_s,lift,drag", *(",".join(f"{value:.7g}" for value in row) for row in rows)]
    path.write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("path", type=Path, help="the .csv to write")
    path = parser.parse_args().path
    try:
        write(path)
    except OSError as error:
        parser.error(f"cannot write '{path}' ({error.strerror}); choose another file")
