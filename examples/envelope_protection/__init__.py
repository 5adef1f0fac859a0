"""Co-simulation of the aircraft, its envelope and an autopilot."""
