"""Slits that blur hides from the outline, by how much they darken the place in which the folds meet.

The outline halfway from the glottis' dark D to the tissue loses slits that blur makes too bright
(:mod:`.blurred_slit`). But blur moves light about and takes none away: tissue that leaves the
core, the pixels next to the midline, takes its grey levels with it, so that on a line across the midline

    w = ((C - c R)_closed - (C - c R)) / (R - D),

w being the slit's width, C the sum over the c px of the core, and R the mean of the rim beyond, which has the
light and the shade that both have (docs/recordings_method.md, "Slits that blur hides"). The core lies where
the slit does, or where the folds touch: out of phase they part and meet beside the midline, where a core on
it would have no slit and the rim would, as shade. Closed folds are
those of the frames without a slit on this line in which the lines about it, not itself, are brightest: by its
own brightness noise would choose.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from plica.measures.pulses import autocorrelation_frequency
from plica.video.glottis.blurred_slit import hidden_width, outline_width
from plica.video.glottis.glottal_area import GlottalArea, LostToBlur
from plica.video.glottis.midline_profiles import GreyLines

__all__ = ["beside_midline", "closure", "lost_to_blur"]

Floats = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

_NARROW = 2.0  # of the blur s: of a slit that is wider the outline halfway loses less than a tenth of s
_UNKNOWN = 1.1  # px, where the edges do not show their blur: from there on it would be doubted
_ALONG = 1.5  # px, standard deviation of the blur along the midline, against noise
_RIM_ALONG = 2.0  # px, the same of the tissue's grey level
_NEIGHBOURS, _APART = 8, 4  # px along the midline, within which lines show a closed one, and beyond which
_CLOSED = 4  # one in so many of the frames without a slit, the brightest, are closed
_FEWEST = 8  # frames without a slit; with fewer no slit is measured
_CYCLES = 2  # on either side of a frame, from which closed ones are taken
_FAINT = 20.0  # grey levels by which tissue is brighter than the glottis, at least
_TOUCHING = 3  # px along the midline about slits that the outline has

closure = 0.01
"""Of the largest area: in a frame without an outline, less is closure."""

_DIMMED = 0.63
"""Of the blur: what a slit that is hidden in every frame takes from wider ones in its place. It leaves pixels
half as bright as tissue, so that the outline stands where a blurred edge has a quarter of its brightness."""

_INNER, _BAND = 0.2, (0.15, 0.7)  # the further outlines, as shares of the way to the tissue


def lost_to_blur(lines: GreyLines, blur: float, outlined: Mask, left: float = 0.5) -> LostToBlur:
    """What the outlines of all frames lose.

    Parameters
    ----------
    lines : GreyLines
    blur : float
        px, standard deviation, of the glottis' edges in what was segmented; not a number: not known.
    outlined : (frames) bool
        Frames whose outlines stand halfway: others, drawn or not known, lose nothing.
    left : float
        Share of the left fold in how the edges move: slits without an outline open by it from where the folds
        touch. An outline is too narrow by the same on both sides.

    Returns
    -------
    LostToBlur
        All zero, and `shade` not a number, if no frame has a glottis; `shade` is not a number either if no
        line has 8 frames without a slit. Measures are then those of the outline.
    """
    from scipy import ndimage

    blur = blur if np.isfinite(blur) else _UNKNOWN
    if not np.isfinite(lines.dark):
        none = np.zeros(outlined.size)
        nothing = GlottalArea(none, none, none, none)
        return LostToBlur(nothing, nothing, band=none, most=none, shade=float("nan"))
    known, seen = outlined[:, None], lines.width.sum(axis=0)
    near = ndimage.binary_dilation((seen > 0).any(axis=0), iterations=_TOUCHING)
    narrow = (seen < _NARROW * blur) & near & known
    most = hidden_width(blur)
    dark, shade = _darkness(lines, outlined, near)
    hidden = np.where(narrow, np.clip(dark - lines.width, -most, most), 0.0)
    area = seen.sum(axis=1)
    hidden[:, (area == 0) & (hidden.sum(axis=(0, 2)) < closure * area.max())] = 0.0
    sides = np.maximum(lines.width + hidden, 0.0)
    width = sides.sum(axis=0)
    narrower = _narrower(sides, width - outline_width(width, blur, _INNER))
    inner = np.where(known, sides - narrower, 0.0)
    low, high = (outline_width(width, blur, share).sum(axis=1) for share in _BAND)
    besides = np.where(narrow & (seen == 0), np.maximum(most - width, 0.0), 0.0)
    seems_closed = ((seen == 0) & known).any(axis=0)
    besides += np.where((seen > 0) & known & seems_closed, _DIMMED * blur, 0.0)
    return LostToBlur(
        outline=_of_lines(beside_midline(hidden, lines.width, lines.place), seen > 0, lines.middle, left),
        inner=_of_lines(beside_midline(inner, narrower, lines.place), seen > 0, lines.middle, left),
        band=np.where(outlined, high - low, 0.0),
        most=besides.sum(axis=1),
        shade=shade,
    )


def beside_midline(wider: Floats, width: Floats, place: Floats) -> Floats:
    """(2, frames, lines) px, left and right of the midline, of what slits are wider on either side of their
    place.

    Parameters
    ----------
    wider, width : (2, frames, lines) px
        By how much, and of slits as they are, left and right of the place; below 0 where they are narrower.
    place : (frames, lines) px
        Right of the midline.
    """
    way = np.array([-1.0, 1.0])[:, None, None]
    ends = place + way * width, place + way * (width + wider)
    low, high = np.minimum(*ends), np.maximum(*ends)
    right = np.where(high > low, np.clip(high / np.maximum(high - low, 1e-12), 0.0, 1.0), 0.0)
    return np.stack([((1 - right) * wider).sum(axis=0), (right * wider).sum(axis=0)])


def _narrower(width: Floats, by: Floats) -> Floats:
    """(2, frames, lines) px: the sides of slits that become narrower by so much, half of it at each edge."""
    left = np.clip(width[0] - by / 2, 0.0, np.maximum(width.sum(axis=0) - by, 0.0))
    return np.stack([left, np.maximum(width.sum(axis=0) - by, 0.0) - left])


def _of_lines(width: Floats, seen: Mask, middle: Mask, left: float) -> GlottalArea:
    """Of widths (2, frames, lines) left and right of the midline, in slits that have an outline or none."""
    of_left = np.where(seen, 0.5, left)
    total = width.sum(axis=0)
    edges = ((share * total)[:, middle].mean(axis=1) for share in (of_left, 1 - of_left))
    return GlottalArea(*width.sum(axis=2), *edges)


def _darkness(lines: GreyLines, outlined: Mask, near: Mask) -> tuple[Floats, float]:
    """(2, frames, lines) px of slit on each side, by how much darker the core is than with closed folds, over
    the rim: as the outline has it where closed folds are not known. And the share of all darkness that the
    rim has too, in lines without an outline."""
    from scipy import ndimage

    bright = lines.light - lines.dark
    lit = bright > 0
    light = np.where(lit, bright / np.median(bright[lit]), 1.0)[:, None] if lit.any() else np.float64(1.0)
    rim = ndimage.gaussian_filter1d((lines.rim - lines.dark) / light, _RIM_ALONG, axis=2)
    core, rims = (lines.core - lines.extent * lines.dark) / light, lines.extent * rim
    seen = lines.width.sum(axis=0)
    without = (seen == 0) & outlined[:, None]
    over_rim, both = core - rims, np.stack([core, rims])
    windows = _windows(seen.sum(axis=1))
    darker = _closed(over_rim, over_rim, without, windows) - over_rim
    fall = _closed(both, core + rims, without, windows) - both  # against folds that are bright all over
    counted = without & near & np.isfinite(darker).all(axis=0)
    dark, beside = (float(part.sum(where=counted)) for part in fall)
    slit = ndimage.gaussian_filter1d(np.nan_to_num(darker), _ALONG, axis=2)
    slit /= np.maximum(rim, _FAINT)
    found = np.where(np.isfinite(darker), slit, lines.width)
    return found, beside / dark if dark > 0 else float("nan")


def _windows(area: Floats) -> list[tuple[slice, slice]]:
    """Frames a period long, and those of the cycles about them."""
    frequency = autocorrelation_frequency(area, 1.0) if area.size >= _FEWEST else float("nan")
    period = max(round(1 / frequency), 1) if np.isfinite(frequency) else area.size
    about = _CYCLES * period
    return [
        (slice(k, k + period), slice(max(k - about, 0), k + period + about))
        for k in range(0, area.size, period)
    ]


def _closed(values: Floats, bright: Floats, without: Mask, windows: Sequence[tuple[slice, slice]]) -> Floats:
    """(..., 2, frames, lines) values with closed folds, those of the frames `without` a slit in whose
    neighbours the line is brightest; not a number where these are too few."""
    from scipy import ndimage

    apart = np.arange(-3 * _NEIGHBOURS, 3 * _NEIGHBOURS + 1)
    weight = np.exp(-(apart**2) / (2 * _NEIGHBOURS**2)) * (np.abs(apart) > _APART)
    beside = ndimage.convolve1d(bright, weight / weight.sum(), axis=2, mode="nearest")
    found = np.full(values.shape, np.nan)
    for part, about in windows:
        count = without[about].sum(axis=0)
        chosen = np.maximum(count // _CLOSED, 1)
        order = np.argsort(np.where(without[about], -beside[:, about], np.inf), axis=1)
        taken = np.arange(order.shape[1])[:, None] < chosen
        shown = values[..., about, :]
        ranked = np.take_along_axis(shown, np.broadcast_to(order, shown.shape), axis=-2)
        mean = np.sum(ranked, axis=-2, where=taken) / chosen
        found[..., part, :] = np.where(count >= _FEWEST, mean, np.nan)[..., None, :]
    return found
