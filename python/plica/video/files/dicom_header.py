"""What a DICOM file says of its frames, by the standard's Image Pixel and Multi-frame modules."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

from plica.video.files.camera_metadata import Camera
from plica.video.files.dicom_camera import SPACINGS, camera_of
from plica.video.files.dicom_file import Attributes, dicom_errors, opened_dataset

if TYPE_CHECKING:
    from pydicom.uid import UID

__all__ = ["Header", "read_header"]

_DIRECTORY = "1.2.840.10008.1.3.10"
_DEFLATED = ("1.2.840.10008.1.2.1.99", "1.2.840.10008.1.2.8.1")
_PIXELS, _FLOATS = 0x7FE00010, (0x7FE00008, 0x7FE00009)
_UNKNOWN_LENGTH = 0xFFFFFFFF
_SQUARE = 0.01  # relative
_KINDS = {
    1: ("MONOCHROME1", "MONOCHROME2"),
    3: ("RGB", "YBR_FULL", "YBR_FULL_422", "YBR_ICT", "YBR_RCT", "YBR_PARTIAL_420"),
}
"""PhotometricInterpretation, by SamplesPerPixel."""


@dataclass(frozen=True)
class Header:
    """Frames of a DICOM file.

    Attributes
    ----------
    name : str
        Of the file.
    syntax : UID
        The transfer syntax.
    encapsulated, little : bool
        Whether it has the pixel data in items, and numbers in little-endian order.
    count : int
        NumberOfFrames.
    shape : tuple of int
        Rows, Columns.
    samples : int
        Of a pixel: 1, or 3 colours.
    kind : str
        PhotometricInterpretation.
    allocated, stored, high : int
        BitsAllocated, BitsStored, HighBit.
    planar : bool
        Whether a frame has one colour after the other.
    overlaid : bool
        Whether bits of the pixels that are not stored ones are an overlay.
    swapped : bool
        Whether bytes of 8 bits are swapped in pairs (words of a big-endian file).
    place, length : int, int or None
        Byte of the file where the value of the pixel data begins; its bytes, None in items of their own.
    offsets : bytes
        Extended offset table, empty without one.
    camera : Camera
    """

    name: str
    syntax: UID
    encapsulated: bool
    little: bool
    count: int
    shape: tuple[int, int]
    samples: int
    kind: str
    allocated: int
    stored: int
    high: int
    planar: bool
    overlaid: bool
    swapped: bool
    place: int
    length: int | None
    offsets: bytes
    camera: Camera


def read_header(path: Path) -> Header:
    """What a DICOM file says of its frames.

    Raises
    ------
    VideoError
        As :func:`read_dataset`; for an object without pixel data or with pixels that are not unsigned levels
        of up to 16 bits; for frames that are not equally spaced in time.
    """
    with dicom_errors(f"{path.name} cannot be read as DICOM"), open(path, "rb") as file:
        found = opened_dataset(path, file)
        said = Attributes(path.name, found)
        place, length, words = _pixel_data(file, said, found)
        return _header(said, place, length, words)


def _pixel_data(file: BinaryIO, said: Attributes, found: Any) -> tuple[int, int | None, bool]:
    """Place and length of the pixel data, the file being before them, and whether they are of words."""
    if str(found.file_meta.get("MediaStorageSOPClassUID", "")) == _DIRECTORY:
        raise said.wrong("is a DICOMDIR, a list of files", "a recording: give one of the files that it lists")
    syntax = found.file_meta.TransferSyntaxUID
    if str(syntax) in _DEFLATED:
        raise said.wrong(
            f"has the transfer syntax {syntax.name}",
            "uncompressed as a file. Export it as Explicit VR Little Endian",
        )
    implicit, little = found.original_encoding  # as it is, where that is not as the syntax says
    order = "<" if little else ">"
    head = file.read(8)
    if len(head) == 8:
        group, element = struct.unpack(f"{order}HH", head[:4])
        tag = (group << 16) + element
        if tag in _FLOATS:
            raise said.wrong("has pixels that are floating-point numbers", "whole numbers of 8 or 16 bits")
        if tag == _PIXELS:
            if implicit:
                words, length = True, struct.unpack(f"{order}I", head[4:])[0]
            else:
                words, length = head[4:6] == b"OW", struct.unpack(f"{order}I", file.read(4))[0]
            return file.tell(), None if length == _UNKNOWN_LENGTH else length, words
    kind = getattr(found.get("SOPClassUID", ""), "name", "") or "unknown object"
    raise said.wrong(
        f"has no pixel data ({kind})",
        "a picture with several frames, or a video (is it the right file, and whole?)",
    )


def _header(said: Attributes, place: int, length: int | None, words: bool) -> Header:
    syntax = said.found.file_meta.TransferSyntaxUID
    samples, kind = said.whole("SamplesPerPixel"), said.text("PhotometricInterpretation")
    allocated, stored = said.whole("BitsAllocated"), said.whole("BitsStored")
    header = Header(
        name=said.name,
        syntax=syntax,
        encapsulated=syntax.is_encapsulated,
        little=syntax.is_little_endian,
        count=said.whole("NumberOfFrames", 1),
        shape=(said.whole("Rows"), said.whole("Columns")),
        samples=samples,
        kind=kind,
        allocated=allocated,
        stored=stored,
        high=said.whole("HighBit"),
        planar=samples == 3 and said.whole("PlanarConfiguration") == 1,
        overlaid=_overlaid(said.found),
        swapped=words and allocated == 8 and not syntax.is_little_endian,
        place=place,
        length=length,
        offsets=bytes(said.found.get("ExtendedOffsetTable") or b""),
        camera=camera_of(said, stored),
    )
    _check_pixels(said, header)
    return header


def _overlaid(found: Any) -> bool:
    """Whether an overlay lies in bits of the pixels, as it might until 2004."""
    groups = range(0x6000, 0x6020, 2)
    return any(int(found[group, 0x0102].value or 0) > 0 for group in groups if (group, 0x0102) in found)


def _check_pixels(said: Attributes, header: Header) -> None:
    """Levels must be unsigned, linear in brightness, and all bits accounted for."""
    if header.allocated not in (8, 16):
        raise said.wrong(f"has BitsAllocated = {header.allocated}", "8 or 16. Export it so")
    if not 1 <= header.stored <= header.allocated:
        raise said.wrong(f"has BitsStored = {header.stored}", f"in [1, {header.allocated}], of BitsAllocated")
    if not header.stored - 1 <= header.high < header.allocated:
        raise said.wrong(
            f"has HighBit = {header.high} with BitsStored = {header.stored}",
            f"in [{header.stored - 1}, {header.allocated - 1}], as BitsAllocated = {header.allocated}",
        )
    if said.whole("PixelRepresentation") != 0:
        raise said.wrong(
            f"has signed pixels of {header.stored} bits (PixelRepresentation = 1)",
            "unsigned, as brightness has no sign and where its zero lies is not said. Export it unsigned",
        )
    if header.samples not in _KINDS:
        raise said.wrong(f"has SamplesPerPixel = {header.samples}", "1 (grey) or 3 (colour)")
    if header.kind not in _KINDS[header.samples]:
        raise said.wrong(
            f"has PhotometricInterpretation = {header.kind or 'none'} of {header.samples} samples",
            f"one of {', '.join(_KINDS[header.samples])}. Export it as grey or RGB",
        )
    if header.samples == 3 and said.whole("PlanarConfiguration") not in (0, 1):
        raise said.wrong(f"has PlanarConfiguration = {said.whole('PlanarConfiguration')}", "0 or 1")
    if header.kind.startswith("YBR") and header.stored != 8:
        raise said.wrong(f"has {header.kind} of {header.stored} bits", "of 8 bits. Export it as RGB")
    _check_shades(said, header)
    _check_square(said)


def _check_shades(said: Attributes, header: Header) -> None:
    """What turns dark into bright: MONOCHROME1 says it for the levels; anything else would contradict."""
    slope = said.number("RescaleSlope")
    if slope is not None and slope <= 0:
        raise said.wrong(
            f"has RescaleSlope = {slope:g}", "above 0: else dark and bright change places. Export it again"
        )
    shape = said.text("PresentationLUTShape")
    if shape == "INVERSE" and header.kind == "MONOCHROME2":
        raise said.wrong(
            "has PresentationLUTShape = INVERSE with MONOCHROME2",
            "IDENTITY, as it is not said which of the two tells dark from bright. Export it again",
        )


def _check_square(said: Attributes) -> None:
    """One size of a pixel holds across and along the folds."""
    for keyword in ("PixelAspectRatio", *SPACINGS):
        found = said.numbers(keyword)
        if len(found) != 2 or not min(found) > 0:
            continue
        if abs(found[0] / found[1] - 1) > _SQUARE:
            raise said.wrong(
                f"has pixels of {found[0]:g} down to {found[1]:g} across ({keyword})",
                "square, to 1 %: lengths across and along the folds would have another scale. Export it "
                "with square pixels",
            )
