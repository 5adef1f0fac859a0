"""Fitted models in closed form, their scaling and their files; no training, no torch."""
