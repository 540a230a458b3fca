"""Tissue from flow that was found in pictures: the flow's error is learned from what the model leaves."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from plica.identify.estimate import estimate
from plica.identify.evaluation import Evaluation
from plica.identify.flow_error import FlowError
from plica.identify.learned_error import learned
from plica.identify.likelihood import MarginalLikelihood
from plica.identify.posterior import Posterior
from plica.identify.residuals import image_positions
from plica.identify.robust_covariance import inflation
from plica.identify.scoring import Iteration, Scoring

__all__ = ["estimate_from_flow"]

Array = NDArray[np.float64]

_FIRST = 0.5  # posterior sd, of the estimate whose residuals are only looked at
_ROUNDS = 2  # in which error and residuals are renewed at one tissue


def estimate_from_flow(
    likelihood: MarginalLikelihood,
    start: ArrayLike | None = None,
    options: Scoring | None = None,
    progress: Callable[[Iteration], None] | None = None,
    *,
    learn: bool = True,
    kept: Mapping[int, ArrayLike] | None = None,
) -> tuple[Posterior, MarginalLikelihood, Evaluation]:
    """`estimate` with an error of the flow that is learned from the residuals.

    The first estimate, to half an sd, takes the errors for independent; from what it leaves, size,
    correlation and outliers of the error are told, and gains of the points are given their own level. The
    second estimate stands on that, the third on what the second leaves. Other starts are those of the first:
    at a false maximum the misfit would be learned as an error of the flow. If the residuals fail their test
    after all, the intervals are as wide as their own correlations ask for (`Posterior.inflation`). Without
    `learn` the observation's errors are taken as they are stated, and the intervals widened alike.

    `kept` is that of `estimate`; at number 0 the last point of the second or third estimate.

    Returns
    -------
    posterior : Posterior
    likelihood : MarginalLikelihood
        With the flow's error.
    evaluation : Evaluation
        The last one.

    Raises
    ------
    InvalidInput, SolveFailed
        As `estimate`.
    """
    options = options or Scoring()
    count = [0]

    def watched(at: Iteration) -> None:
        whole = at.share == 1
        if progress is not None:
            progress(replace(at, number=count[0]) if whole else at)
        count[0] += whole

    def after(at: Iteration) -> None:
        watched(replace(at, start=0))

    rough = replace(options, tolerance=max(options.tolerance, _FIRST)) if learn else options
    first = found = estimate(likelihood, start, rough, watched, kept)
    at = likelihood.last()
    later = (kept or {}).get(0)
    for tolerance in (rough.tolerance, options.tolerance) if learn else ():
        for _ in range(_ROUNDS):
            likelihood = MarginalLikelihood(
                likelihood.model, likelihood.fixed_noise, flow_error=_learned(likelihood, at)
            )
            at = likelihood.evaluate_known(at.point, at.responses)
        begin = at.point if later is None else later
        found = estimate(likelihood, begin, replace(options, tolerance=tolerance, starts=1), after)
        at, later = likelihood.last(), None
    found = replace(found, iterations=max(count[0] - 1, 0), starts=first.starts, ended_here=first.ended_here)
    if not found.residuals.passed:
        found = replace(found, inflation=inflation(likelihood, at))
    return found, likelihood, at


def _learned(likelihood: MarginalLikelihood, at: Evaluation) -> FlowError:
    """On the scale of the stated sd, so that their common factor remains that on what was stated."""
    observation = likelihood.model.observation
    shape = observation.flow.shape
    seen = (observation.weights > 0).reshape(shape)
    motion = likelihood.motion(at).reshape(shape)
    left = (at.residual - likelihood.gain_part(at)).reshape(shape)
    error = learned(left, seen, motion, image_positions(likelihood))
    stated = float(np.sqrt(np.mean(np.asarray(observation.sd)[seen] ** 2)))
    return replace(error, sd=error.sd * stated / float(np.sqrt(np.mean(error.sd**2))))
