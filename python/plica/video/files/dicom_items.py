"""Pixel data in items (encapsulated): where the bytes of each frame, or of a video, lie in the file."""

from __future__ import annotations

import io
import struct
from collections.abc import Sequence
from pathlib import Path
from typing import BinaryIO, NamedTuple

from plica.video.errors import VideoError
from plica.video.files.dicom_header import Header

__all__ = ["Item", "Joined", "frames_of", "items_of"]

_ITEM, _END = (0xFFFE, 0xE000), (0xFFFE, 0xE0DD)
_BEGINS = (b"\xff\xd8\xff", b"\xff\x4f\xff\x51")  # of a picture in JPEG, in JPEG 2000
_HEAD = 8  # bytes of tag and length


class Item(NamedTuple):
    """A fragment: the byte of the file at which its value begins, and its bytes."""

    place: int
    length: int


def items_of(file: BinaryIO, header: Header) -> list[Item]:
    """All items of the pixel data, the offset table first.

    Raises
    ------
    VideoError
        Where they do not end as they must.
    """
    end = file.seek(0, io.SEEK_END)
    found: list[Item] = []
    place = file.seek(header.place)
    while True:
        head = file.read(_HEAD)
        if len(head) < _HEAD:
            raise _cut(header, len(found))
        *tag, length = struct.unpack("<HHI", head)
        if tuple(tag) == _END:
            return found
        if tuple(tag) != _ITEM:
            raise VideoError(
                f"Recording: {header.name} has no item at byte {place} of its compressed pixel data; must "
                "have one, or their end. It is damaged: copy it again."
            )
        if place + _HEAD + length > end:
            raise _cut(header, len(found))
        found.append(Item(place + _HEAD, length))
        place = file.seek(place + _HEAD + length)


def _cut(header: Header, items: int) -> VideoError:
    return VideoError(
        f"Recording: {header.name} ends within its compressed pixel data, after {max(items - 1, 0)} whole "
        f"pieces; must have all of its {header.count} frames. It is cut off: copy it again."
    )


def frames_of(file: BinaryIO, header: Header) -> list[list[Item]]:
    """The fragments of each frame: by the offset tables, else one each, else by how pictures begin.

    Raises
    ------
    VideoError
        As :func:`items_of`, and where they are not as many frames as the file states.
    """
    table, *items = items_of(file, header) or [Item(header.place, 0)]
    if header.offsets:
        begins = _starts(header, struct.unpack(f"<{len(header.offsets) // 8}Q", header.offsets), items)
    elif table.length:
        file.seek(table.place)
        begins = _starts(
            header, struct.unpack(f"<{table.length // 4}I", file.read(table.length // 4 * 4)), items
        )
    elif len(items) == header.count:
        begins = list(range(len(items)))
    else:
        begins = [k for k, item in enumerate(items) if _begin(file, item).startswith(_BEGINS)]
    if len(begins) != header.count or begins[:1] != [0]:
        raise VideoError(
            f"Recording: {header.name} states {header.count} frames, and its pixel data have {len(begins)} "
            f"(in {len(items)} pieces); must be the same. Is it cut off? Copy or export it again."
        )
    return [items[begin:end] for begin, end in zip(begins, [*begins[1:], len(items)], strict=True)]


def _begin(file: BinaryIO, item: Item) -> bytes:
    file.seek(item.place)
    return file.read(min(item.length, 4))


def _starts(header: Header, offsets: Sequence[int], items: Sequence[Item]) -> list[int]:
    """Which items the offsets name; they count from the first item."""
    numbers = {item.place - items[0].place: k for k, item in enumerate(items)}
    found = [numbers.get(offset, -1) for offset in offsets]
    if min(found, default=0) < 0 or found != sorted(set(found)):
        raise VideoError(
            f"Recording: {header.name} has a table of offsets that does not name the pieces of its frames; "
            "must name the first one of each, in order. Export it again."
        )
    return found


class Joined(io.RawIOBase):
    """Items of a file as one stream, read only where it is asked for."""

    def __init__(self, path: Path, items: Sequence[Item]) -> None:
        self._file = open(path, "rb")  # noqa: SIM115
        self._items, self._at = items, 0
        self._length = sum(item.length for item in items)

    def readable(self) -> bool:
        """Always."""
        return True

    def seekable(self) -> bool:
        """Always."""
        return True

    def seek(self, offset: int, whence: int = io.SEEK_SET, /) -> int:
        """As of a file."""
        self._at = max(0, offset + {io.SEEK_SET: 0, io.SEEK_CUR: self._at, io.SEEK_END: self._length}[whence])
        return self._at

    def tell(self) -> int:
        """As of a file."""
        return self._at

    def readinto(self, buffer: memoryview, /) -> int:  # type: ignore[override]
        """As of a file: up to the end of the item."""
        begin = 0
        for item in self._items:
            inside = self._at - begin
            if inside < item.length:
                self._file.seek(item.place + inside)
                count = self._file.readinto(memoryview(buffer)[: item.length - inside])
                self._at += count
                return int(count)
            begin += item.length
        return 0

    def close(self) -> None:
        """Of the file too."""
        self._file.close()
        super().close()
