"""The paper's levels, ranges and data sets, as plain numbers: the lattice is made of them."""

ALTITUDES_FT = (0.0, 10000.0, 20000.0, 30000.0)
GAMMAS_DEG = (-5.0, -4.0, -3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0, 4.0, 5.0)
RUDDERS_DEG = (-30.0, -20.0, -10.0, 0.0, 10.0, 20.0, 30.0)
"""Table 7: levels of the lattice; both limits of the rudder take the same, lower <= upper."""

ALTITUDE_FT, GAMMA_DEG = (ALTITUDES_FT[0], ALTITUDES_FT[-1]), (GAMMAS_DEG[0], GAMMAS_DEG[-1])
"""The ranges that the levels span."""

DATA_SETS: dict[int, dict[str, tuple[float, ...]]] = {
    1: {"gamma_deg": (-5.0, 0.0, 5.0)},
    2: {"rudder_deg": (-20.0, 0.0, 20.0)},
    3: {"rudder_deg": (-30.0, -10.0, 10.0, 30.0)},
    4: {"gamma_deg": (-5.0, 0.0, 5.0), "rudder_deg": (-20.0, 0.0, 20.0)},
    5: {"gamma_deg": (-5.0, 0.0, 5.0), "rudder_deg": (-30.0, -10.0, 10.0, 30.0)},
    6: {},
}
"""Tables 8-12, section III-E: data set -> levels where fewer than the lattice's; both limits take the rudder's."""
