"""Where an estimate begins: where it is told to, then, should that end at a false maximum, elsewhere.

False maxima come from cycles that are skipped: over a long recording a tissue of another eigenfrequency can
keep step with a wrong cycle of the motion. The first frames hold too few cycles for that. A graduated start
therefore climbs on the first quarter of what is seen, goes on from there on the first half, and ends where
the whole recording is begun (for seismograms: C. Bunks et al., Geophysics 60, 1995, there by frequency).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy import special
from scipy.stats import qmc

from plica.errors import InvalidInput
from plica.identify.likelihood import MarginalLikelihood
from plica.identify.scoring import NOT_THERE, Iteration, Scoring, climb
from plica.identify.settings import MOST_STARTS

__all__ = ["Watcher", "begins", "graduated", "numbered"]

Array = NDArray[np.float64]
Watcher = Callable[[Iteration], None]
_SHARES = (0.25, 0.5)
"""Of the frames that show something."""
_ROUGH = 0.5
"""[posterior sd] to which the climbs on a part of the recording go."""
_SCANNED = MOST_STARTS - 2
"""Tissues of the prior whose densities on the first quarter are compared."""


def begins(
    likelihood: MarginalLikelihood,
    first: Array,
    options: Scoring,
    progress: Watcher | None = None,
    kept: Mapping[int, Array] | None = None,
) -> Iterator[Array]:
    """(p) each: `first`; the graduated start from it; the graduated starts from tissues that are spread over
    the prior, the most probable on the first quarter of the recording before the others.

    progress: called with each point on the way to a graduated start.
    kept: by their numbers, points at which starts that were begun before go on.
    """
    kept = kept or {}
    yield kept.get(1, first)
    yield kept[2] if 2 in kept else graduated(likelihood, first, options, numbered(progress, 2))
    fresh = 3
    while fresh in kept:
        yield kept[fresh]
        fresh += 1
    others = _scanned(likelihood, numbered(progress, fresh))[fresh - 3 :]
    for number, point in enumerate(others, start=fresh):
        yield graduated(likelihood, point, options, numbered(progress, number))


def numbered(progress: Watcher | None, start: int, share: float = 1.0) -> Watcher | None:
    """Who watches all starts, told of one of them, or of a part of the recording in it."""
    if progress is None:
        return None
    watcher = progress
    return lambda at: watcher(replace(at, start=max(start, at.start), share=min(share, at.share)))


def graduated(
    likelihood: MarginalLikelihood, start: Array, options: Scoring, progress: Watcher | None = None
) -> Array:
    """(p) The end of climbs on the first quarter and the first half; `start` where neither has one."""
    rough = replace(options, tolerance=max(options.tolerance, _ROUGH))
    for share in _SHARES:
        try:
            short = likelihood.of_first(_frames(likelihood, share))
            start = climb(short, start, rough, numbered(progress, 1, share)).mean
        except NOT_THERE:
            continue  # too short to tell all parameters, or without an end: the next one is longer
    return start


def _scanned(likelihood: MarginalLikelihood, progress: Watcher | None) -> list[Array]:
    """(p) each, the most probable first; without those that would store no energy. None where the first
    quarter is too short or shows no motion."""
    share = _SHARES[0]
    try:
        quarter = likelihood.of_first(_frames(likelihood, share))
    except InvalidInput:
        return []
    mean, sd = likelihood.prior_mean, likelihood.prior_sd
    places = qmc.Halton(len(mean), scramble=False).random(_SCANNED + 1)[1:]  # the first is a corner
    found: list[tuple[float, Array]] = []
    for number, place in enumerate(places):
        point = mean + sd * math.sqrt(2) * special.erfinv(2 * place - 1)
        try:
            density = quarter.value(point) + quarter.log_prior(point)
        except NOT_THERE:
            continue
        found.append((density, point))
        if progress is not None:
            progress(Iteration(number, density, point, math.nan, share=share))
    return [point for _, point in sorted(found, key=lambda one: -one[0])]


def _frames(likelihood: MarginalLikelihood, share: float) -> int:
    """The first frames that hold this share of those that show something."""
    seen = np.flatnonzero(likelihood.inputs.weights.any(axis=1))
    return int(seen[math.ceil(share * len(seen)) - 1]) + 1
