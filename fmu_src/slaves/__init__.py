"""What runs inside an FMU in Python: standard library and pythonfmu only."""
