"""What the airframe's expressions are written in."""

import casadi as ca

Quantity = ca.SX | ca.DM | float
"""A number or a symbol: numbers give numbers, symbols give expressions."""
