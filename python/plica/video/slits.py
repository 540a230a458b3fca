"""Slits that blur hides from the outline, by how much they darken the line in which the folds meet.

The outline halfway from the glottis' dark D to the tissue loses slits that blur makes too bright
(:mod:`plica.video.blurred_slit`). But blur moves light about and takes none away: tissue that leaves the band
next to the midline takes its grey levels with it, so that on a line across the midline

    sum (I_closed - I) = w (I_rim - D),

w being the slit's width, whatever the blur (docs/recordings.md, "Slits that blur hides"). Closed folds are
those of the frames without a slit on this line in which the lines about it, themselves left out so that
noise does not choose, are brightest.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from plica.measures.pulses import autocorrelation_frequency
from plica.video.blurred_slit import hidden_width, outline_width
from plica.video.glottal_area import GlottalArea, LostToBlur
from plica.video.midline_grey import GreyLines

__all__ = ["closure", "lost_to_blur"]

Floats = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

_NARROW = 2.0  # of the blur s: of a slit that is wider the outline halfway loses less than a tenth of s
_UNKNOWN = 1.1  # px, where the edges do not tell their blur: from there on it would be doubted
_ALONG = 1.5  # px, standard deviation of the blur along the midline, against noise
_RIM_ALONG = 2.0  # px, the same of the tissue's grey level
_NEIGHBOURS, _APART = 8, 4  # px along the midline, within which lines tell of a closed one, and beyond which
_CLOSED = 4  # one in so many of the frames without a slit, the brightest, are closed
_FEWEST = 8  # frames without a slit; of fewer nothing is said
_CYCLES = 2  # on either side of a frame, from which closed ones are taken
_FAINT = 20.0  # grey levels by which tissue is brighter than the glottis, at least
_TOUCHING = 3  # px along the midline about slits that the outline has

closure = 0.01
"""Of the largest area: in a frame without an outline, less is closure."""

_INNER, _BAND = 0.2, (0.15, 0.7)  # the further outlines, as shares of the way to the tissue


def lost_to_blur(lines: GreyLines, blur: float, outlined: Mask) -> LostToBlur:
    """What the outlines of all frames lose.

    Parameters
    ----------
    lines : GreyLines
    blur : float
        px, standard deviation, of the glottis' edges in what was segmented; not a number: not known.
    outlined : (frames) bool
        Whose outlines stand halfway: others, drawn or not known, lose nothing.
    """
    from scipy import ndimage

    blur = blur if np.isfinite(blur) else _UNKNOWN
    if not np.isfinite(lines.dark):
        none = np.zeros(outlined.size)
        return LostToBlur(*2 * [GlottalArea(*4 * [none])], none, none)
    known, seen = outlined[:, None], lines.width.sum(axis=0)
    near = ndimage.binary_dilation((seen > 0).any(axis=0), iterations=_TOUCHING)
    narrow = (seen < _NARROW * blur) & near & known
    most = hidden_width(blur)
    hidden = np.where(narrow, np.clip(_darkness(lines, outlined) - lines.width, -most, most), 0.0)
    area = seen.sum(axis=1)
    hidden[:, (area == 0) & (hidden.sum(axis=(0, 2)) < closure * area.max())] = 0.0
    sides = np.maximum(lines.width + hidden, 0.0)
    width = sides.sum(axis=0)
    inner = np.where(known, sides - _narrower(sides, width - outline_width(width, blur, _INNER)), 0.0)
    low, high = (outline_width(width, blur, share).sum(axis=1) for share in _BAND)
    besides = np.where(narrow & (seen == 0), np.maximum(most - width, 0.0), 0.0)
    return LostToBlur(
        outline=_of_lines(hidden, lines.middle),
        inner=_of_lines(inner, lines.middle),
        band=np.where(outlined, high - low, 0.0),
        most=besides.sum(axis=1),
    )


def _narrower(width: Floats, by: Floats) -> Floats:
    """(2, frames, lines) px: the sides of slits that become narrower by so much, half of it at each edge."""
    left = np.clip(width[0] - by / 2, 0.0, np.maximum(width.sum(axis=0) - by, 0.0))
    return np.stack([left, np.maximum(width.sum(axis=0) - by, 0.0) - left])


def _of_lines(width: Floats, middle: Mask) -> GlottalArea:
    """Of widths (2, frames, lines) left and right of the midline."""
    return GlottalArea(*width.sum(axis=2), *width[:, :, middle].mean(axis=2))


def _darkness(lines: GreyLines, outlined: Mask) -> Floats:
    """(2, frames, lines) px of slit on each side, by how much darker the band is than with closed folds; not
    a number where those are not known."""
    from scipy import ndimage

    bright = lines.light - lines.dark
    light = np.where(bright > 0, bright / max(float(np.nanmedian(bright)), 1e-9), 1.0)[:, None]
    grey = (lines.grey - lines.dark * lines.extent[:, None]) / light
    contrast = ndimage.gaussian_filter1d((lines.rim - lines.dark) / light, _RIM_ALONG, axis=2)
    seen = lines.width.sum(axis=0)
    closed = _closed(grey, (seen == 0) & outlined[:, None], seen.sum(axis=1))
    darker = ndimage.gaussian_filter1d(np.nan_to_num(closed - grey), _ALONG, axis=2)
    return np.where(np.isfinite(closed), darker / np.maximum(contrast, _FAINT), lines.width)


def _closed(grey: Floats, without: Mask, area: Floats) -> Floats:
    """(2, frames, lines) what the lines have with closed folds, in the cycles about each frame; not a number
    where too few frames are `without` a slit."""
    from scipy import ndimage

    apart = np.arange(-3 * _NEIGHBOURS, 3 * _NEIGHBOURS + 1)
    weight = np.exp(-(apart**2) / (2 * _NEIGHBOURS**2)) * (np.abs(apart) > _APART)
    beside = ndimage.convolve1d(grey, weight / weight.sum(), axis=2, mode="nearest")
    frames = area.size
    frequency = autocorrelation_frequency(area, 1.0) if frames >= _FEWEST else float("nan")
    period = max(round(1 / frequency), 1) if np.isfinite(frequency) else frames
    found = np.full(grey.shape, np.nan)
    for begin in range(0, frames, period):
        part = slice(max(begin - _CYCLES * period, 0), begin + (1 + _CYCLES) * period)
        count = without[part].sum(axis=0)
        chosen = np.maximum(count // _CLOSED, 1)
        order = np.argsort(np.where(without[part], -beside[:, part], np.inf), axis=1)
        ranked = np.take_along_axis(grey[:, part], order, axis=1)
        taken = np.arange(ranked.shape[1])[:, None] < chosen
        mean = np.sum(ranked, axis=1, where=taken) / chosen
        found[:, begin : begin + period] = np.where(count >= _FEWEST, mean, np.nan)[:, None]
    return found
