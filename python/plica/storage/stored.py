"""Read the files of `plica.storage.hdf5`: what is damaged, or lies outside the file, is an error."""

from __future__ import annotations

import os
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType
from typing import Any, Literal, Self

import h5py
import numpy as np
from numpy.typing import NDArray

from plica.errors import Damaged, InvalidInput, StorageFailed
from plica.storage.files import require_file
from plica.storage.hdf5 import CHECKSUMS, checksum, write_row

__all__ = ["Rows", "Stored", "inside"]

_MOST_PACKED = 1100  # deflate makes at most 1032 bytes of one
_AGAIN = "Copy it again from where it is whole, or use another directory"
_BROKEN = (OSError, RuntimeError, KeyError, ValueError, TypeError, AttributeError, OverflowError, MemoryError)


class Stored:
    """A file of results, open; nothing in it is read unverified.

    Parameters
    ----------
    path : Path
    mode : {"r", "r+"}
    hint : str
        What to do if the file is damaged.
    verified : bool
        False: a file of another program, without checksums.

    Raises
    ------
    Damaged
        If it is truncated or damaged, here or when a part of it is read.
    InvalidInput
        If it is no regular file, or no HDF5; when a part of it lies in another file.
    StorageFailed
        If the system refuses to open it.
    """

    def __init__(
        self, path: Path, mode: Literal["r", "r+"] = "r", *, hint: str = _AGAIN, verified: bool = True
    ) -> None:
        self.path, self._hint, self._verified = path, hint, verified
        self.file = _open(path, mode, hint=hint, what="a result file of plica" if verified else "one")
        self._sums: dict[str, NDArray[np.uint32]] = {}
        self._written: dict[str, tuple[h5py.Dataset, h5py.Dataset]] = {}

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Close the file."""
        self.file.close()

    def __contains__(self, name: str) -> bool:
        with self._errors(name):
            return inside(self.file, name, self.path) is not None

    def names(self, group: str) -> list[str]:
        """The names in a group, sorted; empty if there is no such group."""
        with self._errors(group):
            found = inside(self.file, group, self.path)
            return sorted(found) if isinstance(found, h5py.Group) else []

    def require_own(self) -> None:
        """Raise InvalidInput unless everything that a link names is in the file itself."""
        with self._errors("/"):
            names: list[str] = []
            self.file.visititems_links(lambda name, _: names.append(name))  # must not raise itself
            for name in names:
                inside(self.file, name, self.path)

    def is_group(self, name: str) -> bool:
        """Whether there is a group of this name."""
        with self._errors(name):
            return isinstance(inside(self.file, name, self.path), h5py.Group)

    def data(self, name: str) -> h5py.Dataset:
        """A data set, for its shape and type; raises InvalidInput if there is none."""
        with self._errors(name):
            found = inside(self.file, name, self.path)
        if not isinstance(found, h5py.Dataset):
            raise InvalidInput(
                f"{self.path}: has no {name}; must have it. "
                "Is it from another version of plica? Make it again."
            )
        return found

    def read(self, name: str) -> Any:
        """All of a data set."""
        data = self.data(name)
        with self._errors(name):
            values = data[()]
        if not self._verified:
            return values
        sums = self.checksums(name)
        rowwise = sums.ndim == 1
        whole = (
            np.shape(values)[:1] == sums.shape and all(map(self._is, values, sums))
            if rowwise
            else (self._is(values, sums))
        )
        if not whole:
            raise self.damaged(name)
        return values

    def row(self, name: str, index: int) -> Any:
        """One index of the first axis."""
        return self.row_of(self.data(name), name, index)

    def row_of(self, data: h5py.Dataset, name: str, index: int) -> Any:
        """`row` of a data set that is open already."""
        with self._errors(name):
            values = data[index]
        if not self._verified:
            return values
        sums = self.checksums(name)
        if sums.shape != data.shape[:1] or not self._is(values, sums[index]):
            raise self.damaged(f"{name}[{index}]")
        return values

    def rows(self, name: str) -> Rows:
        """A data set of which each index of the first axis is read when it is asked for."""
        return Rows(self, name)

    def whole(self, name: str) -> h5py.Dataset:
        """A data set all of whose rows have been verified, to be read in parts of another kind."""
        for _ in self.rows(name):
            pass
        return self.data(name)

    def copy_into(self, other: h5py.File, without: Collection[str] = ()) -> None:
        """Copy attributes and groups, but for these, with the checksums that they have."""
        with self._errors("/"):
            other.attrs.update(self.file.attrs)
            for name in set(self.names("/")) - {CHECKSUMS, *without}:
                for path in (name, f"{CHECKSUMS}/{name}"):
                    if inside(self.file, path, self.path) is not None:
                        other.require_group(path.rpartition("/")[0] or "/")
                        self.file.copy(path, other, path)

    def put_row(self, name: str, index: int, values: Any) -> None:
        """Write one index of the first axis, and its checksum."""
        self._sums.pop(name, None)
        if name not in self._written:  # to look them up takes longer than to write a row
            self._written[name] = self.data(name), self.data(f"{CHECKSUMS}/{name}")
        write_row(*self._written[name], index, values)

    def first(self, name: str, count: int, expected: int) -> NDArray[Any]:
        """The first `count` rows, of which the checksum is known."""
        data = self.data(name)
        with self._errors(name):
            values: NDArray[Any] = data[:count]
        if len(values) != count or not self._is(values, expected):
            raise self.damaged(name)
        return values

    def text(self, name: str) -> str:
        """A text that is a data set."""
        with self._errors(name):
            return bytes(self.read(name)).decode(errors="surrogateescape")

    def texts(self, name: str) -> list[str]:
        """Texts that are a data set."""
        with self._errors(name):
            return [bytes(text).decode() for text in self.read(name)]

    def attribute(self, owner: str, name: str) -> Any:
        """An attribute of a data set or group, a text as str; None if there is none."""
        with self._errors(f"{owner}: {name}"):
            found = inside(self.file, owner, self.path)
            if found is None or name not in found.attrs:
                return None
            value = found.attrs[name]
            return bytes(value).decode(errors="surrogateescape") if isinstance(value, bytes) else value

    def attributes(self, owner: str) -> dict[str, Any]:
        """All attributes of a data set or group, by name; empty if it is not there."""
        with self._errors(owner):
            found = inside(self.file, owner, self.path)
            names = [] if found is None else list(found.attrs)
        return {name: self.attribute(owner, name) for name in names}

    def damaged(self, name: str) -> Damaged:
        """The error for a part that is."""
        part = name.strip("/") or "its structure"
        if not self._verified:
            return Damaged(f"{self.path}: {part} is damaged: it cannot be read; must be whole. {self._hint}.")
        return Damaged(
            f"{self.path}: {part} is damaged: it is not what its checksum says; must be as plica wrote it. "
            f"{self._hint}."
        )

    @staticmethod
    def _is(values: Any, expected: Any) -> bool:
        return checksum(values) == int(expected)

    def checksums(self, name: str) -> NDArray[np.uint32]:
        """The checksums of a data set: of the whole (), or of each index of its first axis."""
        name = name.strip("/")
        if name not in self._sums:
            if f"{CHECKSUMS}/{name}" not in self:
                raise InvalidInput(
                    f"{self.path}: {name} has no checksum; must have one. It is from an earlier version of "
                    "plica, or from another program. Make it again."
                )
            with self._errors(name):
                self._sums[name] = np.asarray(self.data(f"{CHECKSUMS}/{name}")[()], dtype=np.uint32)
        return self._sums[name]

    @contextmanager
    def _errors(self, name: str) -> Iterator[None]:
        try:
            yield
        except (InvalidInput, StorageFailed):
            raise
        except _BROKEN:
            raise self.damaged(name) from None


class Rows:
    """A data set of a file that stays open, read and verified by indices of its first axis.

    Attributes
    ----------
    shape : tuple of int
    dtype : dtype
    ndim : int
    """

    def __init__(self, file: Stored, name: str) -> None:
        self._file, self._name, self._data = file, name, file.data(name)
        self.shape, self.dtype, self.ndim = tuple(self._data.shape), self._data.dtype, self._data.ndim

    def __len__(self) -> int:
        return int(self.shape[0])

    def __iter__(self) -> Iterator[Any]:
        return map(self.__getitem__, range(len(self)))

    def __getitem__(self, index: int) -> Any:
        return self._file.row_of(self._data, self._name, index)

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]:
        return np.asarray(self._file.read(self._name), dtype)


def _open(path: Path, mode: Literal["r", "r+"], *, hint: str, what: str) -> h5py.File:
    """A file that is HDF5, or the error says `what` it must be; raises as `Stored`."""
    require_file(path, str(path))
    try:
        return h5py.File(path, mode, locking=False)
    except OSError as error:
        if error.errno:
            raise StorageFailed(f"{path}: cannot be read: {os.strerror(error.errno)}.") from None
        if not h5py.is_hdf5(path):
            raise InvalidInput(f"{path}: is not an HDF5 file; must be {what}. {hint}.") from None
    except _BROKEN:
        pass
    raise Damaged(f"{path}: is damaged or truncated; must be as plica wrote it. {hint}.")


def inside(file: Any, name: str, path: Path) -> h5py.Group | h5py.Dataset | None:
    """The group or data set of this name; None if there is none.

    Raises InvalidInput if a link on the way to it leaves the file or is symbolic, if its data lie in another
    file, or if it states far more data than the file holds.
    """
    at: Any = file
    walked = ""
    for part in filter(None, name.split("/")):
        if not isinstance(at, h5py.Group):
            return None
        walked += f"/{part}"
        if not at.id.links.exists(part.encode()):
            return None
        if at.id.links.get_info(part.encode()).type != h5py.h5l.TYPE_HARD:
            raise InvalidInput(
                f"{path}: {walked} is a link to elsewhere; must be in the file itself. Copy the data into it."
            )
        at = at[part]
    if isinstance(at, h5py.Dataset):
        _require_own(at, path)
    return at if isinstance(at, h5py.Dataset | h5py.Group) else None


def _require_own(data: h5py.Dataset, path: Path) -> None:
    """Raise InvalidInput unless the data set's numbers are all in its own file."""
    name = str(data.name)
    properties = data.id.get_create_plist()
    layout = properties.get_layout()
    if layout == h5py.h5d.VIRTUAL or properties.get_external_count():
        raise InvalidInput(
            f"{path}: {name} has its data in another file; must have them in the file itself. "
            "Copy the data into it."
        )
    held = min(data.id.get_storage_size(), path.stat().st_size)
    held *= _MOST_PACKED if properties.get_nfilters() else 1
    if data.nbytes > held:
        raise InvalidInput(
            f"{path}: {name} states {data.nbytes / 1e6:.6g} MB, of which the file can hold at most "
            f"{held / 1e6:.6g} MB; must hold all of them. Is it cut off, or was it never filled?"
        )
