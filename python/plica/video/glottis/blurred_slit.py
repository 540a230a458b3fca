"""The outline of a slit that a Gaussian blurs.

A slit of width w between edges that a Gaussian of standard deviation s blurs is, at a distance x from its
middle, darker than the tissue by a share

    d(x) = Phi((w/2 + x) / s) + Phi((w/2 - x) / s) - 1

of the contrast. The outline at a share q of the way from dark to tissue stands where d = 1 - q: a slit with
d(0) = erf(w / (2 sqrt(2) s)) below 1 - q has none.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

__all__ = ["hidden_width", "outline_width", "slit_width"]

Floats = npt.NDArray[np.float64]

_FAR = 8.0  # of the blur: the edges of a slit that is wider by so much do not know of each other
_BISECTIONS = 40
_STEPS = 200  # of the widths between which others lie


def hidden_width(blur: float, share: float = 0.5) -> float:
    """px, below which a slit has no outline at this share of the way: 2 sqrt(2) erfinv(1 - q) s; 1.35 s
    halfway."""
    from scipy import special

    return float(2 * np.sqrt(2) * special.erfinv(1 - share) * blur)


def outline_width(width: npt.ArrayLike, blur: float, share: float = 0.5) -> Floats:
    """px, between the outlines at this share of the way of slits of these widths (px); 0 where there is
    none."""
    from scipy import special

    width = np.asarray(width, dtype=float)
    if blur <= 0:
        return width
    least = hidden_width(1.0, share)
    known = least + _FAR * np.linspace(0.0, 1.0, 200) ** 2  # the outline begins as a square root does
    low, high = np.zeros(known.size), known / 2 + 2.0
    for _ in range(_BISECTIONS):
        middle = (low + high) / 2
        inside = special.ndtr(known / 2 + middle) + special.ndtr(known / 2 - middle) - 1 > 1 - share
        low, high = np.where(inside, middle, low), np.where(inside, high, middle)
    found = np.interp(width / blur, known, 2 * low, left=0.0)
    wider = width / blur > known[-1]
    return blur * np.where(wider, width / blur + 2 * special.ndtri(share), found)


def slit_width(outline: Floats, blur: float) -> Floats:
    """Width (...) of slits whose outlines halfway are so wide, px, under this blur: the inverse of
    :func:`outline_width`; one that can hardly be seen has the :func:`hidden_width`."""
    if not blur > 0:
        return outline
    widths = np.linspace(hidden_width(blur), _FAR * blur, _STEPS)
    outlines = outline_width(widths, blur)
    return np.where(outline < outlines[-1], np.interp(outline, outlines, widths), outline)
