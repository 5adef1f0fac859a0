"""What the airframe's expressions are written in: CasADi, loaded when the first expression is built.

Most programs ask the compiled core, and take only constants from here: they do not wait for CasADi.
"""

import math
from typing import TYPE_CHECKING, TypeAlias

if TYPE_CHECKING:
    import casadi as ca
else:
    import lazy_loader

    ca = lazy_loader.load("casadi")

Quantity: TypeAlias = "ca.SX | ca.DM | float"
"""A number or a symbol: numbers give numbers, symbols give expressions."""


def sqrt(value: Quantity) -> Quantity:
    """Square root, of a number without CasADi."""
    return math.sqrt(value) if isinstance(value, float | int) else ca.sqrt(value)


def clip(value: Quantity, lower: float, upper: float) -> Quantity:
    """The value held between two numbers, a number without CasADi."""
    return min(max(value, lower), upper) if isinstance(value, float | int) else ca.fmin(ca.fmax(value, lower), upper)
