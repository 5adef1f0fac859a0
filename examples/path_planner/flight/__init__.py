"""A plan is flown: GtmAircraft in FMPy or Ecos, an autopilot that knows what the failure leaves, and the outcome."""
