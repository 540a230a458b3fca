"""Where the glottis is in a frame: the dark region whose outline is the strongest edge over scales.

After Paper D, Sec. 2.3 (Lindeberg's scale-space edges). Edge strength is the largest over the scales s of
s^(1/2) |grad (G_s * I)|, which a blurred step of any width answers alike. Candidates are the connected
components of I < T over a ladder of thresholds T, I being brightness over that of the surroundings; a
candidate's score is the mean edge strength along its outline times what is known of where a glottis can be.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

__all__ = ["Glottis", "Prior", "around", "blurred", "region_below", "segment"]

Floats = npt.NDArray[np.floating]
Mask = npt.NDArray[np.bool_]

_SCALES = (1.0, 1.5, 2.2, 3.2)  # px
_LADDER = 48  # thresholds


@dataclass(frozen=True)
class Prior:
    """What is known before the frame is looked at.

    Attributes
    ----------
    where : (h, w) or None
        Weight of each pixel, >= 0, largest 1: how much it varies over the recording, say. None: towards the
        centre of the frame.
    least_area, largest_area : float
        Of a glottis, as a share of the frame.
    """

    where: Floats | None = None
    least_area: float = 2e-4
    largest_area: float = 0.2


@dataclass(frozen=True)
class Glottis:
    """A segmented frame.

    Attributes
    ----------
    mask : (h, w) bool
        Empty where nothing dark is surrounded by an edge: a closed glottis.
    score : float
        Mean edge strength along the outline, of relative brightness, times the prior's weight; 0 if empty.
    threshold : float
        Relative brightness below which the glottis lies; NaN if empty.
    """

    mask: Mask
    score: float
    threshold: float


def edge_strength(image: Floats) -> Floats:
    """(h, w) the largest over scales s of s^(1/2) |grad (G_s * I)|, in units of the image."""
    from scipy import ndimage

    strongest = np.zeros(image.shape)
    for scale in _SCALES:
        strength = np.sqrt(scale) * ndimage.gaussian_gradient_magnitude(image, scale, mode="mirror")
        np.maximum(strongest, strength, out=strongest)
    return strongest


def segment(image: Floats, prior: Prior | None = None, least_score: float = 0.05) -> Glottis:
    """The glottis of one frame.

    Parameters
    ----------
    image : (h, w) grey
    prior : Prior, optional
    least_score : float
        A candidate below it is no glottis.
    """
    from scipy import ndimage

    known = prior or Prior()
    relative = relative_brightness(image)
    smooth = blurred(relative)
    strength = edge_strength(relative)
    where = _central(image.shape) if known.where is None else np.asarray(known.where, dtype=float)
    best = Glottis(np.zeros(image.shape, dtype=bool), 0.0, float("nan"))
    for threshold in np.linspace(0.1, 0.9, _LADDER):
        labels, count = ndimage.label(smooth < threshold)
        if not count:
            continue
        sizes = np.bincount(labels.ravel(), minlength=count + 1)
        least, largest = known.least_area * image.size, known.largest_area * image.size
        rim = np.unique(np.concatenate([labels[0], labels[-1], labels[:, 0], labels[:, -1]]))
        outline = labels * (
            ndimage.minimum_filter(labels, footprint=ndimage.generate_binary_structure(2, 1)) == 0
        )
        on_edge = np.bincount(outline.ravel(), minlength=count + 1)
        edges = np.bincount(outline.ravel(), weights=strength.ravel(), minlength=count + 1)
        weights = np.bincount(labels.ravel(), weights=where.ravel(), minlength=count + 1)
        for label in range(1, count + 1):
            if not least <= sizes[label] <= largest or label in rim or not on_edge[label]:
                continue
            score = edges[label] / on_edge[label] * weights[label] / sizes[label]
            if score > max(best.score, least_score):
                best = Glottis(labels == label, float(score), float(threshold))
    return _at_half(best, relative) if best.score else best


def _at_half(found: Glottis, relative: Floats) -> Glottis:
    """The outline halfway between the brightness inside and around: where a blurred step is."""
    from scipy import ndimage

    inside = ndimage.binary_erosion(found.mask)
    inside = inside if inside.any() else found.mask
    threshold = 0.5 * float(np.median(relative[inside]) + np.median(relative[around(found.mask)]))
    mask = region_below(blurred(relative), threshold, found.mask)
    if not 0.5 < mask.sum() / found.mask.sum() < 1.5:  # it would run out into shadows, or vanish
        return Glottis(ndimage.binary_fill_holes(found.mask), found.score, found.threshold)
    return Glottis(mask, found.score, threshold)


def relative_brightness(image: Floats) -> Floats:
    """(h, w) brightness over that of the surroundings: light and highlights fall out."""
    from scipy import ndimage

    image = np.asarray(image, dtype=float)
    image = np.minimum(image - image.min(), np.percentile(image, 95) - image.min())
    surroundings = ndimage.gaussian_filter(image, 0.08 * max(image.shape), mode="mirror")
    return np.asarray(image / (surroundings + max(0.1 * image.max(), 1e-12)))


def region_below(image: Floats, threshold: float, reach: Mask, least: int = 1) -> Mask:
    """The parts of image < threshold that touch `reach` and have `least` pixels or more, holes filled."""
    from scipy import ndimage

    labels, _ = ndimage.label(image < threshold)
    kept = np.unique(labels[reach & (labels > 0)])
    kept = kept[np.bincount(labels.ravel())[kept] >= least]
    return np.asarray(ndimage.binary_fill_holes(np.isin(labels, kept)))


def blurred(image: Floats, by: float = 1.0) -> Floats:
    """(h, w) by a Gaussian of `by` px: noise falls, a step stays where it is."""
    from scipy import ndimage

    if by == 0:
        return np.asarray(image, dtype=float)
    return np.asarray(ndimage.gaussian_filter(np.asarray(image, dtype=float), by, mode="mirror"))


def around(mask: Mask) -> Mask:
    """A ring three to five pixels outside."""
    from scipy import ndimage

    return np.asarray(
        ndimage.binary_dilation(mask, iterations=5) & ~ndimage.binary_dilation(mask, iterations=2)
    )


def _central(shape: tuple[int, ...]) -> Floats:
    """A weight that falls from 1 at the centre to a half at the middle of the sides."""
    y, x = np.ogrid[-1 : 1 : shape[0] * 1j, -1 : 1 : shape[1] * 1j]
    return np.asarray(1 / (1 + x**2 + y**2))
