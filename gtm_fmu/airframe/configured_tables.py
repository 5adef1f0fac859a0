"""The aerodynamic tables that are looked up over axes of their own (SPEC 5.6, 10.4, 10.5), and never extrapolated."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from gtm_fmu.airframe.damage import DAMAGE_CASES
from gtm_fmu.airframe.names import COEFFICIENTS
from gtm_fmu.airframe.surfaces import FLAPS
from gtm_fmu.airframe.tables import Table, load_tables

RATES = {"p": "dC3_p", "q": "dC3_q", "r": "dC3_r"}
"""Rates of the damaged aircraft's dynamic terms and their tables."""

STALL_ALPHA = np.array([12.5, 13.5, 14.5])  # deg (SPEC 5.6)
STALL_BETA = np.array([-2.0, -1.0, 1.0, 2.0])
STALL_ROLL = 0.01  # Cl
_STALL = STALL_ROLL * np.outer([0.0, 1.0, 0.0], [0.0, 1.0, 1.0, 0.0])


@dataclass(frozen=True)
class ConfiguredTables:
    """Multilinear tables, clipped at the ends of their axes; six components are CX CY CZ Cl Cm Cn.

    Damage cases are counted from 1 in the database and from 0 here.
    """

    damage_alpha: np.ndarray
    damage_beta: np.ndarray
    flap: np.ndarray
    """Per deg, [panel in the order of `surfaces.FLAPS`, 6]"""
    stall: np.ndarray
    """Roll asymmetry, [STALL_ALPHA, STALL_BETA, 6]"""
    damage: np.ndarray
    """[case, damage_alpha, damage_beta, 6]"""
    damage_scale: np.ndarray
    """Factors of the tables of p, q and r, [case, damage_alpha, rate, the table's three components]"""
    rate_alpha: np.ndarray
    """Lowest and highest alpha of the tables of p, q and r, where damage clips them, [rate, 2]"""


def configured_tables(tables: Mapping[str, Table] | None = None) -> ConfiguredTables:
    """The tables of the data file, or of others."""
    tables = load_tables() if tables is None else tables
    panels = list(tables["flaps"].axis("panel"))
    base, scale = tables["dC6_damage.bas"], tables["dC6_damage.ddscale"]
    if not np.array_equal(base.axis("alpha"), scale.axis("alpha")):
        raise ValueError("The damage tables differ in their axis alpha.")
    if len(base.axis("damage_case")) != len(DAMAGE_CASES) - 1:
        raise ValueError("There is not one damage table for each damage case.")
    components = [[COEFFICIENTS.index(name) for name in tables[table].components] for table in RATES.values()]
    by_rate = [scale.values[:, :, rate, columns] for rate, columns in enumerate(components)]
    stall = np.zeros((*_STALL.shape, len(COEFFICIENTS)))
    stall[..., COEFFICIENTS.index("Cl")] = _STALL
    return ConfiguredTables(
        damage_alpha=base.axis("alpha"),
        damage_beta=base.axis("beta"),
        flap=tables["flaps"].values[[panels.index(name.lower()) for name in FLAPS]],
        stall=stall,
        damage=np.moveaxis(base.values, 2, 0),
        damage_scale=np.moveaxis(np.stack(by_rate, axis=2), 1, 0),
        rate_alpha=np.array([tables[name].axis("alpha")[[0, -1]] for name in RATES.values()]),
    )
