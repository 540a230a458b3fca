"""A high-speed recording: its frames as grey images, read when they are asked for."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Protocol

import numpy as np
import numpy.typing as npt

from plica.video.errors import VideoError
from plica.video.files.camera_metadata import Camera
from plica.video.files.sources import FrameSource, Part, open_source, read

__all__ = ["Frames", "Grey", "Picture", "Recording", "Region", "spread"]

Grey = npt.NDArray[np.float32]  # (height, width), 0 dark
Picture = npt.NDArray[np.float32]  # (height, width, 3), likewise

_DARK, _BRIGHT = 0.5, 99.5  # percentiles of all pixels of the recording
_BINS = 4096


class Frames(Protocol):
    """What has frames of one size: a recording, or one that was worked on."""

    @property
    def count(self) -> int: ...

    @property
    def shape(self) -> tuple[int, int]: ...

    def frames(self) -> Iterator[Grey]: ...

    def frame(self, index: int, /) -> Grey: ...


@dataclass(frozen=True)
class Region:
    """A rectangle of pixels: columns x to x + width, rows y to y + height, from the top left."""

    x: int
    y: int
    width: int
    height: int


@dataclass(frozen=True)
class Recording:
    """A recording that was opened with :meth:`open`.

    Attributes
    ----------
    source : FrameSource
        Where frames come from.
    scale : (low, high)
        Grey values that become 0 and 255, the same for the whole recording, so that its brightness does not
        flicker.
    rotation : float
        Degrees, anticlockwise as seen, by which frames are turned about their centre before the region is
        cut.
    region : Region or None
        Part of the turned frames that is used; None: all.
    """

    source: FrameSource
    scale: tuple[float, float]
    rotation: float = 0.0
    region: Region | None = None

    @classmethod
    def open(
        cls,
        path: str | Path,
        *,
        rotation: float = 0.0,
        region: Region | None = None,
        dataset: str | None = None,
        scale: tuple[float, float] | None = None,
        first: int | None = None,
        last: int | None = None,
    ) -> Recording:
        """Open AVI, MP4, MOV, MKV; a TIFF stack; a folder of images; HDF5, NPY; DICOM; a camera's own
        .cine or .mraw with .cih or .cihx. Reads every frame.

        What a container says of the frame rate is nearly always the speed of playing it: it is not taken.
        That of a camera's own file is (`camera`), and one of DICOM from 200 frames/s on.

        Parameters
        ----------
        path : str or Path
        rotation : float
            Degrees, anticlockwise as seen.
        region : Region, optional
        dataset : str, optional
            Name of the frames' dataset in an HDF5 file that holds several.
        scale : (low, high), optional
            Grey values that become 0 and 255. The default is percentiles 0.5 and 99.5 of all pixels, which no
            highlight sets.
        first, last : int, optional
            The part of it that is used, both included; its frames are counted from 0 again.

        Raises
        ------
        VideoError
            Naming the frame, where one cannot be used; for fewer than two frames; for settings outside their
            range.
        """
        if not math.isfinite(rotation):
            raise VideoError(f"Recording: rotation = {rotation:g} degrees; must be finite.")
        if scale is not None and not (np.isfinite(scale).all() and scale[0] < scale[1]):
            raise VideoError(
                f"Recording: scale = ({scale[0]:g}, {scale[1]:g}); must be two finite numbers, the lower one "
                "first."
            )
        source = Part.of(open_source(Path(path), dataset), first, last)
        _check_region(source, region)
        return cls(source, scale or _scale(source), rotation, region)

    @property
    def count(self) -> int:
        """Frames."""
        return self.source.count

    @property
    def camera(self) -> Camera | None:
        """What the file of a high-speed camera says of it; None: of another kind of file."""
        return self.source.camera

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width of the frames as used, px."""
        if self.region is None:
            return self.source.shape
        return self.region.height, self.region.width

    def frames(self, begin: int = 0, end: int | None = None) -> Iterator[Grey]:
        """Frames begin to end (excluded), float32, 0 to 255 on the recording's scale, one at a time.

        What is darker or brighter than the scale goes on beyond 0 and 255.
        """
        for raw in read(self.source, begin, self.count if end is None else end):
            yield self._used(raw)

    def frame(self, index: int) -> Grey:
        """One frame, as of :meth:`frames`; negative counts from the end."""
        index = index + self.count if index < 0 else index
        if not 0 <= index < self.count:
            raise VideoError(f"Recording: frame {index}; must be in [0, {self.count}).")
        return next(self.frames(index, index + 1))

    @cached_property
    def coloured(self) -> bool:
        """Whether its frames have colours, by the first."""
        _, first = next(iter(self.source.pixels(0, 1)))
        return first.ndim == 3 and first.shape[2] >= 3 and bool(np.ptp(first[..., :3], axis=2).any())

    def pictures(self, wanted: Collection[int]) -> Iterator[tuple[int, Picture]]:
        """Of these frames each with its number, in order, in their colours: to be looked at, not measured.

        A grey frame has three that are equal, as of `frames`. Coloured ones are as bright as leaves their
        strongest colour its differences: on the scale of grey alone, red tissue would be bleached.
        """
        last = max(wanted, default=-1) + 1
        for index, (_, raw) in enumerate(self.source.pixels(0, last)):
            if index in wanted:
                deep = raw[..., None] if raw.ndim == 2 else raw[..., :3]
                colours = np.broadcast_to(deep, (*deep.shape[:2], 3))
                yield index, self._used(colours.astype(np.float32), self._bleached)

    @cached_property
    def _bleached(self) -> float:
        """Level that becomes 255 in pictures."""
        if not self.coloured:
            return self.scale[1]
        _, first = next(iter(self.source.pixels(0, 1)))
        return max(self.scale[1], float(np.percentile(first[..., :3].max(axis=2), _BRIGHT)))

    def _used(self, raw: Grey, white: float | None = None) -> Grey:
        low, high = self.scale[0], self.scale[1] if white is None else white
        image = (raw - np.float32(low)) * np.float32(255.0 / (high - low))
        if self.rotation:
            from scipy import ndimage

            image = ndimage.rotate(image, self.rotation, reshape=False, order=3, mode="mirror")
        if self.region is not None:
            r = self.region
            image = image[r.y : r.y + r.height, r.x : r.x + r.width]
        return np.ascontiguousarray(image, dtype=np.float32)


def spread(frames: Iterable[Grey]) -> npt.NDArray[np.float64]:
    """(h, w) standard deviation of each pixel over the frames, of which there is one at least."""
    total: npt.NDArray[np.float64] | float = 0.0
    square: npt.NDArray[np.float64] | float = 0.0
    count = 0
    for frame in frames:
        total = total + frame.astype(float)
        square = square + np.square(frame, dtype=float)
        count += 1
    return np.asarray(np.sqrt(np.maximum(square / count - np.square(total / count), 0.0)))


def _check_region(source: FrameSource, region: Region | None) -> None:
    if region is None:
        return
    height, width = source.shape
    inside = (
        0 <= region.x < region.x + region.width <= width
        and 0 <= region.y < region.y + region.height <= height
    )
    given = f"Recording: region = {region.x}, {region.y}, {region.width}, {region.height} px"
    if not inside:
        raise VideoError(
            f"{given}; must lie within the frames of {width} x {height} px, as they are turned, and be wider "
            "and higher than 0. They are x and y of its upper left corner, its width and its height."
        )
    if min(region.width, region.height) < 16:
        raise VideoError(
            f"{given}, is {region.width} x {region.height} px; must be at least 16 x 16 px. Leave "
            "some tissue about the glottis."
        )


def _scale(source: FrameSource) -> tuple[float, float]:
    """Percentiles of all pixels, from a histogram between the least and the largest value."""
    least, largest = math.inf, -math.inf
    for frame in read(source, 0, source.count):
        least, largest = min(least, float(frame.min())), max(largest, float(frame.max()))
    ends = (least, largest)
    if not ends[1] > ends[0]:
        raise VideoError(
            f"Recording: {source.name}: every pixel is {ends[0]:g}; must be an image with light and dark. "
            "Is it the right file, or the right data set in it?"
        )
    counts = np.zeros(_BINS, dtype=np.int64)
    for frame in read(source, 0, source.count):
        counts += np.histogram(frame, bins=_BINS, range=ends)[0]
    edges = np.linspace(*ends, _BINS + 1)
    below = np.concatenate([[0.0], np.cumsum(counts) / counts.sum()])
    low, high = np.interp([_DARK / 100, _BRIGHT / 100], below, edges)
    if not high - low > 1e-3 * (ends[1] - ends[0]):
        raise VideoError(
            f"Recording: {source.name}: 99 % of all pixels lie between {low:g} and {high:g}; must be an "
            "image with contrast. Is it saturated, or empty?"
        )
    return float(low), float(high)
