"""Whether the elements of a Gmsh file name nodes that are in it, once each."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

__all__ = ["complaint"]

_Integers = NDArray[np.int64]
_Elements = list[tuple[_Integers, _Integers]]  # numbers (k) and nodes (k, n) of elements of one kind

_NODES = {1: 2, 2: 3, 3: 4, 4: 4, 5: 8, 6: 6, 7: 5, 8: 3, 9: 6, 10: 9, 11: 10, 12: 27, 13: 18, 14: 14, 15: 1}
_NODES |= {
    16: 8,
    17: 20,
    18: 15,
    19: 13,
    20: 9,
    21: 10,
    22: 12,
    23: 15,
    24: 15,
    25: 21,
    26: 4,
    27: 5,
    28: 6,
    29: 20,
}
"""Element type of Gmsh to its number of nodes."""


def complaint(path: Path) -> str | None:
    """What is wrong with the nodes of a file of version 2 or 4, text or binary: a node is there twice, or
    an element with one that is not there. None if nothing is, or if the file is broken in another way, which
    its reader tells."""
    data = path.read_bytes()
    try:
        version, kind, size = data[data.index(b"$MeshFormat") :].split(maxsplit=4)[1:4]
        if version == b"4.0":
            return "is of version 4.0; must be of 2.2 or 4.1"
        binary = kind == b"1"
        if version.startswith(b"4"):
            stream = _Stream(data, f"u{int(size)}" if binary else "")
            nodes, elements = _nodes_4(stream), _elements_4(stream)
        elif binary:
            nodes, elements = _nodes_2(data), _elements_2(data)
        else:
            nodes, elements = _text_2(data)
    except (ValueError, IndexError, KeyError, StopIteration, OverflowError, TypeError):
        return None
    known, times = np.unique(nodes, return_counts=True)
    if (times > 1).any():
        k = int(times.argmax())
        return f"node {known[k]} is in the file {times[k]} times; must be there once"
    if binary and version.startswith(b"2") and not np.array_equal(nodes, np.arange(1, len(nodes) + 1)):
        k = int(np.flatnonzero(nodes != np.arange(1, len(nodes) + 1))[0])
        return (
            f"node {nodes[k]} has the place of node {k + 1}; must be in order in a binary file of version 2"
        )
    for numbers, rows in elements:
        wrong = ~np.isin(rows, known)
        if wrong.any():
            i, j = np.argwhere(wrong)[0]
            return f"element {numbers[i]} has node {rows[i, j]}; must be a node of the file"
    return None


class _Stream:
    """Numbers of the sections of a file of version 4, one after the other.

    Parameters
    ----------
    data : bytes
    size : str
        Type of sizes and node numbers in a binary file, e.g. ``u8``; empty: text.
    """

    def __init__(self, data: bytes, size: str) -> None:
        self.data, self.size, self.at = data, size, 0
        self.words: list[bytes] = []

    def section(self, name: bytes) -> None:
        """Go to the beginning of a section."""
        begin = self.data.index(b"$" + name)
        self.at = self.data.index(b"\n", begin) + 1
        if not self.size:
            self.words, self.at = self.data[self.at : self.data.index(b"$End" + name, begin)].split(), 0

    def sizes(self, count: int) -> _Integers:
        """That many sizes or node numbers."""
        return self._take(count, self.size)

    def integers(self, count: int) -> _Integers:
        """That many integers of four bytes."""
        return self._take(count, "i4")

    def skip_reals(self, count: int) -> None:
        """Past that many coordinates."""
        self.at += count * (8 if self.size else 1)

    def _take(self, count: int, kind: str) -> _Integers:
        if count < 0:
            raise ValueError("a negative count")
        if not self.size:
            found = np.array(self.words[self.at : self.at + count], dtype=np.int64)
            self.at += count
            if len(found) < count:
                raise IndexError("no more numbers")
            return found
        found = np.frombuffer(self.data, dtype=f"<{kind}", count=count, offset=self.at)
        self.at += found.nbytes
        return found.astype(np.int64)


def _nodes_4(stream: _Stream) -> _Integers:
    stream.section(b"Nodes")
    numbers = [np.empty(0, dtype=np.int64)]
    for _ in range(int(stream.sizes(4)[0])):
        dimension, _, parametric = stream.integers(3)
        count = int(stream.sizes(1)[0])
        numbers.append(stream.sizes(count))
        stream.skip_reals(count * int(3 + (dimension if parametric else 0)))
    return np.concatenate(numbers)


def _elements_4(stream: _Stream) -> _Elements:
    stream.section(b"Elements")
    found = []
    for _ in range(int(stream.sizes(4)[0])):
        kind = int(stream.integers(3)[2])
        count = int(stream.sizes(1)[0])
        rows = stream.sizes(count * (1 + _NODES[kind])).reshape(count, -1)
        found.append((rows[:, 0], rows[:, 1:]))
    return found


def _count_2(data: bytes, section: bytes) -> tuple[int, int]:
    """The number in the first line of a section, and where the next line begins."""
    begin = data.index(b"\n", data.index(b"$" + section)) + 1
    end = data.index(b"\n", begin) + 1
    return int(data[begin:end]), end


def _nodes_2(data: bytes) -> _Integers:
    count, at = _count_2(data, b"Nodes")
    kind = np.dtype([("number", "<i4"), ("x", "<f8", (3,))])
    return np.frombuffer(data, dtype=kind, count=count, offset=at)["number"].astype(np.int64)


def _elements_2(data: bytes) -> _Elements:
    count, at = _count_2(data, b"Elements")
    found = []
    while count > 0:
        kind, several, tags = (int(n) for n in np.frombuffer(data, dtype="<i4", count=3, offset=at))
        width = 1 + tags + _NODES[kind]
        if several <= 0 or tags < 0:
            raise ValueError("a count that is not positive")
        rows = np.frombuffer(data, dtype="<i4", count=several * width, offset=at + 12).reshape(several, width)
        found.append((rows[:, 0].astype(np.int64), rows[:, 1 + tags :].astype(np.int64)))
        at, count = at + 12 + rows.nbytes, count - several
    return found


def _text_2(data: bytes) -> tuple[_Integers, _Elements]:
    lines = iter(data.split(b"\n"))
    nodes: list[int] = []
    elements: dict[int, list[list[int]]] = {}  # by their size: number and nodes
    for line in lines:
        if line.strip() == b"$Nodes":
            nodes = [int(next(lines).split()[0]) for _ in range(int(next(lines)))]
        elif line.strip() == b"$Elements":
            for _ in range(int(next(lines))):
                number, _, tags, *rest = (int(word) for word in next(lines).split())
                elements.setdefault(len(rest) - tags, []).append([number, *rest[tags:]])
    rows = [np.array(one, dtype=np.int64) for one in elements.values()]
    return np.array(nodes, dtype=np.int64), [(one[:, 0], one[:, 1:]) for one in rows]
