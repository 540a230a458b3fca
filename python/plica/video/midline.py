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

    Across the principal axis of all masks together, the centre of a slit is off the line by half its width at
    most: the line is fitted to the slits of every mask, weighted by the inverse square of their width, so
    that commissures and closing folds decide and not the larger swing of one fold. Keeps a bit a pixel.

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
    centre = moments[1:3] / moments[0]
    second = moments[[3, 4, 4, 5]].reshape(2, 2) / moments[0] - np.outer(centre, centre)
    spreads, axes = np.linalg.eigh(second)
    if not spreads[1] > 2.0 * spreads[0]:
        raise VideoError(
            f"Midline: the glottis is {np.sqrt(spreads[1] / max(spreads[0], 1e-12)):.2g} times as long as "
            "wide; must be clearly longer. Does it open? Set the midline's two ends, or draw a mask."
        )
    along = axes[:, 1] if axes[1, 1] >= 0 else -axes[:, 1]
    across = np.array([along[1], -along[0]])
    slits = []  # place along the axis, centre across it, width
    for shape, bits in kept:
        inside = np.unpackbits(bits, count=shape[0] * shape[1]).reshape(shape)
        points = np.argwhere(inside)[:, ::-1] - centre
        rows = np.round(points @ along).astype(int)
        count = np.bincount(rows - rows.min())
        total = np.bincount(rows - rows.min(), weights=points @ across)
        there = count > 0
        slits.append(
            np.stack([np.flatnonzero(there) + rows.min(), total[there] / count[there], count[there]])
        )
    place, middle, width = np.concatenate(slits, axis=1)
    slope, offset = np.polyfit(place, middle, 1, w=1 / width)
    ends = [centre + end * along + (offset + slope * end) * across for end in (place.min(), place.max())]
    return Midline(*((float(end[0]), float(end[1])) for end in ends))
