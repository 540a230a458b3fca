"""results.h5 of a run or an analysis: what is no such file is refused before anything stands on it."""

from __future__ import annotations

import os
from pathlib import Path

import h5py

from plica.errors import InvalidInput, StorageFailed

__all__ = ["check_result_file"]


def check_result_file(path: Path) -> None:
    """Nothing where `path` opens as HDF5.

    Raises
    ------
    InvalidInput
        Where it is something else, or was cut off or damaged.
    StorageFailed
        Where the system does not let it be read.
    """
    try:
        with h5py.File(path, "r", locking=False):
            pass
    except OSError as error:
        if error.errno:
            raise StorageFailed(f"{path}: cannot be read: {os.strerror(error.errno)}.") from None
        reason = "damaged or cut off" if h5py.is_hdf5(path) else "no HDF5 file"
        raise InvalidInput(
            f"{path}: not a result file of plica: it is {reason}. Nothing in it can be gone on with: "
            "move it away, or take another directory."
        ) from None
