"""The aerodynamic tables of every configuration (SPEC 5, 10.4, 10.5), next to the folded ones of the study.

The folded tables serve here too where they are not special: the basic airframe, the dynamic terms and the rudder,
whose table over both signs of the deflection is that of each half.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from gtm_fmu.airframe.damage import DAMAGE_CASES
from gtm_fmu.airframe.folding import check_symmetric, folded_tables, resample
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
    """Multilinear tables, extrapolated unless clipping is mentioned; axes as in `FoldedTables`, the others here.

    Six components are CX CY CZ Cl Cm Cn. Damage cases are counted from 1 in the database and from 0 here.
    """

    spoiler_deg: np.ndarray
    stabilizer_deg: np.ndarray
    damage_alpha: np.ndarray
    damage_beta: np.ndarray
    aileron: np.ndarray
    """The right one, [alpha, beta, aileron_deg, 6]"""
    spoiler: np.ndarray
    """The right ones, [alpha, beta, spoiler_deg, 6]"""
    elevator: np.ndarray
    """With the stabiliser, [stabilizer_deg, alpha, beta, elevator_deg, CX CZ Cm]"""
    gear: np.ndarray
    """[alpha, CX CZ Cm]"""
    flap: np.ndarray
    """Per deg, [panel in the order of `surfaces.FLAPS`, 6]"""
    stall: np.ndarray
    """Roll asymmetry, clipped, [STALL_ALPHA, STALL_BETA, 6]"""
    damage: np.ndarray
    """Clipped, [case, damage_alpha, damage_beta, 6]"""
    damage_scale: np.ndarray
    """Factors of the tables of p, q and r, clipped, [case, damage_alpha, rate, the table's three components]"""
    damage_increment: np.ndarray
    """CY per normalised rate, [case, alpha, rate]"""
    rate_alpha: np.ndarray
    """Lowest and highest alpha of the tables of p, q and r, where damage clips them, [rate, 2]"""


def configured_tables(tables: Mapping[str, Table] | None = None) -> ConfiguredTables:
    """The tables, on the axes alpha and beta of `folded_tables`."""
    tables = load_tables() if tables is None else tables
    alpha = folded_tables(tables).alpha
    for name in ("dC6_ail", "dC6_spo"):
        check_symmetric(tables[name], "beta")  # a left panel is looked up by mirroring its place on the axis

    def over_alpha(name: str, axis: int = 0) -> np.ndarray:
        return resample(tables[name].values, tables[name].axis("alpha"), alpha, axis)

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
        spoiler_deg=tables["dC6_spo"].axis("spo"),
        stabilizer_deg=tables["dC3_ele"].axis("stab"),
        damage_alpha=base.axis("alpha"),
        damage_beta=base.axis("beta"),
        aileron=over_alpha("dC6_ail"),
        spoiler=over_alpha("dC6_spo"),
        elevator=np.moveaxis(over_alpha("dC3_ele"), 2, 0),
        gear=over_alpha("dC3_lgr")[:, 1],
        flap=tables["flaps"].values[[panels.index(name.lower()) for name in FLAPS]],
        stall=stall,
        damage=np.moveaxis(base.values, 2, 0),
        damage_scale=np.moveaxis(np.stack(by_rate, axis=2), 1, 0),
        damage_increment=np.moveaxis(over_alpha("dC6_damage.ddinc")[..., COEFFICIENTS.index("CY")], 1, 0),
        rate_alpha=np.array([tables[name].axis("alpha")[[0, -1]] for name in RATES.values()]),
    )
