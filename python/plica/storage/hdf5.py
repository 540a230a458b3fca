"""HDF5 files in which everything that is read back is guarded by a checksum.

Two things guard a file, and `plica.storage.stored.Stored` verifies both when it reads:

- Structure, types and attributes: HDF5's own checksums, which it has in the second version of its
  superblock and object headers (library bounds 1.8) and verifies whenever it reads them. Texts of variable
  length lie in a heap that it does not guard, so that texts are stored at fixed length.
- Data sets: the CRC-32 of their bytes, in a data set of the same name under ``/checksums``; one for the
  whole, or one for each index of the first axis, so that rows can be written and read one by one.

HDF5's filter Fletcher-32 would not do for what a running simulation extends: it guards whole chunks, and a
kill in the middle of rewriting the last one would lose what was whole before. It also takes a word 0xffff for
0x0000, and the index of chunks that goes with these bounds has no checksum. Library bounds from 1.10 on mark
a file that is open for writing, so that a killed run could not be opened again.
"""

from __future__ import annotations

import zlib
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from plica.errors import InvalidInput
from plica.storage.files import replaced

__all__ = [
    "CHECKSUMS",
    "RowWriter",
    "checksum",
    "create",
    "lay_out",
    "put",
    "put_row",
    "put_text",
    "set_text",
    "write_image",
    "write_row",
]

CHECKSUMS = "checksums"
_BOUNDS = ("v108", "v108")


def create(path: Path) -> h5py.File:
    """A new file, open for writing."""
    return h5py.File(path, "w", libver=_BOUNDS, locking=False)


def write_image(path: Path, fill: Callable[[h5py.File], None]) -> None:
    """Write a file that `fill` fills in memory, replacing `path` atomically: a full disk then raises in
    Python, not in HDF5."""

    def write(draft: Path) -> None:
        name = f"image of {path}"  # of its own, so that threads may write several at once
        with h5py.File(name, "w", libver=_BOUNDS, driver="core", backing_store=False) as file:
            fill(file)
            file.flush()
            image = bytes(file.id.get_file_image())
        draft.write_bytes(image)

    replaced(path, write)


def checksum(values: Any, before: int = 0) -> int:
    """CRC-32 of the bytes of an array, row by row; `before`: of what precedes them, with which they go on."""
    array = np.ascontiguousarray(values)
    return zlib.crc32(array.data if array.size else b"", before)


def set_text(owner: Any, name: str, text: str) -> None:
    """Set a short text as an attribute, at fixed length; `put_text` is for long ones."""
    owner.attrs[name] = _fixed(text)


def put_text(file: h5py.File, name: str, text: str) -> None:
    """Add a text of any length as a data set."""
    put(file, name, _fixed(text))


def _fixed(text: str) -> Any:
    raw = text.encode(errors="surrogateescape")  # names of files may be any bytes
    return np.array(raw, dtype=f"S{max(1, len(raw))}")


def put(
    file: Any,
    name: str,
    values: Any,
    unit: str = "1",
    meaning: str = "",
    *,
    rows: bool = False,
    packed: bool = False,
) -> None:
    """Add a data set with its unit and checksum; texts at fixed length.

    Parameters
    ----------
    file : h5py.File
    name : str
        Path in the file.
    values : array_like
        Numbers, or texts.
    unit, meaning : str
    rows : bool
        A checksum for each index of the first axis, for what is read row by row.
    packed : bool
        Compressed.
    """
    array = np.asarray(values)
    if array.dtype.kind in "UO":
        array = np.array([str(value).encode() for value in array.ravel()], dtype=np.bytes_).reshape(
            array.shape
        )
        array = array if array.dtype.itemsize else array.astype("S1")
    how: dict[str, Any] = {"compression": "gzip", "compression_opts": 1} if packed and array.ndim else {}
    if how and rows:
        how["chunks"] = (1, *array.shape[1:])
    data = file.create_dataset(name, data=array, **how)
    _describe(data, unit, meaning)
    sums = [checksum(row) for row in array] if rows else checksum(array)
    file[f"{CHECKSUMS}/{name.strip('/')}"] = np.asarray(sums, dtype=np.uint32)


def lay_out(
    file: Any,
    name: str,
    shape: tuple[int, ...],
    kind: Any,
    unit: str,
    fill: Any = None,
    meaning: str = "",
    *,
    packed: bool = False,
    guarded: bool = True,
) -> h5py.Dataset:
    """Add a data set whose rows come later, by `put_row`.

    Contiguous, allocated and filled at once, so that only raw data change afterwards; or `packed`: each
    row is compressed when it is written. Not `guarded`: its checksums are kept elsewhere by the caller.
    """
    data = _allocated(file, name, shape, kind, fill, packed)
    _describe(data, unit, meaning)
    if guarded:
        _allocated(file, f"{CHECKSUMS}/{name}", shape[:1], np.uint32, 0, False)
    return data


def put_row(file: Any, name: str, index: int, values: Any) -> None:
    """Write one row, and then its checksum, of a data set that was laid out."""
    write_row(file[name], file[f"{CHECKSUMS}/{name}"], index, values)


def write_row(data: h5py.Dataset, sums: h5py.Dataset, index: int, values: Any) -> None:
    """`put_row` for a data set and its checksums that are open already."""
    row = np.broadcast_to(np.asarray(values, dtype=data.dtype), data.shape[1:])
    data[index] = row
    sums[index] = checksum(row)


class RowWriter:
    """Writes rows of a data set again and again, as ``data[start : start + len(rows)] = rows`` does in four
    times the time for few rows.

    Attributes
    ----------
    dtype : dtype
    """

    def __init__(self, data: h5py.Dataset) -> None:
        self.dtype: np.dtype[Any] = data.dtype
        self._name, self._data = data.name, data.id
        self._row, self._place = data.shape[1:], data.id.get_space()

    def write(self, start: int, rows: NDArray[Any]) -> None:
        """Write contiguous rows of the data set's type; the caller keeps their checksum.

        Raises InvalidInput for rows of another shape or type, past whose end it would read.
        """
        if rows.shape[1:] != self._row or rows.dtype != self.dtype:
            raise InvalidInput(
                f"{self._name}: rows = {rows.shape[1:]} of {rows.dtype}; must be {self._row} of "
                f"{self.dtype}. Is the file of another version of plica?"
            )
        count = (len(rows), *self._row)
        self._place.select_hyperslab((start, *(0 for _ in self._row)), count)
        self._data.write(_space(count), self._place, rows)


@lru_cache(maxsize=64)
def _space(shape: tuple[int, ...]) -> h5py.h5s.SpaceID:
    return h5py.h5s.create_simple(shape)


def _describe(data: h5py.Dataset, unit: str, meaning: str) -> None:
    set_text(data, "units", unit)
    if meaning:
        set_text(data, "meaning", meaning)


def _allocated(
    file: Any, name: str, shape: tuple[int, ...], kind: Any, fill: Any, packed: bool
) -> h5py.Dataset:
    properties = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    if packed:
        properties.set_chunk((1, *shape[1:]))
        properties.set_shuffle()
        properties.set_deflate(1)
    else:
        properties.set_layout(h5py.h5d.CONTIGUOUS)
        properties.set_alloc_time(h5py.h5d.ALLOC_TIME_EARLY)
        properties.set_fill_time(h5py.h5d.FILL_TIME_ALLOC)
    if fill is not None:
        properties.set_fill_value(np.array(fill, dtype=kind))
    links = h5py.h5p.create(h5py.h5p.LINK_CREATE)
    links.set_create_intermediate_group(True)
    space = h5py.h5s.create_simple(shape) if shape else h5py.h5s.create(h5py.h5s.SCALAR)
    made = h5py.h5t.py_create(np.dtype(kind), logical=True)
    return h5py.Dataset(h5py.h5d.create(file.id, name.encode(), made, space, dcpl=properties, lcpl=links))
