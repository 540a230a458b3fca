"""Where the glottis is in a frame: the dark region whose outline is the strongest edge over scales.

After Paper D, Sec. 2.3 (Lindeberg's scale-space edges). Edge strength is the largest over the scales s of
s^(1/2) |grad (G_s * I)|, which a blurred step of any width answers alike. Candidates are the connected
components of I < T over a ladder of thresholds T, I being brightness over that of wider surroundings, then of
closer ones; a candidate's score is the mean edge strength along its outline times what is known of where a
glottis can be. The glottis is the best one that is as dark as a hole, not as a shadow (so there may be none),
and with it those that lie in its line: other openings between the same folds.

The constants below were chosen on one half of forty frames and judged on the other
(benchmarks/video/glottis.py).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from plica.video.glottis.brightness import around, blurred, region_below, relative_brightness
from plica.video.glottis.candidates import Prior, View, candidates
from plica.video.glottis.regions import filled

__all__ = ["Glottis", "segment"]

Floats = npt.NDArray[np.floating]
Mask = npt.NDArray[np.bool_]

_SURROUNDINGS = (
    0.08,
    0.025,
)  # of the longer side; dim slits differ only from what is close to them
_DARK = 0.65  # of the light of the tissue around: what has more is a shadow
_IN_LINE = 0.8  # the same for what lies in line with a glottis: a slit that the lens fills with light
_OTHERS = 0.4  # of the glottis' score: what other openings have at least
_LONG = 1.5  # times as long as wide: has a line
_BENT = 0.3  # px off the line a px along it, by which folds that are bowed have openings beside each other
_BEYOND = 4.0  # half lengths along the line, beyond which nothing is of the same glottis
_BLACK = 0.25  # of the brightness that a twentieth of the pixels exceed
_TURNS = 3  # of finding the outline again
_INSIDE = 25  # percentile of the brightness inside: where it ran out into a shade, most of it is too bright


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


def segment(image: Floats, prior: Prior | None = None, least_score: float = 0.05) -> Glottis:
    """The glottis of one frame.

    Parameters
    ----------
    image : (h, w) grey
        Black is the darkest pixel, or a quarter of the bright ones where that is less.
    prior : Prior, optional
    least_score : float
        A candidate below it is no glottis.
    """
    known = prior or Prior()
    alone = known.where is None  # else it is known what moves, which tells shades and slits from each other
    outline = (_INSIDE, _TURNS) if alone else (50, 1)
    views = [View(relative_brightness(image, share)) for share in _SURROUNDINGS[: 2 if alone else 1]]
    found = [one for view in views for one in candidates(view, known, _OTHERS * least_score)]
    light = blurred(image) - min(float(np.min(image)), _BLACK * float(np.percentile(image, 95)))
    glottis: Glottis | None = None
    for one in sorted(found, key=lambda one: one.score, reverse=True):
        if one.score < (least_score if glottis is None else _OTHERS * glottis.score):
            break
        mask = one.mask()
        if glottis is None:
            if _share_of_light(light, mask) < _DARK:
                glottis = _at_half(Glottis(mask, one.score, one.threshold), one.view, *outline)
        elif (
            _in_line(mask, glottis.mask, 0.0 if alone else _BENT) and _share_of_light(light, mask) < _IN_LINE
        ):
            other = _at_half(Glottis(mask, one.score, one.threshold), one.view, *outline)
            glottis = replace(glottis, mask=glottis.mask | other.mask)
    return glottis or Glottis(np.zeros(image.shape, dtype=bool), 0.0, float("nan"))


def _share_of_light(light: Floats, mask: Mask) -> float:
    """What is left inside a mask of the light around it, on its darker side (a fifth is darker still)."""
    ring = around(mask)
    if not ring.any():
        return 1.0
    return float(np.median(light[mask])) / max(float(np.percentile(light[ring], 20)), 1e-12)


def _in_line(mask: Mask, first: Mask, bent: float) -> bool:
    """Whether a part lies apart from the first ones along their line, or their width off it, and by a share
    `bent` of how far along it is more, as folds that are bowed do."""
    if (mask & first).any():
        return False
    y, x = np.nonzero(first)
    if x.size < 2:
        return False
    spreads, axes = np.linalg.eigh(np.cov(np.stack([x, y])) + np.eye(2) / 12)
    if spreads[1] < _LONG**2 * spreads[0]:
        return False
    along, across = axes[:, 1], axes[:, 0]
    place = np.argwhere(mask)[:, ::-1] - np.array([x.mean(), y.mean()])
    half, width = 2 * np.sqrt(spreads[1]), max(2 * np.sqrt(spreads[0]), 2.0)
    off = float(np.median(np.abs(place @ across)))
    far = float(np.median(np.abs(place @ along)))
    return bool(off <= width + bent * far and np.abs(place @ along).max() <= _BEYOND * half)


def _at_half(found: Glottis, view: View, percentile: float, turns: int) -> Glottis:
    """The outline halfway between the brightness inside (its percentile) and around: where a blurred step is.

    Found again from the outline that this gives, for what was found first may run out into a shade.
    """
    from scipy import ndimage

    relative, mask, threshold = view.relative, found.mask, found.threshold
    for _ in range(turns):
        inside = ndimage.binary_erosion(mask)
        inside = inside if inside.any() else mask
        dark = float(np.percentile(relative[inside], percentile))
        level = 0.5 * (dark + float(np.median(relative[around(mask)])))
        turned = region_below(view.smooth, level, mask)
        if not 0.4 < turned.sum() / mask.sum() < 1.5:  # it would run out into shadows, or vanish
            break
        mask, threshold = turned, level
    return Glottis(filled(mask), found.score, threshold)
