"""Building FMUs: sources, compilers, archives."""
