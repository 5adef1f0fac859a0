"""How long work tells how far it is."""

from collections.abc import Callable

Advance = Callable[[int, int], None]
"""Called with the number of finished steps and of all."""
