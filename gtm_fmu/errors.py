"""What a user can get wrong, told in one sentence."""


class InputError(ValueError):
    """Input outside what is allowed; the message says what was given, what is allowed and what to do."""
