"""Arrays of NumPy's NPZ archives, of which nothing is unpacked before the stated sizes fit."""

from __future__ import annotations

import math
import struct
import zlib
from collections.abc import Collection
from pathlib import Path
from tokenize import TokenError
from typing import IO, Any
from zipfile import BadZipFile, ZipFile, ZipInfo

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from plica.errors import InvalidInput
from plica.storage.files import require_file

__all__ = ["NPY_ERRORS", "read_npz"]

NPY_ERRORS = (OSError, ValueError, EOFError, TypeError, OverflowError, MemoryError, SyntaxError, TokenError)
"""What NumPy raises for a broken array: its header is an expression of Python."""
_MOST = 1 << 32  # bytes of all arrays, which are kept in memory


def read_npz(path: Path, names: Collection[str]) -> dict[str, NDArray[Any]]:
    """The arrays of these names that an archive has.

    Raises
    ------
    InvalidInput
        If it is no file or no archive of arrays, is damaged (its checksums are verified), or would unpack to
        more than 4 GiB.
    """
    require_file(path, str(path))
    try:
        with ZipFile(path) as archive:
            found = {
                name: archive.getinfo(f"{name}.npy") for name in names if f"{name}.npy" in archive.NameToInfo
            }
            total = sum(member.file_size for member in found.values())
            if total > _MOST:
                raise InvalidInput(
                    f"{path}: its arrays have {total / 1e9:.3g} GB; must be at most {_MOST / 1e9:.3g} GB. "
                    "Store them as HDF5, which is read frame by frame."
                )
            return {name: _array(archive, member) for name, member in found.items()}
    except InvalidInput:
        raise
    except OSError as error:
        raise InvalidInput(f"{path}: cannot be read: {error.strerror or error}.") from None
    except (BadZipFile, zlib.error, struct.error, RuntimeError, *NPY_ERRORS) as error:
        reason = " ".join(str(error).split())  # NotImplementedError is a RuntimeError
        raise InvalidInput(f"{path}: cannot be read as NPZ: {reason}. Is it whole?") from None


def _array(archive: ZipFile, member: ZipInfo) -> NDArray[Any]:
    with archive.open(member) as file:
        shape, column_major, kind = _header(file)
        size = math.prod(shape) * kind.itemsize
        if kind.hasobject or size != member.file_size - file.tell() or min(shape, default=0) < 0:
            raise ValueError(f"{member.filename} is no array of numbers, or has not the size that it states")
        values = np.frombuffer(file.read(), dtype=kind)
    return values.reshape(shape, order="F" if column_major else "C")


def _header(file: IO[bytes]) -> tuple[tuple[int, ...], bool, np.dtype[Any]]:
    version = npy.read_magic(file)
    if version not in ((1, 0), (2, 0)):
        raise ValueError(f"it is of version {version} of the format")
    return npy.read_array_header_1_0(file) if version == (1, 0) else npy.read_array_header_2_0(file)
