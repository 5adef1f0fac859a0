"""What a user calls the surrogate of a failed rudder, and the thrust maps of other controls; files of the networks."""

from pathlib import Path

MODEL_HELP = (
    "thrust-map (default), network, paper (its 4-10-2 network), FILE of a thrust map, FOLDER of two networks; of "
    "another failed control: aileron, elevator; of several: trim-map."
)
TRIM_MAP = "trim-map"
"""What answers limits of several controls."""
DEFAULT = "thrust-map"
"""The surrogate that answers where none is named; see `surrogate.rudder.surrogates`."""
SPEEDS_FILE, THROTTLE_FILE = "rudder_speeds.json", "rudder_throttle.json"
NETWORK, PAPER = (Path(__file__).parent / "data" / name for name in ("network", "paper"))
"""Folders of the networks that come with the package: those of `rudder_networks`, and the paper's."""
