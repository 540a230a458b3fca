"""How far the border of a mask that somebody drew lies off the edge that the picture shows.

Grey is read along the normals of the mask's outline. The edge is where it rises most steeply outwards, from
the dark of the glottis to the tissue, if that is steeper than shade and texture are. Places of one border
differ by what the hand and the pixels do, their median does not. Left and right borders are looked at one by
one: a mask may be too wide, too narrow, or beside the glottis. A border outside the edge lies on bright
tissue. One inside it may be right, as a medial surface in shade looks like glottis; but a lamp shades one
side alone.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from plica.video.glottis.brightness import around, blurred, dark_level
from plica.video.glottis.edge_blur import normals

__all__ = ["border_off", "doubt", "is_off"]

Floats = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

_MOST = 1.5  # px: masks of films, and of real frames by experts, are off by up to 1.3 on the better side
_REACH = 8.0  # px on either side of the border, in which the edge is looked for
_STEP = 0.25  # px
_AGAINST_NOISE = 1.0  # px
_STEEP = 0.08  # of the contrast a px: what is less steep is shade or texture, and no edge
_CLEAR = 6.0  # times the noise (median), of the contrast
_PIXEL = 0.5  # px, from the middle of a mask's last pixel to its border
_FEWEST = 12  # places of a border


def border_off(frame: npt.NDArray[np.floating], mask: Mask) -> Floats:
    """(2) px that the left and the right border in the image of a mask (h, w), drawn on a frame (h, w), lie
    outside the edge; below 0 inside; not a number where the picture shows too little of it."""
    from scipy import ndimage

    unknown = np.full(2, np.nan)
    ring = around(mask)
    if not mask.any() or not ring.any():
        return unknown
    depth = ndimage.distance_transform_edt(mask) - ndimage.distance_transform_edt(~mask)
    places, outward = normals(mask, depth)
    light = blurred(frame, _AGAINST_NOISE)
    contrast = float(np.median(frame[ring])) - dark_level(frame, mask)
    if not places.size or not contrast > _CLEAR * float(np.median(np.abs(frame - light))):
        return unknown
    found = _edges(light, places, outward, _STEEP * contrast)
    right = outward[1] > 0
    return np.array([_median(found[side & np.isfinite(found)]) for side in (~right, right)])


def is_off(off: Floats) -> Mask:
    """(n) whether one border (n, 2) of a mask lies outside the edge, or both inside."""
    known = np.isfinite(off)
    outside = (known & (off > _MOST)).any(axis=1)
    return np.asarray(outside | (known & (off < -_MOST)).all(axis=1))


def doubt(off: Floats) -> str:
    """A sentence of those masks that are off, by the frames of (frames, 2) px; empty where none is."""
    frames = np.flatnonzero(is_off(off))
    if not frames.size:
        return ""
    worst = int(frames[np.nanmax(np.abs(off[frames]), axis=1).argmax()])
    borders = [
        f"its {side} border {abs(way):.1f} px {'outside' if way > 0 else 'inside'}"
        for side, way in zip(("left", "right"), off[worst].tolist(), strict=True)
        if np.isfinite(way)
    ]
    size = "large" if np.nanmean(off[worst]) > 0 else "small"
    looked_at = int(np.isfinite(off).any(axis=1).sum())
    lie = "lies" if frames.size == 1 else "lie"
    which = "the drawn mask" if looked_at == 1 else f"{frames.size} of {looked_at} drawn masks"
    return (
        f"{which} {lie} off the edge that the picture shows; in frame {worst} {' and '.join(borders)} "
        f"(medians, which must be within {_MOST:g} px), and the area is too {size} by as much: draw it again "
        "(plica masks --page)"
    )


def _edges(light: npt.NDArray[np.floating], places: Floats, outward: Floats, least: float) -> Floats:
    """(n) px, how far the border lies outside the steepest rise of grey, at places of it; not a number where
    none is as steep as `least` (grey levels a px)."""
    from scipy import ndimage

    offsets = np.arange(-_REACH, _REACH + _STEP / 2, _STEP)
    lines = places[:, :, None] + outward[:, :, None] * (offsets + _PIXEL)
    grey = ndimage.map_coordinates(light, lines, order=1, mode="nearest")
    slope = np.gradient(grey, _STEP, axis=1)
    steepest = slope.argmax(axis=1)
    return np.where(slope.max(axis=1) >= least, -offsets[steepest], np.nan)


def _median(values: Floats) -> float:
    return float(np.median(values)) if values.size >= _FEWEST else float("nan")
