"""Flight dynamics, trims and flight envelopes of the NASA Generic Transport Model (GTM-T2)."""
