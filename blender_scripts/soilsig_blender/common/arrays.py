"""Arrays that belong together entry by entry, and arrays padded to one length."""

from dataclasses import fields

import numpy as np


class Columns:
    """Base of dataclasses whose fields are arrays of one length."""

    def __len__(self):
        return len(self._arrays()[0])

    def __getitem__(self, which):
        return type(self)(*(array[which] for array in self._arrays()))

    def __add__(self, other):
        return type(self)(*map(np.concatenate, zip(self._arrays(), other._arrays())))

    def _arrays(self):
        return [getattr(self, field.name) for field in fields(self)]


def padded(arrays, tail=(3,)):
    """Arrays of different lengths as one: each is padded with its first entry, or with zeros."""
    most = max(map(len, arrays), default=1)
    whole = np.zeros((len(arrays), most, *tail))
    for row, array in zip(whole, arrays):
        row[: len(array)] = array
        row[len(array) :] = array[0] if len(array) else 0
    return whole
