"""Calls of the command line, with progress and Ctrl-C."""

from __future__ import annotations

import os
import sys
import warnings
from collections.abc import Iterable
from typing import Any, NamedTuple

from . import _soilsig

try:
    # Without widgets the bars are text: that is not worth a warning.
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        from tqdm.auto import tqdm
except ImportError:
    tqdm = None

# Where bpy is installed beside this module, its Blender is found.
if sys.executable:
    os.environ["SOILSIG_PYTHON"] = sys.executable


class Answer(NamedTuple):
    """What a command answered.

    Attributes
    ----------
    text : str
        What it printed.
    status : int
        Its exit status: 0, or that of a result that is less than was asked for.
    """

    text: str
    status: int

    def __str__(self) -> str:
        return self.text


class _Listener:
    """Bars for the steps of the work, and its messages on standard error."""

    def __init__(self) -> None:
        self.bar: Any = None

    def begin(self, step: str) -> None:
        if tqdm is not None:
            self.bar = tqdm(desc=step, leave=False)

    def at(self, done: int, total: int, what: str) -> None:
        if self.bar is not None:
            self.bar.total = total
            self.bar.unit = f" {what}"
            self.bar.n = min(done, total)
            self.bar.refresh()

    def say(self, text: str) -> None:
        print(text, file=sys.stderr)

    def end(self, step: str, seconds: float, note: str) -> None:
        self.close()

    def close(self) -> None:
        if self.bar is not None:
            self.bar.close()
            self.bar = None


def run(args: Iterable[Any], *, quiet: int | None = None) -> Answer:
    """Run a command line.

    Parameters
    ----------
    args : iterable
        Its words, without the program's name: ``["spectra", "list"]``. Paths and numbers are
        turned into text.
    quiet : int, optional
        An exit status that draws no Python warning.

    Returns
    -------
    Answer
        The text that the command printed, and its exit status.

    Raises
    ------
    Error
        In the words of the command line.
    KeyboardInterrupt
        After Ctrl-C. No half-written file is left.

    Examples
    --------
    >>> print(soilsig.run(["spectra", "list"]))
    """
    words = ["soilsig", *(os.fspath(a) if isinstance(a, os.PathLike) else str(a) for a in args)]
    listener = _Listener()
    try:
        text, status, meaning = _soilsig.call(words, listener)
    finally:
        listener.close()
    if meaning is not None and status != quiet:
        warnings.warn(meaning, stacklevel=3)
    return Answer(text, status)


def options(**given: Any) -> list[str]:
    """Options of the command line: ``max_paths=9`` is ``--max-paths 9``."""
    words = []
    for name, value in given.items():
        option = "--" + name.rstrip("_").replace("_", "-")
        if value is None or value is False:
            continue
        if value is True:
            words.append(option)
        elif isinstance(value, list):
            words.extend(f"{option}={text(one)}" for one in value)
        else:
            words.append(f"{option}={text(value)}")
    return words


def text(value: Any) -> str:
    """A value as a word of the command line: numbers lose nothing."""
    if isinstance(value, tuple):
        return "-".join(text(one) for one in value)
    return os.fspath(value) if isinstance(value, os.PathLike) else str(value)
