"""Phantom's recordings (.cine), by the structures, the unpacking and the table of levels of pycine-lite.

A file has a header, a picture's header (BITMAPINFOHEADER), the camera's set-up, tagged blocks (of which that
of type 1002 has each picture's time), the places of the pictures, and the pictures, each after an annotation
whose first four bytes are its length. Pixels have 8 or 16 bits, from the bottom row up, of which the camera
uses ``RealBPP``; or are packed, from the top row down: 12 bits, or 10 bits that a table makes 12.
"""

from __future__ import annotations

import ctypes
import struct
from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
import numpy.typing as npt

from plica.errors import library
from plica.video.errors import VideoError
from plica.video.files.camera_metadata import Camera
from plica.video.files.frame_times import even_step
from plica.video.files.limits import MOST_FRAMES

__all__ = ["Phantom"]

_UNPACKED, _PACKED_10, _PACKED_12 = 0, 256, 1024  # biCompression
_GREY = 0  # Compression: of the file; others are JPEG and raw colour
_TIMES = 1002  # tagged block
_MOST_BLOCKS = 10_000
_SAME_RATE = 0.01  # relative, of the set-up's rate and that of the pictures' times


class Phantom:
    """A .cine file; grey levels are the camera's, without its black and white level or its gamma.

    Raises
    ------
    VideoError
        Where pycine-lite is not installed; for a file that is none, is cut off, is raw colour, or whose
        frames are not equally spaced in time.
    """

    def __init__(self, path: Path) -> None:
        self.name, self._path = path.name, path
        cine, lin_lut, raw = (
            library(f"pycine.{part}", "cine", f"Recording: {path.name}", VideoError)
            for part in ("cine", "linLUT", "raw")
        )
        self._unpack = {_PACKED_10: raw.unpack_10bit, _PACKED_12: raw.unpack_12bit}
        self._table = np.asarray(lin_lut.linLUT, np.uint16)
        try:
            with open(path, "rb") as file:
                head = _structure(file, cine.CINEFILEHEADER, 0)
                if head.Type != int.from_bytes(b"CI", "little"):
                    raise VideoError(f"Recording: {path.name} is no .cine file: it does not begin with CI.")
                picture = _structure(file, cine.BITMAPINFOHEADER, head.OffImageHeader)
                setup = _structure(file, cine.SETUP, head.OffSetup)
                self.count = int(head.ImageCount)
                self._check_count(int(head.OffImageOffsets) + 8 * self.count)
                self._places = np.array(_read(file, head.OffImageOffsets, f"<{self.count}q"), np.int64)
                times = _times(file, head.OffSetup + setup.Length, head.OffImageOffsets, self.count)
        except struct.error:
            raise VideoError(f"Recording: {path.name} is cut off in its header; copy it again.") from None
        self.shape = abs(int(picture.biHeight)), int(picture.biWidth)
        self._kind, self._bits = int(picture.biCompression), int(picture.biBitCount)
        self._check(int(head.Compression), int(setup.CFA))
        used = int(setup.RealBPP) or self._bits
        self._depth = 12 if self._kind == _PACKED_10 else used if self._bits <= 16 else self._bits // 3
        whole = 0 < int(head.TotalImageCount) <= self.count
        rate = self._rate(float(setup.FrameRate), times, whole)
        self.camera: Camera | None = Camera(rate, _date(head.TriggerTime), self._depth)

    def pixels(self, begin: int, end: int) -> Iterator[tuple[str, npt.NDArray[Any]]]:
        with open(self._path, "rb") as file:
            for index in range(begin, min(end, self.count)):
                try:
                    (annotation,) = _read(file, int(self._places[index]), "<I")
                    file.seek(int(self._places[index]) + annotation)
                    pixels = self._pixels(file.read(self._size()))
                except (struct.error, ValueError, OSError):
                    raise VideoError(
                        f"Recording: {self.name}: frame {index} is not whole. The {index} frames before "
                        "it are: copy the file again, or store those in a file of their own."
                    ) from None
                most = int(pixels.max())
                if most >> self._depth:
                    raise VideoError(
                        f"Recording: {self.name}: frame {index} has a grey level of {most}; must be below "
                        f"{1 << self._depth}, as its header states {self._depth} bits."
                    )
                yield f"{self.name}: frame {index}", pixels

    def _size(self) -> int:
        bits = {_PACKED_10: 10, _PACKED_12: 12}.get(self._kind, self._bits)
        return self.shape[0] * self.shape[1] * bits // 8

    def _pixels(self, data: bytes) -> npt.NDArray[Any]:
        """Whole numbers, (h, w), or (h, w, 3) red first."""
        if len(data) != self._size():
            raise ValueError("cut off")
        height, width = self.shape
        if self._kind != _UNPACKED:
            found = self._unpack[self._kind](data, width, height)
            return np.asarray(self._table[found] if self._kind == _PACKED_10 else found)
        numbers = np.frombuffer(data, "u1" if self._bits in (8, 24) else "<u2")
        found = numbers.reshape(height, width, -1)[::-1, :, ::-1]
        return found[..., 0] if found.shape[2] == 1 else found

    def _rate(self, stated: float, times: npt.NDArray[np.float64] | None, whole: bool) -> float | None:
        """Frames per second: as stated, but where the pictures' times say another, as only some were stored.

        `whole`: all that the camera took are in the file, so that both must agree.
        """
        step = None if times is None else even_step(self.name, times)
        if step is None or (stated and abs(1 / (step * stated) - 1) <= _SAME_RATE):
            return stated or None
        if stated and whole:
            raise VideoError(
                f"Recording: {self.name} states {stated:g} frames/s, and its frames' times {1 / step:.6g}; "
                "must be the same, as it has all frames that were taken. Store it as TIFF or AVI in the "
                "camera's program, and give the rate that is right (--fps)."
            )
        return 1 / step

    def _check_count(self, end: int) -> None:
        """`end`: of the table of the frames' places."""
        if self.count > MOST_FRAMES:
            raise VideoError(
                f"Recording: {self.name} states {self.count} frames; must be at most {MOST_FRAMES}. Store "
                "the part that is to be analysed in a file of its own."
            )
        if end > (there := self._path.stat().st_size):
            raise VideoError(
                f"Recording: {self.name} has {there} bytes; must have {end} for the places of the "
                f"{self.count} frames that it states. It is cut off: copy it again."
            )

    def _check(self, compression: int, filters: int) -> None:
        if compression != _GREY or filters:
            raise VideoError(
                f"Recording: {self.name} is raw colour or JPEG (compression {compression}, filters "
                f"{filters}); must be grey or interpolated colour: store it as TIFF or AVI in the camera's "
                "program."
            )
        if self._kind not in (_UNPACKED, _PACKED_10, _PACKED_12) or (
            self._kind == _UNPACKED and self._bits not in (8, 16, 24, 48)
        ):
            raise VideoError(
                f"Recording: {self.name} has {self._bits} bits a pixel, packed by method {self._kind}; must "
                "be 8, 16, 24 or 48 without packing, or packed 10 or 12. Store it so in the camera's program."
            )
        if not 0 < self.shape[0] * self.shape[1] < 1 << 28:
            raise VideoError(
                f"Recording: {self.name} states {self.shape[1]} x {self.shape[0]} px; must be a picture."
            )


def _structure(file: BinaryIO, kind: Any, place: int) -> Any:
    """What lies there; a set-up of an older camera is shorter, and what it lacks is 0."""
    file.seek(place)
    data = file.read(ctypes.sizeof(kind))
    if hasattr(kind, "Length") and len(data) > 144:
        data = data[: int.from_bytes(data[142:144], "little")]
    elif len(data) < ctypes.sizeof(kind):
        raise struct.error
    return kind.from_buffer_copy(data.ljust(ctypes.sizeof(kind), b"\0"))


def _read(file: BinaryIO, place: int, form: str) -> tuple[Any, ...]:
    file.seek(place)
    return struct.unpack(form, file.read(struct.calcsize(form)))


def _times(file: BinaryIO, begin: int, end: int, count: int) -> npt.NDArray[np.float64] | None:
    """(count) s of each picture since 1970; None where the file does not say."""
    for _ in range(_MOST_BLOCKS):
        if begin + 8 > end:
            return None
        size, kind, _ = _read(file, begin, "<IHH")
        if size < 8:
            return None
        if kind == _TIMES and size >= 8 + 8 * count:
            parts = np.array(_read(file, begin + 8, f"<{2 * count}I"), float).reshape(count, 2)
            return np.asarray(parts[:, 1] - parts[0, 1] + parts[:, 0] / 2.0**32)
        begin += size
    raise struct.error


def _date(trigger: Any) -> str | None:
    """Of the trigger, UTC."""
    seconds = int(trigger.seconds)
    return datetime.fromtimestamp(seconds, UTC).strftime("%Y-%m-%d %H:%M:%S UTC") if seconds else None
