"""Failures that the caller is told of by kind, with what to do about them."""


class BedError(Exception):
    """A bed that cannot be made, or was made and is not to be trusted."""

    def __init__(self, kind, message, hint):
        super().__init__(message)
        self.kind = kind
        self.hint = hint


class RecipeError(BedError):
    """Something in the scene file is wrong; `key` says where."""

    def __init__(self, key, message, hint):
        super().__init__("scene", f"{key}: {message}", hint)
