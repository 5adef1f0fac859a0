"""Figures of envelopes, and interactive pages."""
