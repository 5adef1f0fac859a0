"""The aircraft as its users see it: what a failure leaves, inputs with units and ranges, an FMU driven by FMPy."""
