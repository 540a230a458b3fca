"""The glottal contour of a prephonatory frame with subpixel resolution, and checks of the glottis."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from plica.errors import InvalidInput
from plica.video import Midline, find_midline, segment
from plica.video.glottis.brightness import around, blurred

__all__ = ["Contour", "glottal_contour"]

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

_SPECK = 0.02  # of the glottis' pixels: smaller openings are left out
_LEAST_PIXELS, _LEAST_LENGTH, _LEAST_WIDTH = 40, 20.0, 3.0  # px^2, px, px
_REACH = 1.5  # px, largest distance of the contour from the mask's outline
_BLUR = 0.7  # px
_NEAR = 8.0  # px, over which the tissue's brightness is averaged
_FAINT = 0.25  # of the contrast, below which the mask's outline is used


@dataclass(frozen=True)
class Contour:
    """The outline of the glottis.

    Attributes
    ----------
    points : (n, 2) px
        Column and row, around it once; the last point is connected to the first.
    midline : Midline
        The line that the glottis lies along.
    mask : (h, w) bool
        The glottis: its openings and the bridges between them.
    openings : int
        Number along the midline; between them the folds touch, and the contour is a pixel wide.
    left_out : int
        Pixels of specks that are left out.
    by_mask : float
        Share of the points on the mask's outline, as the frame has too little contrast (or is not given).
    """

    points: Floats
    midline: Midline
    mask: Mask
    openings: int
    left_out: int
    by_mask: float

    @property
    def area(self) -> float:
        """px^2."""
        x, y = self.points.T
        return 0.5 * abs(float(x @ np.roll(y, -1) - y @ np.roll(x, -1)))


def glottal_contour(frame: Floats | None, mask: Mask | None = None) -> Contour:
    """The line where a frame's grey level is halfway between glottis and tissue, near a mask's outline.

    It lies within 1.5 px of the outline. The tissue's brightness is a local average, so that uneven light
    does not move the contour.

    Parameters
    ----------
    frame : (h, w) grey, or None
        None: the mask's outline alone.
    mask : (h, w) bool, optional
        None: the frame is segmented (`plica.video.segment`).

    Raises
    ------
    InvalidInput
        Without a usable glottis: none, closed, cut by the picture's border, several openings that are not
        along one line, too few pixels, too round for a midline; for a mask of another size.
    """
    picture, glottis = _checked(frame, mask)
    kept, left_out = _without_specks(glottis)
    rim = np.concatenate([kept[0], kept[-1], kept[:, 0], kept[:, -1]])
    if rim.any():
        raise InvalidInput(
            f"Glottis: pixels on the picture's border = {int(rim.sum())}; must be 0. "
            "Use a frame that shows the whole glottis."
        )
    if kept.sum() < _LEAST_PIXELS:
        raise InvalidInput(
            f"Glottis: area = {int(kept.sum())} px; must be >= {_LEAST_PIXELS}. Is this the prephonatory "
            "frame, and is the picture large enough?"
        )
    line = find_midline([kept])
    joined, bridge, openings = _joined(kept, line)
    length, width = line.length + 1, float(kept.sum()) / (line.length + 1)
    if length < _LEAST_LENGTH:
        raise InvalidInput(
            f"Glottis: length = {length:.1f} px; must be >= {_LEAST_LENGTH:g}. Use a picture with more "
            "pixels."
        )
    if width < _LEAST_WIDTH:
        raise InvalidInput(
            f"Glottis: mean width = {width:.1f} px; must be >= {_LEAST_WIDTH:g}. It is closed or nearly so: "
            "use a frame before phonation, with the folds apart."
        )
    field, faint = _field(picture, kept, bridge)
    points = _outline(field, joined)
    at = np.round(points).astype(int)
    return Contour(points, line, joined, openings, left_out, float(faint[at[:, 1], at[:, 0]].mean()))


def _checked(frame: Floats | None, mask: Mask | None) -> tuple[Floats | None, Mask]:
    """Frame and mask of one size, the mask not empty."""
    picture = None if frame is None else np.asarray(frame, dtype=float)
    if picture is not None and (picture.ndim != 2 or min(picture.shape) < 16):
        raise InvalidInput(f"Frame: shape = {picture.shape}; must be (h, w) grey of at least 16 x 16 px.")
    if picture is not None and not np.isfinite(picture).all():
        raise InvalidInput(f"Frame: {int((~np.isfinite(picture)).sum())} pixels are not finite; must be 0.")
    if mask is None:
        if picture is None:
            raise InvalidInput("Glottis: neither frame nor mask is given; must be at least one.")
        found = segment(picture).mask
        if not found.any():
            raise InvalidInput(
                "Glottis: the frame has no dark region with an edge; must have one. Is the glottis closed? "
                "Otherwise give its mask."
            )
        return picture, found
    glottis = np.asarray(mask)
    if glottis.ndim != 2 or (picture is not None and glottis.shape != picture.shape):
        size = "(h, w)" if picture is None else f"{picture.shape} px, that of the frame"
        raise InvalidInput(f"Mask: shape = {glottis.shape}; must be {size}.")
    if glottis.dtype != np.bool_:
        raise InvalidInput(f"Mask: type = {glottis.dtype}; must be bool, True in the glottis.")
    if not glottis.any():
        raise InvalidInput(
            "Mask: glottis = 0 px; must be > 0. A closed glottis has no prephonatory geometry: use a "
            "frame with the folds apart."
        )
    return picture, glottis


def _without_specks(mask: Mask) -> tuple[Mask, int]:
    """The openings, holes filled, and the number of pixels of specks left out."""
    from scipy import ndimage

    filled = np.asarray(ndimage.binary_fill_holes(mask))
    labels, _ = ndimage.label(filled, np.ones((3, 3)))
    sizes = np.bincount(labels.ravel())
    sizes[0] = 0
    kept = (sizes >= _SPECK * sizes.sum())[labels] & filled
    return np.asarray(kept), int(filled.sum() - kept.sum())


def _joined(mask: Mask, line: Midline) -> tuple[Mask, Mask, int]:
    """Openings along the midline joined to one glottis; the bridges between them; the number of openings."""
    from scipy import ndimage

    labels, count = ndimage.label(mask, np.ones((3, 3)))
    bridge = np.zeros_like(mask)
    if count == 1:
        return mask, bridge, 1
    found = []  # start and end along the midline, offset and half-width of each
    for label in range(1, count + 1):
        y, x = np.nonzero(labels == label)
        along, across = line.place(np.stack([x, y], axis=1).astype(float)).T
        half = 0.5 * y.size / (np.ptp(along) + 1)
        found.append((float(along.min()), float(along.max()), float(across.mean()), half))
    found.sort()
    for (_, end, before, wide), (begin, _, after, broad) in pairwise(found):
        if begin <= end or abs(before) > wide + 1 or abs(after) > broad + 1:
            raise InvalidInput(
                f"Glottis: separate openings = {count}; must be 1, or lie one after the other along the "
                "midline. Erase everything but the glottis from the mask."
            )
        steps = np.linspace(0, 1, int(4 * (begin - end)) + 8)
        place = np.stack([end + steps * (begin - end), before + steps * (after - before)], axis=1)
        column, row = np.round(line.points(place)).astype(int).T
        bridge[row, column] = True
    return mask | bridge, bridge & ~mask, count


def _field(frame: Floats | None, mask: Mask, bridge: Mask) -> tuple[Floats, Mask]:
    """(h, w) below 0 in the glottis, 0 on its contour; and where the contour is the mask's outline."""
    from scipy import ndimage

    own = np.where(mask | bridge, -0.5, 0.5)
    if frame is None:
        return own, np.ones(mask.shape, dtype=bool)
    smooth = blurred(frame, _BLUR)
    depth = ndimage.distance_transform_edt(mask)
    core = mask & (depth >= min(2.0, float(depth.max())))
    ring = around(mask)
    if not ring.any():
        raise InvalidInput("Mask: no tissue around the glottis; must be some.")
    dark = float(np.median(smooth[core]))
    weight = ndimage.gaussian_filter(ring.astype(float), _NEAR, mode="constant")
    tissue = ndimage.gaussian_filter(np.where(ring, smooth, 0.0), _NEAR, mode="constant")
    tissue /= np.maximum(weight, 1e-12)
    contrast = float(np.median(smooth[ring])) - dark
    if not contrast > 0:
        raise InvalidInput(
            f"Mask: the glottis is {-contrast:.3g} grey levels brighter than its surroundings; must be "
            "darker. Is the mask True in the glottis, and does it belong to this frame?"
        )
    faint = tissue - dark < _FAINT * contrast
    level = (smooth - dark) / np.where(faint, contrast, tissue - dark) - 0.5
    away = np.where(mask, depth, ndimage.distance_transform_edt(~mask)) > _REACH
    by_mask = faint | away | ndimage.binary_dilation(bridge, np.ones((3, 3)))
    return np.where(by_mask, own, np.clip(level, -0.5, 0.5)), faint


def _outline(field: Floats, mask: Mask) -> Floats:
    """(n, 2) the longest closed contour line of the field at 0."""
    from contourpy import contour_generator

    lines = [np.asarray(line, dtype=float) for line in contour_generator(z=field).lines(0.0)]
    closed = [line for line in lines if len(line) > 3 and np.array_equal(line[0], line[-1])]
    if not closed:
        raise InvalidInput(
            f"Glottis: no closed contour around its {int(mask.sum())} px; must be one. "
            "Does the mask belong to this frame?"
        )
    longest = max(closed, key=lambda line: float(np.linalg.norm(np.diff(line, axis=0), axis=1).sum()))
    return longest[:-1]
