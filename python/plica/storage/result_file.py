"""Check of results.h5 of a run or an analysis before it is used."""

from __future__ import annotations

import os
from pathlib import Path

import h5py

from plica.errors import InvalidInput, StorageFailed

__all__ = ["check_result_file"]


def check_result_file(path: Path) -> None:
    """Raise unless `path` opens as HDF5.

    Raises
    ------
    InvalidInput
        If it is something else, truncated or damaged.
    StorageFailed
        If the system refuses to read it.
    """
    try:
        with h5py.File(path, "r", locking=False):
            pass
    except OSError as error:
        if error.errno:
            raise StorageFailed(f"{path}: cannot be read: {os.strerror(error.errno)}.") from None
        reason = "damaged or truncated" if h5py.is_hdf5(path) else "not an HDF5 file"
        raise InvalidInput(
            f"{path}: is {reason}; must be a result file of plica. Move it away, or use another directory."
        ) from None
