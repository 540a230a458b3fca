"""How blurred the edges of the glottis are: by the lens, out of focus, or by motion during the exposure.

Across an edge of the glottis that a Gaussian of standard deviation s blurs, grey goes from dark to tissue as
the normal distribution does, whose steepest slope is 1 / (sqrt(2 pi) s) of the way a pixel. Profiles of grey
along the normals of the outline are laid over each other where they are halfway, so that noise and texture
average out, and s is told by the steepest slope of their mean. Each side of the midline has its own: shade
beside one fold is no blur, so the sharper side counts.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from plica.video.brightness import blurred
from plica.video.midline import Midline, pixels

__all__ = ["EdgeProfiles"]

Floats = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

_REACH = 4.0  # px on either side of the outline
_STEP = 0.25  # px
_AGAINST_NOISE = 1.0  # px, by which frames are blurred, and which is taken out of what is found
_FEWEST = 50  # profiles of a side


class EdgeProfiles:
    """Profiles of grey across the outline of the glottis, frame by frame, left and right of the midline."""

    def __init__(self, midline: Midline) -> None:
        self._midline = midline
        self._offsets = np.arange(-_REACH - 1, _REACH + 1 + _STEP / 2, _STEP)
        self._sums = np.zeros((2, self._offsets.size))
        self._counts = np.zeros((2, self._offsets.size))

    def add(self, frame: npt.NDArray[np.floating], mask: Mask) -> None:
        """Those of a frame (h, w) and its glottis, where it is wide enough for edges that do not meet."""
        from scipy import ndimage

        depth = ndimage.distance_transform_edt(mask)
        if depth.max() < _REACH:
            return
        away = depth - ndimage.distance_transform_edt(~mask)
        smooth = ndimage.gaussian_filter(away, 1.5)
        edge = mask & ~ndimage.binary_erosion(mask)
        edge[[0, -1]] = edge[:, [0, -1]] = False
        y, x = np.nonzero(edge)
        down, right = (part[y, x] for part in np.gradient(smooth))
        size = np.hypot(down, right)
        keep = size > 0.5
        y, x, down, right, size = (part[keep] for part in (y, x, down, right, size))
        outward = -np.stack([down, right]) / size  # (2, n)
        at = np.stack([y, x])[:, :, None] + outward[:, :, None] * self._offsets
        ends = ndimage.map_coordinates(away, at[:, :, [4, -5]], order=1, mode="nearest")
        wide = (ends[:, 0] >= 0.8 * _REACH) & (ends[:, 1] <= -0.8 * _REACH)
        grey = ndimage.map_coordinates(blurred(frame, _AGAINST_NOISE), at[:, wide], order=1, mode="nearest")
        side = (self._midline.place(np.stack([x, y], axis=-1)[wide].astype(float))[:, 1] > 0).astype(int)
        dark, bright = grey[:, :5].mean(axis=1), grey[:, -5:].mean(axis=1)
        level = (grey - dark[:, None]) / np.where(bright > dark, bright - dark, np.nan)[:, None]
        middle = self._offsets.size // 2
        near = slice(middle - 8, middle + 9)
        for one, profile in zip(side, level, strict=True):
            above = profile[near] > 0.5
            turn = np.flatnonzero(~above[:-1] & above[1:])
            if turn.size != 1 or not np.isfinite(profile).all():
                continue
            k = middle - 8 + int(turn[0])
            at_half = self._offsets[k] + _STEP * (0.5 - profile[k]) / (profile[k + 1] - profile[k])
            self._sums[one] += np.interp(self._offsets + at_half, self._offsets, profile)
            self._counts[one] += 1

    @property
    def blur(self) -> float:
        """px, of the sharper side; not a number where no frame shows a glottis that is wide enough."""
        found = []
        for total, count in zip(self._sums, self._counts, strict=True):
            if count[0] >= _FEWEST:
                slope = np.gradient(total / count, _STEP).max()
                found.append(np.sqrt(max(1 / (2 * np.pi * slope**2) - _AGAINST_NOISE**2, 0.0)))
        return min(found, default=float("nan"))
