"""Takes out of a .blend what differs from run to run, so that the same bed gives the same bytes.

A .blend is a dump of Blender's structs. Every block carries the address it had in memory, and
pointers between blocks are those addresses. Blender uses them as names only, so they are replaced
by the blocks' running numbers. A pointer to something that is not in the file means nothing to a
reader and becomes null. Padding holds whatever was in memory, and a few fields are drawn at
random. What lies where is told by the description of the structs (SDNA) in every .blend.
"""

import re
import struct
from functools import cache

import numpy as np

_POINTER = 8
# Drawn at random by Blender: the colours of face sets, and node numbers that need only differ.
_ZEROED = {b"face_sets_color_seed"}
_NUMBERED = {(b"bNode", b"identifier")}
# The two ends of a screen's edge, which Blender sorts by address.
_SORTED = {b"ScrEdge": (b"*v1", b"*v2")}


def remove(path):
    """Rewrites the uncompressed .blend at `path`; a layout that is not known raises ValueError."""
    with open(path, "rb") as file:
        data = bytearray(file.read())
    blocks = list(_blocks(data))
    dna = _Dna(next(bytes(data[b.start : b.end]) for b in blocks if b.code == b"DNA1"))
    number = {0: 0}
    for i, block in enumerate(blocks, 1):
        number.setdefault(block.address, 16 * i)
    for i, block in enumerate(blocks, 1):
        struct.pack_into("<Q", data, block.address_at, number[block.address])
        if block.code in (b"DNA1", b"ENDB"):
            continue
        if block.struct == 0:
            _renumber_untyped(data, block, number)
        else:
            _rewrite(data, block, dna, number, i)
    with open(path, "wb") as file:
        file.write(data)


def _renumber_untyped(data, block, number):
    # Plain numbers, or a bare array of pointers: all of them to known blocks.
    words = np.frombuffer(data, "<u8", (block.end - block.start) // _POINTER, block.start)
    values = words.tolist()
    if all(value in number for value in values):
        words[:] = [number[value] for value in values]


def _rewrite(data, block, dna, number, running):
    size = dna.sizes[block.struct]
    items = np.frombuffer(data, "u1", block.count * size, block.start).reshape(block.count, size)
    for at, width in dna.noise(block.struct):
        items[:, at : at + width] = 0
    for at in dna.numbered(block.struct):
        items[:, at : at + 4] = np.array([running], "<i4").view("u1")
    pointers = dna.pointers(block.struct)
    if pointers:
        at = (np.array(pointers)[:, None] + np.arange(_POINTER)).ravel()
        words = np.ascontiguousarray(items[:, at]).view("<u8")
        renumbered = [number.get(value, 0) for value in words.ravel().tolist()]
        words = np.array(renumbered, "<u8").reshape(words.shape)
        items[:, at] = words.view("u1")
    ends = dna.sorted(block.struct)
    if ends:
        first, second = (items[:, at : at + _POINTER].copy() for at in ends)
        swap = first.view("<u8") > second.view("<u8")
        items[:, ends[0] : ends[0] + _POINTER] = np.where(swap, second, first)
        items[:, ends[1] : ends[1] + _POINTER] = np.where(swap, first, second)


class _Block:
    def __init__(self, code, address, address_at, index, count, start, size):
        self.code = code.rstrip(b"\0")
        self.address = address
        self.address_at = address_at
        self.struct = index
        self.count = count
        self.start = start
        self.end = start + size


def _blocks(data):
    if re.match(rb"BLENDER-v\d{3}", data):
        at = 12
        while at < len(data):
            code, size, address, index, count = struct.unpack_from("<4siQii", data, at)
            yield _Block(code, address, at + 8, index, count, at + 24, size)
            at += 24 + size
    elif re.match(rb"BLENDER17-01v\d{4}", data):
        at = 17
        while at < len(data):
            code, index, address, size, count = struct.unpack_from("<4siQqq", data, at)
            yield _Block(code, address, at + 8, index, count, at + 32, size)
            at += 32 + size
    else:
        raise ValueError(f"a .blend that begins with {bytes(data[:17])!r}")


class _Dna:
    """The layout of every struct: its size and where its pointers are."""

    def __init__(self, dna):
        self.at = 4
        self.dna = dna
        self.names = self._strings(b"NAME")
        self.types = self._strings(b"TYPE")
        self._tag(b"TLEN")
        self.lengths = self._shorts(len(self.types))
        self._tag(b"STRC")
        self.structs = []
        for _ in range(self._int()):
            kind, count = self._shorts(2)
            members = self._shorts(2 * count)
            self.structs.append((kind, list(zip(members[::2], members[1::2]))))
        self.struct_of = {kind: i for i, (kind, _) in enumerate(self.structs)}
        self.sizes = [self.lengths[kind] for kind, _ in self.structs]

    @cache  # noqa: B019 (lives as long as the file is rewritten)
    def fields(self, index):
        """Plain fields of a struct and of those inside it: (offset, size, struct, name)."""
        found, at = [], 0
        kind, members = self.structs[index]
        for member, name in members:
            name = self.names[name]
            repeats = int(np.prod([int(n) for n in re.findall(rb"\[(\d+)\]", name)], dtype=int))
            is_pointer = name.startswith((b"*", b"(*"))
            size = _POINTER if is_pointer else self.lengths[member]
            inside = [(0, size, self.types[kind], name.partition(b"[")[0])]
            if not is_pointer and member in self.struct_of:
                inside = self.fields(self.struct_of[member])
            for i in range(repeats):
                found += [(at + i * size + offset, *rest) for offset, *rest in inside]
            at += size * repeats
        return found

    @cache  # noqa: B019
    def pointers(self, index):
        return [at for at, _, _, name in self.fields(index) if name.startswith((b"*", b"(*"))]

    @cache  # noqa: B019
    def noise(self, index):
        return [
            (at, size)
            for at, size, _, name in self.fields(index)
            if name in _ZEROED or name.startswith(b"_pad")
        ]

    @cache  # noqa: B019
    def numbered(self, index):
        return [at for at, _, kind, name in self.fields(index) if (kind, name) in _NUMBERED]

    @cache  # noqa: B019
    def sorted(self, index):
        wanted = _SORTED.get(self.types[self.structs[index][0]], ())
        return [at for at, _, _, name in self.fields(index) if name in wanted]

    def _tag(self, tag):
        self.at = (self.at + 3) // 4 * 4
        if self.dna[self.at : self.at + 4] != tag:
            raise ValueError(f"a .blend without {tag.decode()} where it belongs")
        self.at += 4

    def _strings(self, tag):
        self._tag(tag)
        found = []
        for _ in range(self._int()):
            end = self.dna.index(b"\0", self.at)
            found.append(self.dna[self.at : end])
            self.at = end + 1
        return found

    def _int(self):
        (value,) = struct.unpack_from("<i", self.dna, self.at)
        self.at += 4
        return value

    def _shorts(self, count):
        values = struct.unpack_from(f"<{count}H", self.dna, self.at)
        self.at += 2 * count
        return values
