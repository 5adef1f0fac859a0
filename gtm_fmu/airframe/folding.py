"""The aerodynamic tables folded into the lookups of the study configuration (SPEC 9).

With both ailerons driven by one command, both rudder halves by another and the stabiliser at zero, the database
reduces to eight tables over alpha, beta, the normalised rates and three deflections. Every step is exact: mirror
rules permute and negate entries, and a piecewise linear table keeps its values, inside and outside its axes, when
breakpoints are added to an axis with the extrapolated values beyond its ends.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import reduce

import numpy as np

from gtm_fmu.airframe.names import COEFFICIENTS
from gtm_fmu.airframe.tables import LATERAL, Table, load_tables

_MIRROR = np.array([-1.0 if name in LATERAL else 1.0 for name in COEFFICIENTS])


@dataclass(frozen=True)
class FoldedTables:
    """Multilinear tables of the study configuration, extrapolated with the slope of their end intervals (SPEC 1).

    alpha, beta, elevator, aileron, rudder: breakpoints in deg. p_hat, q_hat, r_hat, omega_hat: breakpoints of the
    normalised rates (SPEC 5.5). The other fields are body-axis coefficients, indexed by the axes in their
    description; six components are CX CY CZ Cl Cm Cn.
    """

    alpha: np.ndarray
    beta: np.ndarray
    p_hat: np.ndarray
    q_hat: np.ndarray
    r_hat: np.ndarray
    omega_hat: np.ndarray
    elevator_deg: np.ndarray
    aileron_deg: np.ndarray
    rudder_deg: np.ndarray
    basic: np.ndarray
    """[alpha, beta, 6]"""
    elevator: np.ndarray
    """[alpha, beta, elevator_deg, CX CZ Cm]"""
    aileron: np.ndarray
    """[alpha, beta, aileron_deg, 6]"""
    rudder: np.ndarray
    """[alpha, beta, rudder_deg, 6]"""
    p: np.ndarray
    """[alpha, p_hat, CY Cl Cn]"""
    q: np.ndarray
    """[alpha, q_hat, CX CZ Cm]"""
    r: np.ndarray
    """[alpha, r_hat, CY Cl Cn]"""
    omega: np.ndarray
    """[alpha, omega_hat, beta, 6]"""


def resample(values: np.ndarray, old: np.ndarray, new: np.ndarray, axis: int) -> np.ndarray:
    """`values`, piecewise linear over the breakpoints `old` of `axis`, at the breakpoints `new` (SPEC 1).

    Exact at points that both have; linear with the slope of the end interval outside `old`.
    """
    lower = np.clip(np.searchsorted(old, new, side="right") - 1, 0, len(old) - 2)
    fraction = (new - old[lower]) / (old[lower + 1] - old[lower])
    fraction = fraction.reshape(-1, *(1,) * (values.ndim - 1 - axis % values.ndim))
    return (1.0 - fraction) * values.take(lower, axis) + fraction * values.take(lower + 1, axis)


def fold_rudder(table: Table) -> tuple[np.ndarray, np.ndarray]:
    """Deflections and values of both rudder halves together over the full range.

    SPEC 5.2 for d >= 0: c(alpha, beta, d) is c(alpha, -beta, -d) with CY, Cl, Cn negated; the weights of the two
    halves add up to one. Values [alpha, beta, rudder, 6], rudder from -45 to 45 deg.
    """
    check_symmetric(table, "beta")
    negative = table.axis("rud")
    mirrored = _MIRROR * table.values[:, ::-1, -2::-1]
    return np.concatenate([negative, -negative[-2::-1]]), np.concatenate([table.values, mirrored], axis=2)


def fold_ailerons(table: Table) -> tuple[np.ndarray, np.ndarray]:
    """Deflections and values of both ailerons together over the command a (AILL = -a, AILR = +a, SPEC 4).

    SPEC 5.3: c(alpha, beta, a) = c_R(alpha, beta, a) + c_R(alpha, -beta, -a) with CY, Cl, Cn of the latter negated.
    Values [alpha, beta, aileron, 6].
    """
    check_symmetric(table, "beta")
    check_symmetric(table, "ail")
    return table.axis("ail"), table.values + _MIRROR * table.values[:, ::-1, ::-1]


def fold_elevator(table: Table) -> tuple[np.ndarray, np.ndarray]:
    """Deflections and values of the four elevator segments together at stabiliser 0 (SPEC 5.4).

    Values [alpha, beta, elevator, (CX, CZ, Cm)].
    """
    return table.axis("elev"), table.values[:, :, int(np.flatnonzero(table.axis("stab") == 0.0)[0])]


def folded_tables(tables: Mapping[str, Table] | None = None) -> FoldedTables:
    """The study configuration's tables, all on one alpha axis and those of sideslip on one beta axis.

    Alpha holds the breakpoints of every static and rate table, -30 to 90 deg; beta those of the static tables.
    """
    tables = load_tables() if tables is None else tables
    basic, p, q, r, w = (tables[name] for name in ("C6_bas", "dC3_p", "dC3_q", "dC3_r", "dC6_w"))
    alpha = reduce(np.union1d, [table.axis("alpha") for table in (basic, p, q, r, w)])
    beta = basic.axis("beta")

    def over_alpha(table: Table, values: np.ndarray) -> np.ndarray:
        return resample(values, table.axis("alpha"), alpha, axis=0)

    elevator_deg, elevator = fold_elevator(tables["dC3_ele"])
    aileron_deg, aileron = fold_ailerons(tables["dC6_ail"])
    rudder_deg, rudder = fold_rudder(tables["dC6_rud"])
    return FoldedTables(
        alpha=alpha,
        beta=beta,
        p_hat=p.axis("phat"),
        q_hat=q.axis("qhat"),
        r_hat=r.axis("rhat"),
        omega_hat=w.axis("what"),
        elevator_deg=elevator_deg,
        aileron_deg=aileron_deg,
        rudder_deg=rudder_deg,
        basic=over_alpha(basic, basic.values),
        elevator=over_alpha(tables["dC3_ele"], elevator),
        aileron=over_alpha(tables["dC6_ail"], aileron),
        rudder=over_alpha(tables["dC6_rud"], rudder),
        p=over_alpha(p, p.values),
        q=over_alpha(q, q.values),
        r=over_alpha(r, r.values),
        omega=over_alpha(w, resample(w.values, w.axis("beta"), beta, axis=2)),
    )


def check_symmetric(table: Table, axis: str) -> None:
    """Raise ValueError unless the breakpoints of ``axis`` lie symmetric about zero, as a mirror rule needs."""
    if not np.array_equal(table.axis(axis), -table.axis(axis)[::-1]):
        raise ValueError(f"The mirror rule of {table.name} needs an axis {axis} symmetric about zero.")
