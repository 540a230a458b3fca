"""The errors of a recorded glottal area and of the folds' edges, drawn all at once.

A draw is a voice that may have been filmed: the estimate with one value of each error, and the same with the
noise of whole pixels on top. Both go through the code that measures the estimate
(:mod:`plica.video.measures.intervals`). Errors are drawn evenly from their ranges as a Latin hypercube
(McKay, Beckman, Conover, Technometrics 21, 1979), with a fixed seed. With e half of the slit's width in the
middle tenth, l the length over which the glottis is open (1.5 area / width, that of a parabola), and signs as
the fold's own:

    slits that blur hides    d area = a added         how dark a slit is, is known to a part (hidden_slits)
    slits hidden always      d area = b most          where folds that seem closed may leave one
    shade                    d area = to the band     where the outline is not sharp
                             d edge = c (halfway - darkest part), in any phase of the cycle
    border                   d edge = p, d area = p l     the outline is too wide or too narrow
    whole pixels             d edge = q / (1 + 4 e^2)     of exact masks alone: slits are rounded as one
    midline                  d area left = -m l, d area right = m l
    contact                  d edge left = -k, d edge right = k     where the folds touch, by how it moves
    instants                 area(t + u), area(t + v)     on the rise and the fall: between two frames
    crest                    extremes times 1 + w (1 - cos(pi / frames a cycle))
    ends                     length / (1 - r / widest opening) of the glottis, pointed ends lose their outline
    noise                    of each frame: rounding, of an edge, and of the rows of an area one by one; of an
                             edge also alike in all cycles, which have a whole number of frames, or nearly

Ranges were chosen on films of `python -m benchmarks.video.coverage --chosen`, and judged on others.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from plica.measures.cycles import Cycles
from plica.measures.interval import coverage
from plica.video.glottis.glottal_area import GlottalArea

__all__ = ["AreaErrors", "Estimate", "draws"]

Floats = npt.NDArray[np.float64]

_ERRORS = (
    "slits",
    "slits hidden always",
    "outline",
    "outline closing",
    *(
        f"{side} {error}"
        for side in ("left", "right")
        for error in ("shade", "shade's phase", "border", "pixels")
    ),
    "midline",
    "contact",
    "opening",
    "closing",
    "crest",
    "ends",
    "noise",
)
_DRAWS = 100
_SEED = 20211

_ADDED = (-1.0, 0.5)  # of what slits added, where they are counted
_NOT_ADDED = (-0.5, 1.5)  # of the same, where shade between the folds leaves them out
_ALWAYS = (-0.1, 1.0)  # of what may be open besides; none below 0
_BORDER, _ALL_ALONG = 0.1, 0.4  # px, of the rows of an area, and of those of an edge, which agree
_STEPS = 0.4  # px
_CONTACT = (
    -1.5,
    1.5,
)  # of how far contact is off one that rests or moves: films go up to the ends and beyond
_MIDLINE = 0.4  # px, to which the midline is found (docs/verification/video.md, "Noise and blur")
_ROUNDED = 0.5  # px
_LEFT = (-0.5, 0.5)  # of what shade moves the outline halfway by: in the darkest part
_LEFT_UNLIT = (-0.5, 1.0)  # the same without a lamp to one side: the outline halfway may be the true one
_UNSEEN = (-1.5, 0.5)  # of the same, in the outline halfway, where left and right do not show it
_INSTANT = 0.35  # frames
_MARK = 0.15  # frames, to which a mark is known on their grid
_ENDS = 2.0  # px of opening, below which an end of the glottis may have no outline
_LOST = (-0.1, 1.0)  # of what such ends lose; a length may be drawn too long
_NOISE = 1 / np.sqrt(12)  # px, of a rounded edge
_LOUDER = 1.75  # of the noise, at most


@dataclass(frozen=True)
class Estimate:
    """What is measured, px and px^2.

    Attributes
    ----------
    outline : (frames)
        Area of the outline, which has the marks of the cycles and how they differ.
    total : (frames)
        Area with the slits that blur hides.
    timed : (frames)
        The same at the instants that tell quotients, which may lie between two frames.
    sides : GlottalArea
        Of either fold.
    length : float or None
        Of the glottis.
    """

    outline: Floats
    total: Floats
    timed: Floats
    sides: GlottalArea
    length: float | None


@dataclass(frozen=True)
class AreaErrors:
    """What an estimate is uncertain by.

    Attributes
    ----------
    added : (frames) px^2, or None
        What slits add to the area; None: not known, masks are exact.
    counted : bool
        Whether the estimate has it.
    of_sides : GlottalArea or None
        What slits added to either side; None: nothing.
    most : (frames) px^2, or None
        What may be open besides where the folds seem closed.
    band : two of (frames) px^2, or None
        Areas of the narrowest and the widest outline, where it is not sharp.
    shade : GlottalArea or None
        By how much more the outline halfway has than that of the darkest part; None: not known.
    darkest : bool
        Whether sides are those of the darkest part.
    lateral : bool
        Whether a lamp to one side is seen.
    """

    added: Floats | None = None
    counted: bool = True
    of_sides: GlottalArea | None = None
    most: Floats | None = None
    band: tuple[Floats, Floats] | None = None
    shade: GlottalArea | None = None
    darkest: bool = False
    lateral: bool = False


def draws(
    estimate: Estimate, errors: AreaErrors, cycles: Cycles, time: npt.NDArray[Any]
) -> Iterator[tuple[tuple[Estimate, Cycles], tuple[Estimate, Cycles], float]]:
    """Voices that may have been filmed; each with its cycles, the same with noise, and what its extremes are
    larger by than in the frames, as a share."""
    random = np.random.default_rng(_SEED)
    frames = float(np.median(cycles.periods)) / float(time[1] - time[0])
    crest = 1 - np.cos(np.pi / frames)
    for column in _hypercube(len(_ERRORS), random).T:
        place = dict(zip(_ERRORS, column.tolist(), strict=True))
        true = _with_errors(estimate, errors, place, frames)
        noisy = _with_noise(_with_steps(true, round(frames), random), place["noise"], random)
        marked = _marked(cycles, estimate.outline, true.outline, time)
        rounded = _marked(marked, true.outline, noisy.outline, time)
        grid = place["noise"] * random.uniform(-_MARK, _MARK, cycles.starts.size) * float(time[1] - time[0])
        yield (
            (true, marked),
            (noisy, replace(rounded, starts=rounded.starts + grid)),
            float(crest * place["crest"]),
        )


def _hypercube(count: int, random: np.random.Generator) -> Floats:
    """(count, draws) in 0 to 1: each row has one place in each of as many strata."""
    strata = random.permuted(np.tile(np.arange(_DRAWS), (count, 1)), axis=1)
    return (strata + random.random(strata.shape)) / _DRAWS


def _between(ends: tuple[float, float], place: float) -> float:
    """The place between the ends of which 95 % are within these."""
    middle, half = (ends[0] + ends[1]) / 2, (ends[1] - ends[0]) / 2 / coverage
    return float(middle + half * (2 * place - 1))


def _with_errors(
    estimate: Estimate, errors: AreaErrors, place: Mapping[str, float], frames: float
) -> Estimate:
    """The estimate with these errors, each by its place in its range."""
    sign = {name: 2 * part - 1 for name, part in place.items()}
    total, outline = estimate.total.copy(), estimate.outline.copy()
    parts = {name: part.copy() for name, part in estimate.sides.parts.items()}
    rises = np.gradient(estimate.outline) > 0
    opened, apart = _opened(estimate), np.clip(_width(estimate.sides), 0.0, 1.0)
    if errors.added is not None:
        total += _between(_ADDED if errors.counted else _NOT_ADDED, place["slits"]) * errors.added
    if errors.of_sides is not None:
        for name, part in errors.of_sides.parts.items():
            parts[name] += _between(_ADDED, place["slits"]) * part
    if errors.most is not None:
        total += max(_between(_ALWAYS, place["slits hidden always"]), 0.0) * errors.most
    if errors.band is not None:
        ways = sign["outline"], (sign["outline"] + sign["outline closing"]) / 2
        shaded = np.where(rises, *(abs(way) * (errors.band[int(way > 0)] - estimate.outline) for way in ways))
        total, outline = total + shaded, outline + shaded
    half = _width(estimate.sides) / 2
    for side, right in (("left", -1), ("right", 1)):
        if errors.shade is not None:
            left = _LEFT if errors.lateral else _LEFT_UNLIT
            share = _between(left if errors.darkest else _UNSEEN, place[f"{side} shade"])
            late = round(sign[f"{side} shade's phase"] * frames / 2)
            for name in (side, f"{side}_edge"):
                parts[name] += share * np.roll(errors.shade.parts[name], late)
        wider = np.full(opened.size, _BORDER * sign[f"{side} border"])
        if errors.added is None:
            wider += _ROUNDED * sign[f"{side} pixels"] / (1 + 4 * np.square(half))
        total, outline = total + wider * opened, outline + wider * opened
        parts[side] += (wider + right * _MIDLINE * sign["midline"]) * opened
        parts[f"{side}_edge"] += (wider + (_ALL_ALONG - _BORDER) * sign[f"{side} border"]) * apart
        if estimate.sides.contact is not None:
            parts[f"{side}_edge"] += right * _between(_CONTACT, place["contact"]) * estimate.sides.contact
    instants = _INSTANT * sign["opening"], _INSTANT * sign["closing"]
    total = np.maximum(total, 0.0)
    return Estimate(
        np.maximum(outline, 0.0),
        total,
        _warped(total, np.where(rises, *instants)),
        _area(parts),
        estimate.length if errors.added is None else _lengthened(estimate, place["ends"]),
    )


def _with_steps(estimate: Estimate, frames: int, random: np.random.Generator) -> Estimate:
    """With what rounding to pixels does to the edges in each frame of a cycle."""
    sides, apart = dict(estimate.sides.parts), np.clip(_width(estimate.sides), 0.0, 1.0)
    for side in ("left", "right"):
        cycle = random.uniform(-_STEPS, _STEPS, frames)
        sides[f"{side}_edge"] = sides[f"{side}_edge"] + np.resize(cycle, apart.size) * apart
    return replace(estimate, sides=_area(sides))


def _with_noise(estimate: Estimate, size: float, random: np.random.Generator) -> Estimate:
    """With what rounding to pixels adds to each frame, a share `size` of the most."""
    opened = _opened(estimate)
    sides = dict(estimate.sides.parts)
    rows = _NOISE * _LOUDER * size * np.sqrt(opened)  # px^2, of one side
    noise = np.zeros(opened.size)
    for side in ("left", "right"):
        of_side = rows * random.standard_normal(opened.size)
        noise += of_side
        sides[side] = sides[side] + of_side
        rounded = size * random.uniform(-_ROUNDED, _ROUNDED, opened.size)
        sides[f"{side}_edge"] = sides[f"{side}_edge"] + rounded * np.clip(_width(estimate.sides), 0.0, 1.0)
    return Estimate(
        np.maximum(estimate.outline + noise, 0.0),
        np.maximum(estimate.total + noise, 0.0),
        np.maximum(estimate.timed + noise, 0.0),
        _area(sides),
        estimate.length,
    )


def _area(parts: Mapping[str, Floats]) -> GlottalArea:
    return GlottalArea(parts["left"], parts["right"], parts["left_edge"], parts["right_edge"])


def _width(sides: GlottalArea) -> Floats:
    """(frames) px, over the middle tenth."""
    return np.asarray(sides.left_edge + sides.right_edge)


def _opened(estimate: Estimate) -> Floats:
    """(frames) px, over which the glottis is open, were its opening a parabola."""
    total, width = estimate.outline, np.maximum(_width(estimate.sides), 0.0)
    along = np.divide(1.5 * total, width, out=np.zeros(total.size), where=width > 0)
    reach = estimate.length or float(np.median(along[total > 0.5 * total.max()]))
    return np.where(total > 0, np.where(width > 0, np.minimum(along, reach), reach), 0.0)


def _lengthened(estimate: Estimate, place: float) -> float | None:
    """Either end of a parabola w wide and L long is below an opening of h over h L / (4 w)."""
    widest = float(_width(estimate.sides).max())
    if estimate.length is None or not widest > _ENDS:
        return estimate.length
    return estimate.length / (1 - _between(_LOST, place) * _ENDS / (2 * widest))


def _warped(total: Floats, later: Floats) -> Floats:
    """The area at instants by so many frames later."""
    from scipy import interpolate

    frames = np.arange(total.size, dtype=float)
    found = interpolate.PchipInterpolator(frames, total)(np.clip(frames + later, 0, total.size - 1))
    return np.asarray(np.maximum(found, 0.0))


def _marked(cycles: Cycles, before: Floats, after: Floats, time: npt.NDArray[Any]) -> Cycles:
    """With the marks as far as they move, to first order, where the area changes: by the change at the mark,
    less that of the level, over the slope."""
    if np.array_equal(before, after):
        return cycles
    parts = cycles.samples(time)
    level = np.array(
        [
            0.3 * (after[k].max() - before[k].max()) + 0.7 * (after[k].min() - before[k].min())
            for k in [*parts, parts[-1]]
        ]
    )
    slope = np.gradient(before, time)
    steep = np.interp(cycles.starts, time, slope)
    steep = np.maximum(steep, 0.1 * slope.max())
    change = np.interp(cycles.starts, time, after - before) - level
    most = 0.5 * float(time[1] - time[0])
    return replace(cycles, starts=cycles.starts - np.clip(change / steep, -most, most))
