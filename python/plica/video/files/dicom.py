"""Recordings in DICOM files: several frames, each read where it is asked for, or a video.

Levels are as they are stored: no rescale, window, look-up table or overlay is applied, which are for showing
them; only MONOCHROME1, in which 0 is white, is turned.
"""

from __future__ import annotations

import io
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
import numpy.typing as npt

from plica.video.errors import VideoError
from plica.video.files.camera_metadata import Camera
from plica.video.files.dicom_file import dicom_errors
from plica.video.files.dicom_header import Header, read_header
from plica.video.files.dicom_items import Item, Joined, frames_of, items_of
from plica.video.files.image_file import whole_pictures
from plica.video.files.limits import check
from plica.video.files.video_file import Video

__all__ = ["Dicom", "open_dicom"]


def open_dicom(path: Path) -> Dicom | Video:
    """The frames of a DICOM file.

    Raises
    ------
    VideoError
        Without pydicom; for a file that is not of DICOM, has no frames, states what its pixel data do not
        hold, is cut off, or is compressed by a method that cannot be decoded.
    """
    header = read_header(path)
    from pydicom.uid import MPEGTransferSyntaxes  # once it is said where it is missing

    return _video(path, header) if header.syntax in MPEGTransferSyntaxes else Dicom(path, header)


def _video(path: Path, header: Header) -> Video:
    """The video inside, which FFmpeg reads as one in a file of its own."""
    from pydicom.uid import MPEG4HP42STEREO, MPEG4HP42STEREOF

    if header.syntax in (MPEG4HP42STEREO, MPEG4HP42STEREOF):
        raise VideoError(f"Recording: {path.name} is a stereo video; must have one view. Export one of them.")
    if header.length is not None:
        raise VideoError(
            f"Recording: {path.name} has a video that is not in items; must be. Export it again."
        )
    with open(path, "rb") as file:
        pieces = items_of(file, header)[1:]
    found = Video(path, partial(_joined, path, pieces))
    if (found.count, found.shape) != (header.count, header.shape):
        stated, there = (
            f"{count} frames of {width} x {height} px"
            for count, (height, width) in ((header.count, header.shape), (found.count, found.shape))
        )
        raise VideoError(
            f"Recording: {path.name} states {stated}, and its video has {there}; must be the same. Is it cut "
            "off? Copy or export it again."
        )
    found.camera = header.camera
    return found


def _joined(path: Path, pieces: list[Item]) -> BinaryIO:
    return io.BufferedReader(Joined(path, pieces))


class Dicom:
    """A DICOM file with several frames, uncompressed, or compressed one by one.

    Raises
    ------
    VideoError
        As :func:`open_dicom`.
    """

    def __init__(self, path: Path, header: Header) -> None:
        self.name, self._path, self._header = path.name, path, header
        self.count, self.shape = header.count, header.shape
        self.camera: Camera | None = header.camera
        check(self.name, self.count, self.shape)
        self._frame = self._compressed() if header.length is None else self._native(header.length)

    def pixels(self, begin: int, end: int) -> Iterator[tuple[str, npt.NDArray[Any]]]:
        with open(self._path, "rb") as file:
            for index in range(begin, min(end, self.count)):
                what = f"{self.name}: frame {index} cannot be decoded"
                hint = f"The {index} frames before it are whole (--to). Copy or export the file again."
                with dicom_errors(what, hint):
                    pixels = self._levels(index, self._frame(file, index))
                yield f"{self.name}: frame {index}", pixels

    def _native(self, length: int) -> Callable[[BinaryIO, int], npt.NDArray[Any]]:
        """What reads an uncompressed frame, once all of them are known to be there."""
        header = self._header
        if header.encapsulated:
            raise VideoError(
                f"Recording: {self.name} has compressed pixel data that are not in items; "
                "must be. Export it again."
            )
        if header.kind not in ("MONOCHROME1", "MONOCHROME2", "RGB", "YBR_FULL", "YBR_FULL_422"):
            raise VideoError(
                f"Recording: {self.name} has {header.kind} without compression; must be RGB, YBR_FULL or "
                "YBR_FULL_422. Export it as RGB."
            )
        samples = 2 if header.kind == "YBR_FULL_422" else header.samples
        size = self.shape[0] * self.shape[1] * samples * header.allocated // 8
        needed = self.count * size
        states = (
            f"as it states {self.count} frames of {self.shape[1]} x {self.shape[0]} px of "
            f"{samples * header.allocated} bits"
        )
        if length not in (needed, needed + needed % 2):
            raise VideoError(
                f"Recording: {self.name} has pixel data of {length} bytes; must have {needed}, {states}. "
                "Copy or export it again."
            )
        there = self._path.stat().st_size - header.place
        if there < needed:
            raise VideoError(
                f"Recording: {self.name} has {there} bytes of pixel data; must have {needed}, {states}. "
                "It is cut off: copy it again."
            )
        if header.swapped and size % 2:
            raise VideoError(
                f"Recording: {self.name} has frames of {size} bytes in words of a big-endian file; must be "
                "even. Export it as Explicit VR Little Endian."
            )
        return partial(self._of_bytes, size)

    def _of_bytes(self, size: int, file: BinaryIO, index: int) -> npt.NDArray[Any]:
        header = self._header
        file.seek(header.place + index * size)
        numbers = np.frombuffer(
            file.read(size), "u1" if header.allocated == 8 else "<u2" if header.little else ">u2"
        )
        if header.swapped:
            numbers = numbers.reshape(-1, 2)[:, ::-1].reshape(-1)
        if header.samples == 1:
            return numbers.reshape(self.shape)
        if header.kind == "YBR_FULL_422":
            from pydicom.pixels.utils import expand_ybr422

            widened = np.frombuffer(expand_ybr422(numbers.tobytes(), header.allocated), numbers.dtype)
            return _rgb(widened.reshape(*self.shape, 3))
        if header.planar:
            colours = np.moveaxis(numbers.reshape(3, *self.shape), 0, 2)
        else:
            colours = numbers.reshape(*self.shape, 3)
        return _rgb(colours) if header.kind == "YBR_FULL" else colours

    def _compressed(self) -> Callable[[BinaryIO, int], npt.NDArray[Any]]:
        """What reads a compressed frame, once all of them are known to be there."""
        from pydicom.pixels.decoders.base import get_decoder

        header, syntax = self._header, self._header.syntax
        try:
            decoder = get_decoder(syntax) if header.encapsulated else None
        except (NotImplementedError, ValueError):
            decoder = None
        if decoder is None or not decoder.is_available:
            raise VideoError(
                f"Recording: {self.name} is compressed as {syntax.name}, for which there is no decoder; must "
                "be uncompressed, RLE, JPEG Baseline, JPEG 2000 or a video. Export it so (dcmdjpeg, "
                "gdcmconv --raw) or install pylibjpeg[all]."
            )
        with open(self._path, "rb") as file:
            frames = frames_of(file, header)
        return partial(self._of_items, decoder, frames)

    def _of_items(
        self, decoder: Any, frames: list[list[Item]], file: BinaryIO, index: int
    ) -> npt.NDArray[Any]:
        from pydicom.encaps import encapsulate

        parts = []
        for item in frames[index]:
            file.seek(item.place)
            parts.append(file.read(item.length))
        header = self._header
        with whole_pictures():
            found, _ = decoder.as_array(
                encapsulate([b"".join(parts)]),
                raw=False,
                rows=self.shape[0],
                columns=self.shape[1],
                number_of_frames=1,
                samples_per_pixel=header.samples,
                photometric_interpretation=header.kind,
                bits_allocated=header.allocated,
                bits_stored=header.stored,
                pixel_representation=0,
                planar_configuration=int(header.planar),
                pixel_keyword="PixelData",
                correct_unused_bits=False,
            )
        return np.asarray(found)

    def _levels(self, index: int, raw: npt.NDArray[Any]) -> npt.NDArray[Any]:
        """0 to 2^BitsStored - 1, of which 0 is black."""
        header = self._header
        most, shift = (1 << header.stored) - 1, header.high + 1 - header.stored
        beyond = raw & ~raw.dtype.type(most << shift) if header.stored < 8 * raw.dtype.itemsize else raw[:0]
        if beyond.any() and not header.overlaid:
            raise VideoError(
                f"Recording: {self.name}: frame {index} has bits beyond the {header.stored} that BitsStored "
                f"and HighBit = {header.high} name, in a pixel of {int(raw[beyond != 0].flat[0])}; must have "
                "none. Is BitsStored right? Export it again."
            )
        levels = raw if not (shift or header.overlaid) else (raw >> shift) & raw.dtype.type(most)
        turned = header.kind == "MONOCHROME1"
        return (
            np.asarray(raw.dtype.type(most) - levels)
            if turned
            else levels.astype(raw.dtype.newbyteorder("="))
        )


def _rgb(found: npt.NDArray[Any]) -> npt.NDArray[Any]:
    from pydicom.pixels.processing import convert_color_space

    return np.asarray(convert_color_space(np.ascontiguousarray(found), "YBR_FULL", "RGB"))
