"""Starting points of an estimate: the given one, then others in case that ends at a false maximum.

False maxima are due to cycle skipping: over a long recording a tissue of another eigenfrequency can match a
wrong cycle of the motion. The first frames contain too few cycles for that. A graduated start therefore
climbs on the first quarter of the frames with data, then on the first half, and the result is the starting
point for the whole recording (for seismograms, by frequency: C. Bunks et al., Geophysics 60, 1995).
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
from plica.identify.estimator.scoring import Iteration, Scoring, climb
from plica.identify.likelihood.likelihood import UNDEFINED_DENSITY, EvaluatedT, Likelihood, log_prior
from plica.identify.settings import MOST_STARTS

__all__ = ["ProgressCallback", "graduated", "start_points", "with_start_number"]

Array = NDArray[np.float64]
ProgressCallback = Callable[[Iteration], None]
_SHARES = (0.25, 0.5)
"""Of the frames with data."""
_ROUGH = 0.5
"""[posterior sd] Tolerance of the climbs on a part of the recording."""
_SAMPLES = MOST_STARTS - 2
"""Number of prior samples whose densities on the first quarter are compared."""


def start_points(
    likelihood: Likelihood[EvaluatedT],
    first: Array,
    options: Scoring,
    progress: ProgressCallback | None = None,
    kept: Mapping[int, Array] | None = None,
) -> Iterator[Array]:
    """(p) each: `first`; the graduated start from it; the graduated starts from samples of the prior, in the
    order of their density on the first quarter of the recording.

    progress: called with each point on the way to a graduated start.
    kept: for each start number of an interrupted estimate, the point from which it is resumed.
    """
    kept = kept or {}
    yield kept.get(1, first)
    yield kept[2] if 2 in kept else graduated(likelihood, first, options, with_start_number(progress, 2))
    fresh = 3
    while fresh in kept:
        yield kept[fresh]
        fresh += 1
    others = _ranked_prior_samples(likelihood, with_start_number(progress, fresh))[fresh - 3 :]
    for number, point in enumerate(others, start=fresh):
        yield graduated(likelihood, point, options, with_start_number(progress, number))


def with_start_number(
    progress: ProgressCallback | None, start: int, share: float = 1.0
) -> ProgressCallback | None:
    """A progress callback that adds the number of a start, and the share of the recording that it uses."""
    if progress is None:
        return None
    callback = progress
    return lambda at: callback(replace(at, start=max(start, at.start), share=min(share, at.share)))


def graduated(
    likelihood: Likelihood[EvaluatedT],
    start: Array,
    options: Scoring,
    progress: ProgressCallback | None = None,
) -> Array:
    """(p) The end of climbs on the first quarter and the first half; `start` if neither converges."""
    rough = replace(options, tolerance=max(options.tolerance, _ROUGH))
    for share in _SHARES:
        try:
            short = likelihood.of_first(share)
            start = climb(short, start, rough, with_start_number(progress, 1, share))[0].mean
        except UNDEFINED_DENSITY:
            continue  # too short for all parameters, or not converged: the next one is longer
    return start


def _ranked_prior_samples(
    likelihood: Likelihood[EvaluatedT], progress: ProgressCallback | None
) -> list[Array]:
    """Prior samples (p), the most probable first, without those of undefined density. Empty if the first
    quarter is too short or shows no motion."""
    share = _SHARES[0]
    try:
        quarter = likelihood.of_first(share)
    except InvalidInput:
        return []
    mean, sd = likelihood.prior_mean, likelihood.prior_sd
    places = qmc.Halton(len(mean), scramble=False).random(_SAMPLES + 1)[1:]  # the first is a corner
    found: list[tuple[float, Array]] = []
    for number, place in enumerate(places):
        point = mean + sd * math.sqrt(2) * special.erfinv(2 * place - 1)
        try:
            density = quarter.value(point) + log_prior(quarter, point)
        except UNDEFINED_DENSITY:
            continue
        found.append((density, point))
        if progress is not None:
            progress(Iteration(number, density, point, math.nan, share=share))
    return [point for _, point in sorted(found, key=lambda one: -one[0])]
