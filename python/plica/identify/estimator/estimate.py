"""Maximum a posteriori estimate of the coordinates of a likelihood."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from itertools import islice

import numpy as np
from numpy.typing import ArrayLike, NDArray

from plica.errors import SolveFailed
from plica.identify.estimator.posterior import Posterior
from plica.identify.estimator.scoring import Scoring, climb
from plica.identify.estimator.starts import ProgressCallback, start_points, with_start_number
from plica.identify.likelihood.likelihood import UNDEFINED_DENSITY, EvaluatedT, Likelihood, log_prior

__all__ = ["estimate", "estimate_and_evaluation"]

Array = NDArray[np.float64]
_SAME_MAXIMUM = 1.0  # posterior sd between end points that count as one maximum


def estimate(
    likelihood: Likelihood[EvaluatedT],
    start: ArrayLike | None = None,
    options: Scoring | None = None,
    progress: ProgressCallback | None = None,
    kept: Mapping[int, ArrayLike] | None = None,
) -> Posterior:
    """The maximum of the posterior density, with the Gaussian approximation there.

    Fisher scoring (`scoring.climb`) runs from `start`. If it does not converge, or the residuals at its end
    fail their test, as they do at a false maximum, it runs from other starting points
    (`starts.start_points`), until the residuals pass at one end or two runs end at the highest density found
    so far, with at most `options.starts` runs. The end of the highest density is
    returned; the posterior holds how many runs ended there.

    Parameters
    ----------
    likelihood : Likelihood
        `MarginalLikelihood`, or any other object with these methods.
    start : (p), optional
        Initial coordinates; default: the prior mean.
    options : Scoring, optional
    progress : callable, optional
        Called with each `Iteration`, including those that lead to a graduated start.
    kept : mapping, optional
        To resume an interrupted estimate: for each start number, its last point on the whole recording.

    Raises
    ------
    InvalidInput
        If arrays of the likelihood do not fit its names, or if, at the first start, the data do not depend
        on a parameter, which is named.
    SolveFailed
        If no run converged; the message is that of the first.
    """
    return estimate_and_evaluation(likelihood, start, options, progress, kept)[0]


def estimate_and_evaluation(
    likelihood: Likelihood[EvaluatedT],
    start: ArrayLike | None = None,
    options: Scoring | None = None,
    progress: ProgressCallback | None = None,
    kept: Mapping[int, ArrayLike] | None = None,
) -> tuple[Posterior, EvaluatedT]:
    """`estimate`, with the last evaluation of the run whose end is returned."""
    options = options or Scoring()
    first = likelihood.prior_mean if start is None else np.array(start, dtype=float)
    ends: list[tuple[Posterior, EvaluatedT]] = []
    failure: Exception | None = None
    tried = 0
    resumed = {number: np.array(point, dtype=float) for number, point in (kept or {}).items()}
    starts = start_points(likelihood, first, options, progress, resumed)
    for tried, point in enumerate(islice(starts, options.starts), start=1):
        try:
            found, at = climb(likelihood, point, options, with_start_number(progress, tried))
        except UNDEFINED_DENSITY as error:
            if tried == 1 and not isinstance(error, SolveFailed):
                raise
            failure = failure or error
            continue
        ends.append((found, at))
        if found.residuals.passed or _best_end(likelihood, ends)[1] > 1:
            break
    if not ends:
        assert failure is not None
        raise failure
    (best, at), here = _best_end(likelihood, ends)
    return replace(best, starts=tried, ended_here=here), at


def _best_end(
    likelihood: Likelihood[EvaluatedT], ends: list[tuple[Posterior, EvaluatedT]]
) -> tuple[tuple[Posterior, EvaluatedT], int]:
    """The end point of the highest density, and how many end points are within one sd of it."""
    best = max(ends, key=lambda end: end[0].log_likelihood + log_prior(likelihood, end[1].point))
    precision = np.linalg.inv(best[0].statistical_covariance)
    differences = [found.mean - best[0].mean for found, _ in ends]
    return best, sum(float(d @ precision @ d) < _SAME_MAXIMUM**2 for d in differences)
