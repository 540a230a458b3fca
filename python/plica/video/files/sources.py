"""Where frames come from: files of video, TIFF, DICOM and cameras, folders of images, HDF5 and NPY arrays."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from plica.errors import InvalidInput
from plica.storage.files import require_file
from plica.storage.hdf5 import CHECKSUMS
from plica.storage.npz import NPY_ERRORS
from plica.storage.stored import Stored
from plica.video.errors import VideoError
from plica.video.files.camera_metadata import Camera
from plica.video.files.dicom import open_dicom
from plica.video.files.dicom_file import dicom_errors, is_dicom
from plica.video.files.grey import depth, to_grey
from plica.video.files.image_file import PICTURES, is_picture, read_page, read_pixels
from plica.video.files.limits import check
from plica.video.files.phantom import Phantom
from plica.video.files.photron import Photron
from plica.video.files.tiff_file import count_pages, open_tiff
from plica.video.files.video_file import Video

__all__ = ["FrameSource", "Part", "open_source", "read"]

_VIDEO = {".avi", ".mp4", ".mov", ".mkv", ".m4v", ".mpg", ".mpeg", ".wmv", ".webm"}
_TIFF = {".tif", ".tiff"}
_HDF5 = {".h5", ".hdf5", ".mat"}
_PHOTRON = {".mraw", ".cih", ".cihx"}
_AGAIN = "Copy it again from where it is whole"


class FrameSource(Protocol):
    """Frames of one size, as the file has them.

    Attributes
    ----------
    name : str
        For messages.
    count : int
        Frames, >= 2.
    shape : tuple of int
        Height and width, px.
    camera : Camera or None
        What the file of a high-speed camera, or of DICOM, says of it.
    """

    @property
    def name(self) -> str: ...

    @property
    def count(self) -> int: ...

    @property
    def shape(self) -> tuple[int, int]: ...

    @property
    def camera(self) -> Camera | None: ...

    def pixels(self, begin: int, end: int) -> Iterator[tuple[str, npt.NDArray[Any]]]:
        """Frames begin to end (excluded), one at a time, each with its name: (h, w), or that x colours.

        VideoError names one that cannot be used.
        """


def open_source(path: Path, dataset: str | None = None) -> FrameSource:
    """The source for what this path holds. Raises VideoError."""
    if not path.exists():
        raise VideoError(f"Recording: {path} does not exist.")
    suffix = path.suffix.lower()
    if dataset is not None and suffix not in _HDF5:
        raise VideoError(
            f'Recording: dataset = "{dataset}" for {path.name}; must be left out but for HDF5 '
            f"({', '.join(sorted(_HDF5))})."
        )
    if path.is_dir():
        return Images(path)
    _require_file(path)
    if path.stat().st_size == 0:
        raise VideoError(f"Recording: {path} is empty: 0 bytes.")
    if suffix in _VIDEO:
        return Video(path)
    if suffix in _TIFF:
        return Stack(path)
    if suffix in _HDF5:
        return Dataset(path, dataset)
    if suffix == ".cine":
        return _checked(Phantom(path))
    if suffix in _PHOTRON:
        return _checked(Photron(path))
    if suffix == ".dcm":
        return open_dicom(path)
    if suffix == ".npy":
        return Arrays(path.name, _loaded(path))
    if suffix in PICTURES:
        raise VideoError(f"Recording: {path.name} is one image; must be two frames or more. Give its folder.")
    with dicom_errors(f"{path.name} cannot be read"):
        if is_dicom(path):  # files of an archive have numbers for names
            return open_dicom(path)
    known = ", ".join(sorted(_VIDEO | _TIFF | _HDF5 | _PHOTRON | {".npy", ".cine", ".dcm"}))
    raise VideoError(f"Recording: {path.name}; must be a folder of images or end in one of {known}.")


@dataclass(frozen=True)
class Part:
    """Consecutive frames of a source, from `first` on, `count` of them."""

    source: FrameSource
    first: int
    count: int

    @classmethod
    def of(cls, source: FrameSource, first: int | None, last: int | None) -> FrameSource:
        """From the first to the last frame (included); None: to that end of the source. VideoError where it
        has no two such frames."""
        begin, end = first or 0, source.count - 1 if last is None else last
        if not 0 <= begin < end < source.count:
            raise VideoError(
                f"Recording: frames {begin} to {end}; must be two or more, in [0, {source.count - 1}]: "
                f"{source.name} has {source.count} frames."
            )
        whole = begin == 0 and end == source.count - 1
        return source if whole else cls(source, begin, end - begin + 1)

    @property
    def name(self) -> str:
        """For messages."""
        return self.source.name

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width, px."""
        return self.source.shape

    @property
    def camera(self) -> Camera | None:
        """What the file of a high-speed camera says of it."""
        return self.source.camera

    def pixels(self, begin: int, end: int) -> Iterator[tuple[str, npt.NDArray[Any]]]:
        """As of the source."""
        return self.source.pixels(self.first + begin, self.first + end)


def read(source: FrameSource, begin: int, end: int) -> Iterator[npt.NDArray[np.float32]]:
    """Frames begin to end (excluded), one at a time, in grey (:func:`.grey.to_grey`), unrounded.

    VideoError names one that cannot be used, or that is not finite.
    """
    for name, image in source.pixels(begin, end):
        try:
            found = to_grey(image, name=name)
        except InvalidInput as error:
            raise VideoError(f"Recording: {error}") from None
        if not np.isfinite(found).all():
            y, x = np.argwhere(~np.isfinite(found))[0]
            raise VideoError(f"Recording: {name}: pixel ({x}, {y}) is {found[y, x]:g}; must be finite.")
        yield found


def check_depth(name: str, image: npt.NDArray[Any], first: str, whose: str) -> None:
    """Raises VideoError for a frame whose numbers are of another kind than those of the first."""
    if depth(image) != first:
        raise VideoError(
            f"Recording: {name} has {depth(image)}; must have {first} as {whose}, or its grey levels mean "
            "another brightness. Store all frames alike."
        )


def _checked(source: FrameSource) -> FrameSource:
    check(source.name, source.count, source.shape)
    return source


class Images:
    """A folder of images, one a frame, in the order of the numbers in their names."""

    camera: Camera | None = None

    def __init__(self, path: Path) -> None:
        self.name = path.resolve().name
        self._files = sorted(
            (file for file in path.iterdir() if is_picture(file)),
            key=lambda file: [
                int(part) if part.isdecimal() else part for part in re.split(r"(\d+)", file.name)
            ],
        )
        if not self._files:
            raise VideoError(
                f"Recording: the folder {path} has no images; must have some of "
                f"{', '.join(sorted(PICTURES))}."
            )
        self._check_numbers()
        self.count = len(self._files)
        first = _pixels(self._files[0])
        self.shape, self._depth = (first.shape[0], first.shape[1]), depth(first)
        check(self.name, self.count, self.shape)

    def _check_numbers(self) -> None:
        """Frames are as far apart in time as their numbers say."""
        numbers = [re.findall(r"\d+", file.stem) for file in self._files]
        if not all(numbers):
            return
        steps = np.diff([int(found[-1]) for found in numbers])
        if steps.size and (steps != steps[0]).any():
            where = int(np.flatnonzero(steps != np.median(steps))[0])
            one, other = self._files[where].name, self._files[where + 1].name
            raise VideoError(
                f"Recording: {self.name}: the numbers in the names go from {one} to {other}; must be equally "
                "spaced, like the frames in time. Is one missing? Else number them anew."
            )

    def pixels(self, begin: int, end: int) -> Iterator[tuple[str, npt.NDArray[Any]]]:
        for index, file in enumerate(self._files[begin:end], start=begin):
            image = _pixels(file)
            if image.shape[:2] != self.shape:
                raise VideoError(
                    f"Recording: {self.name}: frame {index} ({file.name}) is {image.shape[1]} x "
                    f"{image.shape[0]} px; must be {self.shape[1]} x {self.shape[0]} px as "
                    f"{self._files[0].name}."
                )
            check_depth(f"{self.name}: frame {index} ({file.name})", image, self._depth, self._files[0].name)
            yield f"{self.name}: frame {index} ({file.name})", image


class Stack:
    """A TIFF file with a page a frame."""

    camera: Camera | None = None

    def __init__(self, path: Path) -> None:
        self.name, self._path = path.name, path
        try:
            with open_tiff(path) as stack:
                self.count = count_pages(stack, path.name)
                first = read_page(stack, path, 0)
        except InvalidInput as error:
            named = "" if path.name in str(error) else f"{path.name}: "
            raise VideoError(f"Recording: {named}{error}") from None
        except (ValueError, OSError, IndexError) as error:
            raise VideoError(f"Recording: {self.name} cannot be read as a TIFF stack ({error}).") from None
        self.shape, self._depth = (first.shape[0], first.shape[1]), depth(first)
        check(self.name, self.count, self.shape)

    def pixels(self, begin: int, end: int) -> Iterator[tuple[str, npt.NDArray[Any]]]:
        with open_tiff(self._path) as stack:
            for index in range(begin, min(end, self.count)):
                try:
                    image = read_page(stack, self._path, index)
                except (ValueError, OSError) as error:
                    raise VideoError(
                        f"Recording: {self.name}: frame {index} cannot be decoded ({error}). The {index} "
                        "frames before it are whole."
                    ) from None
                if image.shape[:2] != self.shape:
                    raise VideoError(
                        f"Recording: {self.name}: frame {index} is {image.shape[1]} x {image.shape[0]} px; "
                        f"must be {self.shape[1]} x {self.shape[0]} px as frame 0."
                    )
                check_depth(f"{self.name}: frame {index}", image, self._depth, "frame 0")
                yield f"{self.name}: frame {index}", image


class Arrays:
    """An array (frames, height, width) or (frames, height, width, 3), in memory or mapped from a file.

    With `reversed_axes` a frame's axes are in the opposite order, as in a file that MATLAB wrote.
    """

    camera: Camera | None = None

    def __init__(self, name: str, data: Any, *, reversed_axes: bool = False) -> None:
        self.name, self._data, self._reversed = name, data, reversed_axes
        frame = tuple(data.shape[1:])[:: -1 if reversed_axes else 1]
        if len(frame) not in (2, 3) or (len(frame) == 3 and frame[2] not in (1, 3)):
            order = "(height, width, frames)" if reversed_axes else "(frames, height, width)"
            raise VideoError(
                f"Recording: {name} has shape {tuple(data.shape)[:: -1 if reversed_axes else 1]}; must be "
                f"{order}, or have 3 colours "
                + ("before the frames." if reversed_axes else "as a fourth axis.")
            )
        if data.dtype.kind not in "uif":
            raise VideoError(f"Recording: {name} holds {data.dtype}; must be numbers.")
        self.count = int(data.shape[0])
        self.shape = (int(frame[0]), int(frame[1]))
        check(name, self.count, self.shape)

    def pixels(self, begin: int, end: int) -> Iterator[tuple[str, npt.NDArray[Any]]]:
        for index in range(begin, min(end, self.count)):
            frame = np.asarray(self._data[index])
            yield f"{self.name}: frame {index}", frame.T if self._reversed else frame


class Dataset(Arrays):
    """A dataset of an HDF5 file; open only while frames are read.

    MATLAB's ``.mat`` since version 7.3 are such files, with (height, width, frames) stored backwards.
    """

    def __init__(self, path: Path, dataset: str | None) -> None:
        self._path = path
        with _hdf5_errors(path), Stored(path, hint=_AGAIN, verified=False) as file:
            self._key = _dataset(file.file, path, dataset)
            self._verified = f"{CHECKSUMS}/{self._key}" in file
            of_matlab = path.suffix.lower() == ".mat"
            super().__init__(f"{path.name}: {self._key}", file.data(self._key), reversed_axes=of_matlab)
        self._data = None

    def pixels(self, begin: int, end: int) -> Iterator[tuple[str, npt.NDArray[Any]]]:
        with _hdf5_errors(self._path), Stored(self._path, hint=_AGAIN, verified=self._verified) as file:
            data = file.rows(self._key)
            yield from Arrays(self.name, data, reversed_axes=self._reversed).pixels(begin, end)


@contextmanager
def _hdf5_errors(path: Path) -> Iterator[None]:
    """VideoError for a file that is damaged, which the HDF5 library tells in several ways."""
    try:
        yield
    except VideoError:
        raise
    except InvalidInput as error:
        hint = " A .mat file must be saved with -v7.3." if path.suffix.lower() == ".mat" else ""
        raise VideoError(f"Recording: {error}{hint}") from None
    except (OSError, RuntimeError, KeyError, ValueError, TypeError) as error:
        reason = " ".join(str(error).split())
        raise VideoError(f"Recording: {path.name} cannot be read as HDF5 ({reason}). Is it whole?") from None


def _dataset(file: Any, path: Path, wanted: str | None) -> str:
    import h5py

    found: list[str] = []

    def note(name: str, item: Any) -> None:
        if isinstance(item, h5py.Dataset) and item.ndim in (3, 4):
            found.append(name)

    file.visititems(note)
    if wanted is not None:
        if wanted.strip("/") not in found:
            raise VideoError(
                f'Recording: {path.name} has no frames "{wanted}"; must be one of '
                f"{', '.join(found) or 'none'}."
            )
        return wanted.strip("/")
    if len(found) != 1:
        raise VideoError(
            f"Recording: {path.name} has {len(found)} datasets that can be frames"
            f"{': ' + ', '.join(found) if found else ''}; must be one. Name it: --dataset NAME."
        )
    return found[0]


def _require_file(path: Path) -> None:
    try:
        require_file(path, f"Recording: {path}")
    except InvalidInput as error:
        raise VideoError(str(error)) from None


def _loaded(path: Path) -> Any:
    try:
        return np.load(path, mmap_mode="r", allow_pickle=False)
    except NPY_ERRORS as error:
        reason = " ".join(str(error).split()) if "pickle" not in str(error) else "no array of numbers"
        raise VideoError(f"Recording: {path.name} cannot be read as a NumPy array ({reason}).") from None


def _pixels(file: Path) -> npt.NDArray[Any]:
    _require_file(file)
    try:
        return read_pixels(file)
    except InvalidInput as error:
        raise VideoError(f"Recording: {error}") from None
