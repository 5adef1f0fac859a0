"""A table to train a surrogate on."""
