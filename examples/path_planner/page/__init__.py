"""The page of a plan: one file with its charts, which needs no network."""
