"""Unit factors between the airframe's own units (SPEC 1), the public edge of the package and the SI of FMUs."""

import math

KT_PER_FT_S = 0.592487
"""Knots per foot per second, the specification's own rounding (SPEC 1)."""

M_PER_FT = 0.3048
KG_PER_LB = 0.45359237
N_PER_LBF = 4.4482216152605
PA_PER_PSF = N_PER_LBF / M_PER_FT**2
RAD_PER_DEG = math.pi / 180.0
DEG_PER_RAD = 180.0 / math.pi
FT_S_PER_KT = 1.0 / KT_PER_FT_S
M_S_PER_KT = M_PER_FT / KT_PER_FT_S
