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
                f"by {-lean:.0f} degrees more (--rotation)."
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

    In a row of the image the centre of a slit is off the line by half its width at most: the line is fitted
    to the slits of all rows of all masks, weighted by the inverse square of their width, so that commissures
    and closing folds decide and not the larger swing of one fold.

    Raises
    ------
    VideoError
        Where no mask has a glottis, or all together no direction, or one across the image.
    """
    moments = np.zeros(6)  # sums of 1, x, y, xx, xy, yy over all pixels
    slits: list[Floats] = []  # row, centre, width
    for mask in glottis:
        rows = np.flatnonzero(mask.any(axis=1))
        if not rows.size:
            continue
        columns = np.arange(mask.shape[1])
        width = mask[rows].sum(axis=1)
        along, square = mask[rows] @ columns, mask[rows] @ columns**2
        moments += [width.sum(), along.sum(), width @ rows, square.sum(), along @ rows, width @ rows**2]
        slits.append(np.stack([rows, along / width, width]))
    if not slits:
        raise VideoError("Midline: no frame has a glottis; must have one. Set the midline's two ends.")
    count, x, y, xx, xy, yy = moments
    x, y = x / count, y / count
    cross = xy / count - x * y
    spreads, axes = np.linalg.eigh([[xx / count - x * x, cross], [cross, yy / count - y * y]])
    if not spreads[1] > 2.0 * spreads[0]:
        raise VideoError(
            f"Midline: the glottis is {np.sqrt(spreads[1] / max(spreads[0], 1e-12)):.2g} times as long as "
            "wide; must be clearly longer. Does it open? Set the midline's two ends, or draw a mask."
        )
    axis = axes[:, 1] if axes[1, 1] >= 0 else -axes[:, 1]
    Midline((x, y), (x + axis[0], y + axis[1]))  # within 45 degrees of the vertical
    row, centre, width = np.concatenate(slits, axis=1)
    slope, offset = np.polyfit(row, centre, 1, w=1 / width)
    ends = [(float(offset + slope * end), float(end)) for end in (row.min(), row.max())]
    return Midline(*ends)
