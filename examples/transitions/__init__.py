"""From one steady manoeuvre to another after a failure: flown by an autopilot, yes or no with the reason."""
