"""Middlebury's format for flow.

The four bytes PIEH, width and height (int32), then u, v of each pixel row by row (float32), all
little-endian. u to the right and v downwards in px, on the grid of the first picture.
"""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from plica.errors import InvalidInput, StorageFailed
from plica.storage.files import draft_of, require_file

__all__ = ["read_flow", "write_flow"]

_MAGIC = b"PIEH"
_UNKNOWN = 1e9  # a component beyond it says that the flow there is unknown


def read_flow(path: str | Path) -> NDArray[np.float32]:
    """(rows, columns, 2) flow of a ``.flo`` file; not a number where it is unknown.

    Raises
    ------
    InvalidInput
        Where the file is missing, is not in the format, or ends too early.
    """
    where = f"read_flow: {path}"
    require_file(Path(path), where)
    try:
        data = Path(path).read_bytes()
    except OSError as error:
        raise InvalidInput(f"{where} cannot be read: {error.strerror}.") from None
    if data[:4] != _MAGIC or len(data) < 12:
        raise InvalidInput(f'{where} does not begin with "PIEH" and a size; must be a .flo file.')
    columns, rows = (int(size) for size in np.frombuffer(data, "<i4", 2, 4))
    if columns < 1 or rows < 1 or len(data) != 12 + 8 * columns * rows:
        raise InvalidInput(
            f"{where} has {len(data)} bytes for {columns} x {rows} px; must have 12 + 8 x width x height. "
            "Is it cut off?"
        )
    flow = np.frombuffer(data, "<f4", offset=12).reshape(rows, columns, 2).astype(np.float32)
    flow[~(np.abs(flow) <= _UNKNOWN).all(axis=-1)] = np.nan
    return flow


def write_flow(path: str | Path, flow: ArrayLike) -> None:
    """Write (rows, columns, 2) flow; what is not a number is written as unknown.

    Raises
    ------
    InvalidInput
        On another shape.
    StorageFailed
        Where the file cannot be written; one that was there stays as it was.
    """
    array = np.array(flow, "<f4")
    if array.ndim != 3 or array.shape[2] != 2 or array.size == 0:
        raise InvalidInput(f"write_flow: flow has shape {array.shape}; must be (rows, columns, 2).")
    array[~np.isfinite(array).all(axis=-1)] = 10 * _UNKNOWN
    size = np.array([array.shape[1], array.shape[0]], "<i4")
    target = Path(path)
    part = draft_of(target)
    try:
        part.write_bytes(_MAGIC + size.tobytes() + array.tobytes())
        os.replace(part, target)
    except OSError as error:
        part.unlink(missing_ok=True)
        raise StorageFailed(f"write_flow: {path} cannot be written: {error.strerror}.") from None
