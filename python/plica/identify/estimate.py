"""The tissue that makes a recording most probable, and how well it is known."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from itertools import islice

import numpy as np
from numpy.typing import ArrayLike, NDArray

from plica.errors import SolveFailed
from plica.identify.evaluation import Evaluation
from plica.identify.likelihood import MarginalLikelihood
from plica.identify.posterior import Posterior
from plica.identify.scoring import NOT_THERE, Scoring, climb
from plica.identify.starts import Watcher, begins, numbered

__all__ = ["estimate"]

Array = NDArray[np.float64]
_SAME = 1.0  # posterior sd between ends that are one


def estimate(
    likelihood: MarginalLikelihood,
    start: ArrayLike | None = None,
    options: Scoring | None = None,
    progress: Watcher | None = None,
    kept: Mapping[int, ArrayLike] | None = None,
) -> Posterior:
    """The maximum of the posterior density of log theta, with the Gaussian that fits it there.

    Fisher scoring (`plica.identify.scoring.climb`) goes uphill from `start`. Where that does not end, or the
    residuals at its end fail their test, which a false maximum's do, it is tried from other starts
    (`plica.identify.starts.begins`), until one ends where they pass or two end where the density is highest
    so far, at most `options.starts` in all. Of the ends, that of the highest density is taken; how many
    starts ended there is in the posterior.

    Parameters
    ----------
    likelihood : MarginalLikelihood
    start : (p), optional
        log theta; left out: the prior's mean.
    options : Scoring, optional
    progress : callable, optional
        Called with each `Iteration`, those on the way to a graduated start among them.
    kept : mapping, optional
        By its number, the last point on the whole recording of each start of an estimate that was stopped:
        they go on from there.

    Raises
    ------
    InvalidInput
        Where, at the first start, nothing in the data depends on a parameter, which is named.
    SolveFailed
        Where no start's iteration has converged; what the first says.
    """
    options = options or Scoring()
    first = likelihood.prior_mean if start is None else np.array(start, dtype=float)
    ends: list[tuple[Posterior, Evaluation]] = []
    failure: Exception | None = None
    tried = 0
    there = {number: np.array(point, dtype=float) for number, point in (kept or {}).items()}
    starts = begins(likelihood, first, options, progress, there)
    for tried, begin in enumerate(islice(starts, options.starts), start=1):
        try:
            found = climb(likelihood, begin, options, numbered(progress, tried))
        except NOT_THERE as error:
            if tried == 1 and not isinstance(error, SolveFailed):
                raise
            failure = failure or error
            continue
        ends.append((found, likelihood.last()))
        if found.residuals.passed or _at_the_best(likelihood, ends)[1] > 1:
            break
    if not ends:
        assert failure is not None
        raise failure
    (best, at), here = _at_the_best(likelihood, ends)
    likelihood.evaluate_known(at.point, at.responses)
    return replace(best, starts=tried, ended_here=here)


def _at_the_best(
    likelihood: MarginalLikelihood, ends: list[tuple[Posterior, Evaluation]]
) -> tuple[tuple[Posterior, Evaluation], int]:
    """The end of the highest density, and how many ends are within an sd of it."""
    best = max(ends, key=lambda end: end[0].log_likelihood + likelihood.log_prior(end[1].point))
    precision = np.linalg.inv(best[0].statistical_covariance)
    apart = [found.mean - best[0].mean for found, _ in ends]
    return best, sum(float(d @ precision @ d) < _SAME**2 for d in apart)
