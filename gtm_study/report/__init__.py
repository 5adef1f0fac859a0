"""The report of the study: one page that needs nothing but itself, and the same as PDF."""
