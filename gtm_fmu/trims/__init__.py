"""Steady manoeuvres: what may be asked, trims by the core and over FMU evaluations, linear models."""
