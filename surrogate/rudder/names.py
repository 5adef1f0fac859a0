"""What a user calls the surrogate of a failed rudder, and the thrust maps of other controls."""

MODEL_HELP = (
    "thrust-map (default), network, paper (its 4-10-2 network), FILE of a thrust map, FOLDER of two networks; of "
    "another failed control: aileron, elevator; of several: trim-map."
)
TRIM_MAP = "trim-map"
"""What answers limits of several controls."""
DEFAULT = "thrust-map"
"""The surrogate that answers where none is named; see `surrogate.rudder.surrogates`."""
