"""What a user can get wrong, told in one sentence."""

import sys
from collections.abc import Callable
from functools import wraps


class InputError(ValueError):
    """Input outside what is allowed; the message says what was given, what is allowed and what to do."""


def script(main: Callable[[], None]) -> Callable[[], int]:
    """Make a script's main function return its exit code: 0, or 2 after an `InputError` on standard error."""

    @wraps(main)
    def run() -> int:
        try:
            main()
        except InputError as error:
            print(error, file=sys.stderr)
            return 2
        return 0

    return run
