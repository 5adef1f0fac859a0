"""What a user calls the surrogate of a failed rudder, and the thrust maps of other controls."""

MODEL_HELP = (
    "thrust-map (default), network, paper (its 4-10-2 network), FILE of a thrust map, FOLDER of two networks; of "
    "another failed control: aileron, elevator."
)
DEFAULT = "thrust-map"
"""The surrogate that answers where none is named; see `surrogate.rudder.surrogates`."""
