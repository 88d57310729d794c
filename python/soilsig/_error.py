"""The exception of the module."""


class Error(Exception):
    """A failure of soilsig, in the words of the command line.

    Attributes
    ----------
    message : str
        What happened, and where.
    hint : str or None
        What to do about it.
    status : int
        The exit status that the command line would have: see "Exit statuses" in the reference.
    """

    def __init__(self, message, hint=None, status=3):
        super().__init__(message, hint, status)
        self.message = message
        self.hint = hint
        self.status = status

    def __str__(self):
        return self.message if self.hint is None else f"{self.message}\n  hint: {self.hint}"
