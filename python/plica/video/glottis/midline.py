"""The line in which the folds meet: its ends, the sides of the frame that it divides, mirror images in it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from plica.video.errors import VideoError

__all__ = ["Midline", "find_midline"]

Floats = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

_STEEPEST = 45.0  # degrees from the vertical, beyond which left and right are not those of the image
# Standard deviations of a slit's centre: of edges rounded to pixels, px; as shares of its width, how far one
# fold is ahead of the other all along a frame, and how that differs from slit to slit. Chosen on recordings
# whose line is known (docs/verification/video.md).
_ROUNDED, _AHEAD, _UNLIKE = 0.3, 0.05, 0.1


@dataclass(frozen=True)
class Midline:
    """The glottal midline, px: from its upper to its lower end in the image.

    Left and right of it are those of the image. Which end is the anterior one, and which side the patient's
    left, is for whoever knows to say.

    Raises
    ------
    VideoError
        Where the ends are one, or the line runs more than 45 degrees from the vertical.
    """

    upper: tuple[float, float]
    lower: tuple[float, float]

    def __post_init__(self) -> None:
        if not np.isfinite([self.upper, self.lower]).all() or self.length == 0:
            raise VideoError(f"Midline: ends = {self.upper}, {self.lower} px; must be two points.")
        along = self.along
        lean = float(np.degrees(np.arctan2(along[0], along[1])))  # anticlockwise as seen
        if abs(lean) > _STEEPEST:
            raise VideoError(
                f"Midline: it runs {abs(lean):.0f} degrees from the vertical; must be within {_STEEPEST:g}, "
                "with its upper end first, so that left and right are those of the image. Turn the frames "
                f"by {-lean:.0f} degrees more (--rotation); where what was found is no glottis, draw a mask "
                "(plica masks)."
            )

    @classmethod
    def between(cls, ends: Sequence[float]) -> Midline:
        """The line with these ends, x, y, x, y in px, whichever is the upper one."""
        x, y, other_x, other_y = map(float, ends)
        upper, lower = sorted(((x, y), (other_x, other_y)), key=lambda end: end[1])
        return cls(upper, lower)

    @property
    def length(self) -> float:
        """px."""
        return float(np.hypot(*np.subtract(self.lower, self.upper)))

    @property
    def along(self) -> Floats:
        """(2) unit vector from the upper to the lower end."""
        return np.asarray(np.subtract(self.lower, self.upper) / self.length)

    @property
    def across(self) -> Floats:
        """(2) unit vector to the image's right."""
        return np.array([self.along[1], -self.along[0]])

    def place(self, points: Floats) -> Floats:
        """(..., 2) of points (..., 2), px: how far along the line from its upper end, and right of it."""
        return np.asarray((points - np.array(self.upper)) @ np.stack([self.along, self.across], axis=1))

    def points(self, place: Floats) -> Floats:
        """(..., 2) px: the points that lie there; the inverse of :meth:`place`."""
        return np.asarray(np.array(self.upper) + place @ np.stack([self.along, self.across]))


def pixels(shape: tuple[int, ...]) -> Floats:
    """(h, w, 2) px, x and y of every pixel."""
    y, x = np.mgrid[0 : shape[0], 0 : shape[1]].astype(float)
    return np.stack([x, y], axis=-1)


def find_midline(glottis: Iterable[Mask]) -> Midline:
    """The line in which the folds meet.

    Across the principal axis of all masks together, a slit of width w at the place s has its centre at
    o + k s + a w + e: off the line o + k s by the share a of its width, since one fold is farther from it
    than the other, and by an error e. The share is the frame's own, about alike in all of its slits; e is
    of what pixels round and of what differs from slit to slit. Least squares over all slits, with the a of
    each frame solved for too: so neither the fold that swings further draws the line to it, nor do slits of
    one pixel, which can only stand in one column or in the next, decide alone. Keeps a bit a pixel.

    Raises
    ------
    VideoError
        Where no mask has a glottis, or all together no direction, or one across the image.
    """
    kept: list[tuple[tuple[int, ...], npt.NDArray[np.uint8]]] = []
    moments = np.zeros(6)  # sums of 1, x, y, xx, xy, yy over all pixels
    for mask in glottis:
        y, x = np.nonzero(mask)
        if x.size:
            moments += [x.size, x.sum(), y.sum(), x @ x, x @ y, y @ y]
            kept.append((mask.shape, np.packbits(mask)))
    if not kept:
        raise VideoError("Midline: no frame has a glottis; must have one. Set the midline's two ends.")
    centre, along = _axis(moments)
    across = np.array([along[1], -along[0]])
    matrix, right, ends = np.zeros((2, 2)), np.zeros(2), np.array([np.inf, -np.inf])
    for shape, bits in kept:
        inside = np.unpackbits(bits, count=shape[0] * shape[1]).reshape(shape)
        points = np.argwhere(inside)[:, ::-1] - centre
        slits = _slits(points @ along, points @ across)
        matrix, right = matrix + (terms := _terms(*slits))[0], right + terms[1]
        ends = np.array([min(ends[0], slits[0].min()), max(ends[1], slits[0].max())])
    offset, slope = np.linalg.lstsq(matrix, right, rcond=None)[0]
    upper, lower = (centre + end * along + (offset + slope * end) * across for end in ends)
    return Midline((float(upper[0]), float(upper[1])), (float(lower[0]), float(lower[1])))


def _axis(moments: Floats) -> tuple[Floats, Floats]:
    """(2) centre and (2) principal axis, downwards, of pixels with these sums of 1, x, y, xx, xy, yy."""
    centre = moments[1:3] / moments[0]
    second = moments[[3, 4, 4, 5]].reshape(2, 2) / moments[0] - np.outer(centre, centre)
    spreads, axes = np.linalg.eigh(second)
    if not spreads[1] > 2.0 * spreads[0]:
        raise VideoError(
            f"Midline: the glottis is {np.sqrt(spreads[1] / max(spreads[0], 1e-12)):.2g} times as long as "
            "wide; must be clearly longer. Does it open? Set the midline's two ends, or draw a mask."
        )
    return centre, axes[:, 1] if axes[1, 1] >= 0 else -axes[:, 1]


def _slits(along: Floats, across: Floats) -> tuple[Floats, Floats, Floats]:
    """Place along the axis, centre across it and width of each slit of one mask, px."""
    first = along.min()
    rows = np.floor(along - first + 0.5).astype(int)
    count = np.bincount(rows)
    there = np.flatnonzero(count)
    total = np.bincount(rows, weights=across)
    return there + first, total[there] / count[there], count[there].astype(float)


def _terms(place: Floats, centre: Floats, width: Floats) -> tuple[Floats, Floats]:
    """A frame's part of the normal equations (2, 2), (2) for offset and slope, its own share a eliminated."""
    weight = 1 / (_ROUNDED**2 + (_UNLIKE * width) ** 2)
    lines = np.stack([np.ones_like(place), place])
    matrix, right = (lines * weight) @ lines.T, (lines * weight) @ centre
    coupled = (lines * weight) @ width
    own = weight @ width**2 + 1 / _AHEAD**2
    return matrix - np.outer(coupled, coupled) / own, right - coupled * (weight @ (width * centre)) / own
