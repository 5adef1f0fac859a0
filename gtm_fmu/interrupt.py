"""Control-C and code that is not Python's: held until a block ends.

An exception in the middle of a callback is swallowed by the optimiser that called it, and one inside an FMU's own
Python ends the instance.
"""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def held_interrupt() -> Iterator[None]:
    """Deliver a Control-C that comes inside the block at its end; in other threads than the first none comes."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    came: list[tuple] = []
    handler = signal.signal(signal.SIGINT, lambda *arguments: came.append(arguments))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, handler)
    if came and callable(handler):
        handler(*came[0])
