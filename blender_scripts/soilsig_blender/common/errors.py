"""Failures that the caller is told of by kind, with what to do about them."""


class BedError(Exception):
    """A bed cannot be made, or was made and is not to be trusted."""

    def __init__(self, kind, message, hint):
        super().__init__(message)
        self.kind = kind
        self.hint = hint
