"""A path planner that asks the FMUs what a failure leaves."""
