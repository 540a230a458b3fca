"""Brightness of a frame: blurred, over that of its surroundings, its edges, and the parts below a level."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from plica.video.glottis.regions import bounds, filled, grown

__all__ = ["around", "blurred", "dark_level", "edge_strength", "region_below", "relative_brightness"]

Floats = npt.NDArray[np.floating]
Mask = npt.NDArray[np.bool_]

_SCALES = (1.0, 1.5, 2.2, 3.2)  # px


def edge_strength(image: Floats) -> Floats:
    """(h, w) the largest over scales s of s^(1/2) |grad (G_s * I)|, in units of the image."""
    from scipy import ndimage

    strongest = np.zeros(image.shape)
    for scale in _SCALES:
        strength = np.sqrt(scale) * ndimage.gaussian_gradient_magnitude(image, scale, mode="mirror")
        np.maximum(strongest, strength, out=strongest)
    return strongest


def relative_brightness(image: Floats, share: float = 0.08) -> Floats:
    """(h, w) brightness over that of the surroundings: light and highlights fall out.

    The surroundings are a Gaussian whose standard deviation is this share of the longer side.
    """
    from scipy import ndimage

    image = np.asarray(image, dtype=float)
    image = np.minimum(image - image.min(), np.percentile(image, 95) - image.min())
    surroundings = ndimage.gaussian_filter(image, share * max(image.shape), mode="mirror")
    return np.asarray(image / (surroundings + max(0.1 * image.max(), 1e-12)))


def region_below(image: Floats, threshold: float, reach: Mask, least: int = 1) -> Mask:
    """The parts of image < threshold that touch `reach` and have `least` pixels or more, holes filled."""
    from scipy import ndimage

    below = np.asarray(image < threshold)
    box = bounds(below)
    labels, count = ndimage.label(below[box])
    kept = np.zeros(count + 1, dtype=bool)
    kept[labels[reach[box]]] = True
    kept &= np.bincount(labels.ravel(), minlength=count + 1) >= least
    kept[0] = False
    found = np.zeros_like(below)
    found[box] = filled(kept[labels])
    return found


def blurred(image: Floats, by: float = 1.0) -> Floats:
    """(h, w) by a Gaussian of `by` px: noise falls, a step stays where it is."""
    from scipy import ndimage

    if by == 0:
        return np.asarray(image, dtype=float)
    return np.asarray(ndimage.gaussian_filter(np.asarray(image, dtype=float), by, mode="mirror"))


def around(mask: Mask) -> Mask:
    """A ring three to five pixels outside."""
    near = grown(mask, 2)
    return grown(near, 3) & ~near


def dark_level(frame: npt.NDArray[np.floating], glottis: Mask) -> float:
    """Grey level of the glottis (h, w) of a frame: the lower quartile; not a number without one."""
    return float(np.percentile(frame[glottis], 25)) if glottis.any() else float("nan")
