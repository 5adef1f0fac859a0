"""Surrogates beyond the paper, measured on exact cases off the lattice."""
