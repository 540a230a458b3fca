"""Where an estimate begins: where it is told to, then, should that end at a false maximum, elsewhere.

False maxima come from cycles that are skipped: over a long recording a tissue of another eigenfrequency can
keep step with a wrong cycle of the motion. The first frames hold too few cycles for that. A graduated start
therefore climbs on the first quarter of what is seen, goes on from there on the first half, and ends where
the whole recording is begun (for seismograms: C. Bunks et al., Geophysics 60, 1995, there by frequency).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy import special
from scipy.stats import qmc

from plica.errors import InvalidInput
from plica.identify.likelihood import MarginalLikelihood
from plica.identify.scoring import NOT_THERE, Scoring, climb
from plica.identify.settings import MOST_STARTS

__all__ = ["begins", "graduated"]

Array = NDArray[np.float64]
_SHARES = (0.25, 0.5)
"""Of the frames that show something."""
_ROUGH = 0.5
"""[posterior sd] to which the climbs on a part of the recording go."""
_SCANNED = MOST_STARTS - 2
"""Tissues of the prior whose densities on the first quarter are compared."""


def begins(likelihood: MarginalLikelihood, first: Array, options: Scoring) -> Iterator[Array]:
    """(p) each: `first`; the graduated start from it; the graduated starts from tissues that are spread over
    the prior, the most probable on the first quarter of the recording before the others."""
    yield first
    yield graduated(likelihood, first, options)
    for point in _scanned(likelihood):
        yield graduated(likelihood, point, options)


def graduated(likelihood: MarginalLikelihood, start: Array, options: Scoring) -> Array:
    """(p) The end of climbs on the first quarter and the first half; `start` where neither has one."""
    rough = replace(options, tolerance=max(options.tolerance, _ROUGH))
    for share in _SHARES:
        try:
            start = climb(likelihood.of_first(_frames(likelihood, share)), start, rough).mean
        except NOT_THERE:
            continue  # too short to tell all parameters, or without an end: the next one is longer
    return start


def _scanned(likelihood: MarginalLikelihood) -> list[Array]:
    """(p) each, the most probable first; without those that would store no energy. None where the first
    quarter is too short or shows no motion."""
    try:
        quarter = likelihood.of_first(_frames(likelihood, _SHARES[0]))
    except InvalidInput:
        return []
    mean, sd = likelihood.prior_mean, likelihood.prior_sd
    places = qmc.Halton(len(mean), scramble=False).random(_SCANNED + 1)[1:]  # the first is a corner
    found: list[tuple[float, Array]] = []
    for place in places:
        point = mean + sd * math.sqrt(2) * special.erfinv(2 * place - 1)
        try:
            found.append((quarter.value(point) + quarter.log_prior(point), point))
        except NOT_THERE:
            continue
    return [point for _, point in sorted(found, key=lambda one: -one[0])]


def _frames(likelihood: MarginalLikelihood, share: float) -> int:
    """The first frames that hold this share of those that show something."""
    seen = np.flatnonzero(likelihood.inputs.weights.any(axis=1))
    return int(seen[math.ceil(share * len(seen)) - 1]) + 1
