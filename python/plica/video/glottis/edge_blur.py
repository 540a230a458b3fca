"""How blurred the edges of the glottis are: by the lens, out of focus, or by motion during the exposure.

Across an edge that a Gaussian of standard deviation s blurs, grey goes from dark to tissue as the normal
distribution does, whose steepest slope is 1 / (sqrt(2 pi) s) of the way a pixel. Profiles of grey along the
normals of the outline are laid over each other where they are halfway, so that noise and texture average out,
and s is told by the steepest slope of their mean. Frames are blurred by 1 px first, so that noise does not
decide where halfway is; that is taken out again, as variances. A pixel's own width (0.3 px) stays in. Each
side of the midline has its own mean: shade beside one fold is no blur, so the sharper side counts.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from plica.video.glottis.brightness import blurred
from plica.video.glottis.midline import Midline

__all__ = ["EdgeProfiles", "normals"]

Floats = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

_REACH = 4.0  # px on either side of the outline
_CLEAR = 0.8  # of the reach: how far from the outline a profile ends at least, in glottis and in tissue
_STEP = 0.25  # px
_END = 5  # samples at either end of a profile: those of the dark and of the tissue
_TURN = 2.0  # px from the outline of whole pixels, within which grey is halfway
_AGAINST_NOISE = 1.0  # px
_SMOOTH = 1.5  # px, by which the outline's normals are
_FEWEST = 50  # profiles of a side


class EdgeProfiles:
    """Profiles of grey across the outline of the glottis, frame by frame, left and right of the midline."""

    def __init__(self, midline: Midline) -> None:
        self._midline = midline
        self._offsets = np.arange(-_REACH - 1, _REACH + 1 + _STEP / 2, _STEP)
        self._sums = np.zeros((2, self._offsets.size))
        self._counts = np.zeros(2, dtype=int)

    def add(self, frame: npt.NDArray[np.floating], glottis: Mask) -> None:
        """Those of a frame (h, w) and its glottis, where it is wide enough for edges that do not meet."""
        from scipy import ndimage

        depth = ndimage.distance_transform_edt(glottis)
        if depth.max() < _REACH:
            return
        depth -= ndimage.distance_transform_edt(~glottis)
        places, outward = normals(glottis, depth)
        lines = places[:, :, None] + outward[:, :, None] * self._offsets  # (2, n, samples)
        ends = ndimage.map_coordinates(depth, lines[:, :, [_END - 1, -_END]], order=1, mode="nearest")
        clear = (ends[:, 0] >= _CLEAR * _REACH) & (ends[:, 1] <= -_CLEAR * _REACH)
        light = blurred(frame, _AGAINST_NOISE)
        grey = ndimage.map_coordinates(light, lines[:, clear], order=3, mode="nearest")
        dark, tissue = grey[:, :_END].mean(axis=1), grey[:, -_END:].mean(axis=1)
        right = self._midline.place(places[::-1, clear].T)[:, 1] > 0
        for side, low, high, profile in zip(right.astype(int), dark, tissue, grey, strict=True):
            if high > low:
                self._lay(side, (profile - low) / (high - low))

    def _lay(self, side: int, profile: Floats) -> None:
        """Over the others of its side, halfway at 0; not where it is halfway more than once."""
        near = np.flatnonzero(np.abs(self._offsets) <= _TURN)
        turns = near[:-1][(profile[near[:-1]] <= 0.5) & (profile[near[1:]] > 0.5)]
        if turns.size != 1:
            return
        k = int(turns[0])
        half = self._offsets[k] + _STEP * (0.5 - profile[k]) / (profile[k + 1] - profile[k])
        self._sums[side] += np.interp(self._offsets + half, self._offsets, profile)
        self._counts[side] += 1

    @property
    def blur(self) -> float:
        """px, of the sharper side; not a number where no glottis is eight pixels wide."""
        found = []
        for total, count in zip(self._sums, self._counts, strict=True):
            if count >= _FEWEST:
                slope = float(np.gradient(total / count, _STEP).max())
                found.append(np.sqrt(max(1 / (2 * np.pi * slope**2) - _AGAINST_NOISE**2, 0.0)))
        return float(min(found, default=np.nan))


def normals(glottis: Mask, depth: Floats) -> tuple[Floats, Floats]:
    """(2, n) row and column of the pixels at the outline, and the outward normals there."""
    from scipy import ndimage

    edge = glottis & ~ndimage.binary_erosion(glottis)
    row, column = np.nonzero(edge)
    slope = np.stack(np.gradient(ndimage.gaussian_filter(depth, _SMOOTH)))[:, row, column]
    steep = np.hypot(*slope)
    kept = steep > 0.5  # else a tip, which has no normal
    return np.stack([row, column]).astype(float)[:, kept], -(slope / np.maximum(steep, 1e-12))[:, kept]
