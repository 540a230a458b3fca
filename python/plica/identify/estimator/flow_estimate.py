"""Tissue from computed optical flow: the flow's error is learned from the residuals of the model."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from plica.identify.estimator.estimate import estimate_and_evaluation
from plica.identify.estimator.posterior import Posterior
from plica.identify.estimator.robust_covariance import inflation
from plica.identify.estimator.scoring import Iteration, Scoring
from plica.identify.likelihood.evaluation import Evaluation
from plica.identify.likelihood.flow_error import FlowError
from plica.identify.likelihood.learned_error import learned
from plica.identify.likelihood.marginal import MarginalLikelihood

__all__ = ["estimate_from_flow"]

Array = NDArray[np.float64]

_FIRST_TOLERANCE = 0.5  # posterior sd, of the estimate that is only used for its residuals
_ROUNDS = 2  # updates of the error and the residuals at one tissue


def estimate_from_flow(
    likelihood: MarginalLikelihood,
    start: ArrayLike | None = None,
    options: Scoring | None = None,
    progress: Callable[[Iteration], None] | None = None,
    *,
    learn: bool = True,
    kept: Mapping[int, ArrayLike] | None = None,
) -> tuple[Posterior, MarginalLikelihood, Evaluation]:
    """`estimate` with a flow error that is learned from the residuals.

    The first estimate, to half an sd, assumes independent errors; its residuals give the size, correlation
    and outliers of the error, and gains of the points get their own level. The second estimate uses this
    error, the third one learned from the residuals of the second. Only the first estimate uses several
    starts: at a false maximum the misfit would be learned as an error of the flow. If the residuals still
    fail their test, the intervals are widened as the correlations of the residuals require
    (`Posterior.inflation`). Without `learn` the stated errors are used, and the intervals widened likewise.

    `kept` is as in `estimate`; number 0 is the last point of the second or third estimate.

    Returns
    -------
    posterior : Posterior
    likelihood : MarginalLikelihood
        With the learned flow error.
    evaluation : Evaluation
        The last evaluation.

    Raises
    ------
    InvalidInput, SolveFailed
        As `estimate`.
    """
    options = options or Scoring()
    count = [0]

    def report(at: Iteration) -> None:
        whole = at.share == 1
        if progress is not None:
            progress(replace(at, number=count[0]) if whole else at)
        count[0] += whole

    def report_later(at: Iteration) -> None:
        report(replace(at, start=0))

    rough = replace(options, tolerance=max(options.tolerance, _FIRST_TOLERANCE)) if learn else options
    found, at = estimate_and_evaluation(likelihood, start, rough, report, kept)
    first = found
    resumed = (kept or {}).get(0)
    for tolerance in (rough.tolerance, options.tolerance) if learn else ():
        for _ in range(_ROUNDS):
            likelihood = MarginalLikelihood(
                likelihood.model, likelihood.fixed_noise, flow_error=_learned(likelihood, at)
            )
            at = likelihood.evaluate_known(at.point, at.responses)
        begin = at.point if resumed is None else resumed
        once = replace(options, tolerance=tolerance, starts=1)
        found, at = estimate_and_evaluation(likelihood, begin, once, report_later)
        resumed = None
    found = replace(found, iterations=max(count[0] - 1, 0), starts=first.starts, ended_here=first.ended_here)
    if not found.residuals.passed:
        found = replace(found, inflation=inflation(likelihood, at))
    return found, likelihood, at


def _learned(likelihood: MarginalLikelihood, at: Evaluation) -> FlowError:
    """The learned error, scaled to the stated sd so that its common factor stays relative to that."""
    observation = likelihood.model.observation
    shape = observation.flow.shape
    seen = (observation.weights > 0).reshape(shape)
    motion = likelihood.motion(at).reshape(shape)
    left = (at.residual - likelihood.gain_part(at)).reshape(shape)
    error = learned(left, seen, motion, likelihood.model.image_positions)
    stated = float(np.sqrt(np.mean(np.asarray(observation.sd)[seen] ** 2)))
    return replace(error, sd=error.sd * stated / float(np.sqrt(np.mean(error.sd**2))))
