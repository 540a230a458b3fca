"""Photron's recordings: pixels in NAME.mraw, what they are in NAME.cih (text) or NAME.cihx (XML).

The pixels are those of all frames one after the other, from the top left, without headers: 8 bits each, 16
bits in little-endian order, or 10 or 12 bits packed without gaps, the most significant bit first. Of 16 bits
the camera's own depth (``EffectiveBit Depth``) fills the lower or the upper ones (``EffectiveBit Side``).
"""

from __future__ import annotations

import math
import re
import xml.etree.ElementTree as ET
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from plica.errors import InvalidInput
from plica.storage.files import require_file
from plica.video.errors import VideoError
from plica.video.files.camera_metadata import Camera

__all__ = ["Photron", "unpacked"]

HEADERS = (".cihx", ".cih")

_NAMES = {
    "Record Rate(fps)": "recordInfo/recordRate",
    "Total Frame": "frameInfo/totalFrame",
    "Image Width": "imageDataInfo/resolution/width",
    "Image Height": "imageDataInfo/resolution/height",
    "Color Type": "imageDataInfo/colorInfo/type",
    "Color Bit": "imageDataInfo/colorInfo/bit",
    "EffectiveBit Depth": "imageDataInfo/effectiveBit/depth",
    "EffectiveBit Side": "imageDataInfo/effectiveBit/side",
    "File Format": "imageFileInfo/fileFormat",
    "Save Step": "frameInfo/skipFrame",
    "Date": "fileInfo/date",
    "Time": "fileInfo/time",
}
"""What is read: its name in .cih, and its place in .cihx."""

_MOST_HEADER = 1 << 24  # bytes
_STORED = (8, 10, 12, 16)  # bits a pixel


class Photron:
    """A recording of a Photron camera, given by its .mraw, .cih or .cihx file; grey levels are the camera's.

    Raises
    ------
    VideoError
        Where one of the two files is missing, or says what the other does not hold; for colour.
    """

    def __init__(self, path: Path) -> None:
        header, self._path = _both(path)
        self.name = self._path.name
        said = _fields(header)
        self._header = header.name
        self.count, width, height, self._stored, self._depth = (
            self._whole(said, name)
            for name in ("Total Frame", "Image Width", "Image Height", "Color Bit", "EffectiveBit Depth")
        )
        self.shape = height, width
        self._check(said)
        side = said.get("EffectiveBit Side", "Lower").lower()
        if side not in ("lower", "higher"):
            raise self._wrong(f'EffectiveBit Side = "{side}"', "Lower or Higher")
        self._shift = self._stored - self._depth if side == "higher" else 0
        self.camera: Camera | None = Camera(_rate(said), _date(said), self._depth)

    def pixels(self, begin: int, end: int) -> Iterator[tuple[str, npt.NDArray[Any]]]:
        size = self.shape[0] * self.shape[1] * self._stored // 8
        with open(self._path, "rb") as file:
            file.seek(begin * size)
            for index in range(begin, min(end, self.count)):
                pixels = unpacked(file.read(size), self._stored) >> self._shift
                most = int(pixels.max())
                if most >> self._depth:
                    raise VideoError(
                        f"Recording: {self.name}: frame {index} has a grey level of {most}; must be below "
                        f"{1 << self._depth}, as {self._header} states {self._depth} bits."
                    )
                yield f"{self.name}: frame {index}", pixels.reshape(self.shape)

    def _check(self, said: Mapping[str, str]) -> None:
        kind, form = said.get("Color Type", "Mono"), said.get("File Format", "MRaw")
        if kind.lower() not in ("mono", "monochrome"):
            raise self._wrong(f'Color Type = "{kind}"', "Mono: store colour as AVI or TIFF")
        if form.lower() != "mraw":
            raise self._wrong(f'File Format = "{form}"', "MRaw: name the AVI, or the folder, beside it")
        if self._stored not in _STORED:
            raise self._wrong(f"Color Bit = {self._stored}", "8, 10, 12 or 16: store colour as AVI or TIFF")
        if not 1 <= self._depth <= self._stored:
            raise self._wrong(f"EffectiveBit Depth = {self._depth}", f"in [1, {self._stored}], of Color Bit")
        bits = self.shape[0] * self.shape[1] * self._stored
        there = self._path.stat().st_size
        if bits % 8 or there != self.count * bits // 8:
            raise VideoError(
                f"Recording: {self.name} has {there} bytes; must have {self.count * bits / 8:.15g}, as "
                f"{self._header} states {self.count} frames of {self.shape[1]} x {self.shape[0]} px of "
                f"{self._stored} bits. Is it cut off, or another recording's? Copy both files again."
            )

    def _whole(self, said: Mapping[str, str], name: str) -> int:
        value = said.get(name)
        if value is None:
            raise self._wrong(f"{name} is missing", "there. Is it the header of this recording?")
        if not re.fullmatch(r"0*[1-9]\d{0,8}", value):
            raise self._wrong(f'{name} = "{value}"', "a whole number, 1 or more")
        return int(value)

    def _wrong(self, what: str, must: str) -> VideoError:
        return VideoError(f"Recording: {self._header}: {what}; must be {must}.")


def unpacked(data: bytes, bits: int) -> npt.NDArray[np.uint16]:
    """(pixels) of `bits` bits: 8, 16 (little-endian), or 10 or 12 packed, the most significant bit first."""
    if bits == 8:
        return np.frombuffer(data, np.uint8).astype(np.uint16)
    if bits == 16:
        return np.frombuffer(data, "<u2").astype(np.uint16)
    digits = np.unpackbits(np.frombuffer(data, np.uint8)).reshape(-1, bits)
    whole = np.zeros((len(digits), 16), np.uint8)
    whole[:, 16 - bits :] = digits
    return np.packbits(whole, axis=1).view(">u2")[:, 0].astype(np.uint16)


def _both(path: Path) -> tuple[Path, Path]:
    """The header and the pixels of a recording."""
    beside = {other.suffix.lower(): other for other in path.parent.iterdir() if other.stem == path.stem}
    header = path if path.suffix.lower() in HEADERS else next(
        (beside[suffix] for suffix in HEADERS if suffix in beside), None
    )  # fmt: skip
    pixels = beside.get(".mraw")
    for file in filter(None, (header, pixels)):
        try:
            require_file(file, f"Recording: {file}")
        except InvalidInput as error:
            raise VideoError(str(error)) from None
    if header is None or pixels is None:
        wanted = f"{path.stem}.cih or {path.stem}.cihx" if header is None else f"{path.stem}.mraw"
        raise VideoError(
            f"Recording: {path.name} without {wanted}; must have it in its folder: a Photron camera's frames "
            "are in the one, what they are in the other."
        )
    return header, pixels


def _fields(header: Path) -> dict[str, str]:
    """What the header says, by the names of .cih."""
    if (size := header.stat().st_size) > _MOST_HEADER:
        raise VideoError(
            f"Recording: {header.name} has {size} bytes; must be a header of at most {_MOST_HEADER}. Is it "
            "the file of the frames?"
        )
    raw = header.read_bytes()
    if header.suffix.lower() == ".cih":
        lines = (line.partition(":") for line in raw.decode("latin-1").splitlines())
        return {name.strip(): value.strip() for name, colon, value in lines if colon}
    begin, end = raw.find(b"<cih>"), raw.rfind(b"</cih>")  # binary data lie about it
    try:
        root = ET.fromstring(raw[begin : end + len(b"</cih>")].decode("utf-8") if 0 <= begin < end else "")
    except (ET.ParseError, UnicodeDecodeError) as error:
        raise VideoError(
            f"Recording: {header.name} has no camera's header ({error}); must have <cih> ... </cih>. Is it "
            "whole?"
        ) from None
    found = {name: root.findtext(place) for name, place in _NAMES.items()}
    return {name: value.strip() for name, value in found.items() if value is not None}


def _rate(said: Mapping[str, str]) -> float | None:
    """Frames per second; None where it is not said, or not every frame was stored."""
    try:
        rate, step = float(said.get("Record Rate(fps)", "nan")), float(said.get("Save Step", "1"))
    except ValueError:
        return None
    return rate if step == 1 and math.isfinite(rate) and rate > 0 else None


def _date(said: Mapping[str, str]) -> str | None:
    return " ".join(said[name] for name in ("Date", "Time") if said.get(name)) or None
