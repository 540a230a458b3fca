"""Fisher scoring: from one start to a maximum of the posterior density, with a Gaussian approximation."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from plica.errors import InvalidInput, SolveFailed
from plica.identify.estimator.posterior import Posterior, standard_deviations
from plica.identify.likelihood.likelihood import (
    UNDEFINED_DENSITY,
    EvaluatedT,
    Likelihood,
    log_prior,
    require_shapes,
)
from plica.identify.settings import MOST_STARTS

__all__ = ["Iteration", "Scoring", "climb"]

Array = NDArray[np.float64]
NEAR = 2.0
"""[posterior sd] Once a step is shorter than this, the curvature is the information at that point with BFGS
updates from the gradients: if the model does not hold, the curvature differs from the information, and plain
scoring would oscillate about the maximum."""

LARGEST_BOOST = 64.0
"""Largest factor on a scoring step. Far from the maximum the unknown pressures are estimated as large, and
the information, which is that of large pressures, is then too large. Scoring steps that gain more than
predicted are lengthened."""


@dataclass(frozen=True)
class Scoring:
    """Options of Fisher scoring."""

    max_iterations: int = 40
    """>= 1"""
    tolerance: float = 0.05
    """[posterior sd] > 0; stops when a step is shorter than this."""
    longest_step: float = 1.0
    """[-] > 0; largest change of a log parameter in one iteration."""
    max_halvings: int = 12
    """>= 1; of a step that does not increase the posterior density."""
    starts: int = 3
    """>= 1; largest number of starts, used while the residuals fail their test and no two ends agree"""

    def __post_init__(self) -> None:
        for name in ("max_iterations", "tolerance", "longest_step", "max_halvings", "starts"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0):
                raise InvalidInput(f"Scoring: {name} = {value:g}; must be > 0.")
            if name in ("max_iterations", "max_halvings", "starts") and value != int(value):
                raise InvalidInput(f"Scoring: {name} = {value:g}; must be a whole number.")
        if self.starts > MOST_STARTS:
            raise InvalidInput(
                f"Scoring: starts = {self.starts}; must be at most {MOST_STARTS}, all there are."
            )


@dataclass(frozen=True)
class Iteration:
    """One accepted point, as passed to progress callbacks."""

    number: int
    value: float
    """log posterior density, up to a constant"""
    point: Array
    step: float
    """[posterior sd] length of the proposed step; nan for a prior sample that is only compared with others"""
    start: int = 1
    """Start number; 0: an estimate with the flow error learned after the starts"""
    share: float = 1.0
    """Share of the frames with data that is used; less than 1 on the way to a graduated start"""


def climb(
    likelihood: Likelihood[EvaluatedT],
    start: Array,
    options: Scoring,
    progress: Callable[[Iteration], None] | None = None,
) -> tuple[Posterior, EvaluatedT]:
    """The maximum reached uphill from `start` (p), with the Gaussian approximation there, and the last
    evaluation.

    Each step solves (I + P) dx = g, I the Fisher information, P the prior's precision, g the gradient of
    the log posterior; near the end I is corrected by the changes of the gradient. A step is halved until the
    density increases. The last, short step is taken if it increases the density. Raises as `estimate`.
    """
    x = np.array(start, dtype=float)
    require_shapes(likelihood, x)
    precision = np.diag(1 / likelihood.prior_sd**2)
    now = likelihood.evaluate(x)
    require_shapes(likelihood, x, now)
    _require_dependence(likelihood, now)
    value = now.value + log_prior(likelihood, x)
    curvature: Array | None = None
    boost = 1.0
    for number in range(options.max_iterations):
        gradient = now.gradient - precision @ (x - likelihood.prior_mean)
        information = now.information + precision
        step = np.asarray(np.linalg.solve(information, gradient), dtype=np.float64)
        length = _length(step, information)
        plain = curvature is None
        if curvature is not None:
            step = np.asarray(np.linalg.solve(curvature, gradient), dtype=np.float64)
            length = _length(step, information)
        elif length < NEAR:
            curvature = information
        if progress is not None:
            progress(Iteration(number, value, x, length))
        if length < options.tolerance:
            _require_definite(information, number)
            return _posterior(likelihood, now, value, step, number), now
        if plain:
            step *= boost
        longest = float(np.abs(step[likelihood.logarithmic]).max(initial=0.0))
        if longest > options.longest_step:
            step *= options.longest_step / longest
        predicted = float(step @ gradient)
        found = _line_search(likelihood, x, step, value, predicted, options)
        if isinstance(found, str):
            raise SolveFailed(
                f"estimate: iteration {number}: no step of {length:.3g} sd increased the posterior density. "
                f"{found or 'Is the start far from the data, or the tolerance of the model too large?'}"
            )
        gain = (found[2] - value) / predicted  # 1/2 if the information is the curvature
        boost = min(2 * boost, LARGEST_BOOST) if gain > 0.6 else max(1.0, boost / 2)
        moved = found[0] - x
        x, now, value = found
        if curvature is not None:
            change = gradient - (now.gradient - precision @ (x - likelihood.prior_mean))
            curvature = _updated(curvature, moved, change)
    raise SolveFailed(
        f"estimate: step after {options.max_iterations} iterations = {length:.3g} posterior sd; must be < "
        f"{options.tolerance:g}. Start nearer to the maximum, or increase max_iterations."
    )


def _length(step: Array, information: Array) -> float:
    """[posterior sd]; infinite if the information is negative along the step."""
    square = float(step @ information @ step)
    return math.sqrt(square) if square >= 0 else math.inf


def _require_definite(information: Array, number: int) -> None:
    """Raises SolveFailed if the information at the end of an estimate is not positive definite."""
    try:
        np.linalg.cholesky(information)
    except np.linalg.LinAlgError:
        raise SolveFailed(
            f"estimate: iteration {number}: the information is not positive definite; must be at the end "
            "of an estimate. Start elsewhere, or leave out a parameter that the data do not determine."
        ) from None


def _posterior(
    likelihood: Likelihood[EvaluatedT], now: EvaluatedT, value: float, step: Array, iterations: int
) -> Posterior:
    """The posterior after the last step from a point of log density `value`, or at that point if the density
    decreases."""

    def density(x: Array) -> float:
        try:
            return likelihood.value(x) + log_prior(likelihood, x)
        except UNDEFINED_DENSITY:
            return -math.inf

    reached = density(now.point + step)
    rises = reached >= value
    found = Posterior(
        names=likelihood.names,
        units=likelihood.units,
        mean=now.point + step if rises else now.point,
        information=now.information,
        prior_mean=likelihood.prior_mean,
        prior_sd=likelihood.prior_sd,
        noise=now.noise,
        log_likelihood=now.value,
        iterations=iterations,
        residuals=likelihood.residual_test(now),
        logarithmic=likelihood.logarithmic,
    )
    half = standard_deviations() * found.least_known
    ends = np.array([density(found.mean - half), density(found.mean + half)])
    return replace(found, falls=max(reached, value) - ends)


def _updated(curvature: Array, step: Array, change: Array) -> Array | None:
    """BFGS update so that the curvature maps step to change; None if the density is not concave there."""
    image = curvature @ step
    if step @ change <= 1e-2 * (step @ image):
        return None
    updated: Array = (
        curvature - np.outer(image, image) / (step @ image) + np.outer(change, change) / (step @ change)
    )
    return updated


def _line_search(
    likelihood: Likelihood[EvaluatedT], x: Array, step: Array, value: float, slope: float, options: Scoring
) -> tuple[Array, EvaluatedT, float] | str:
    """The first of step, step / 2, ... that increases the density by 1e-4 of what the slope predicts.

    A step to an undefined density (`UNDEFINED_DENSITY`) is too long. If no step is short enough, returns the
    message of the last failure, or an empty string.
    """
    share, last = 1.0, ""
    for _ in range(options.max_halvings):
        candidate = x + share * step
        try:
            there = likelihood.evaluate(candidate)
        except UNDEFINED_DENSITY as error:
            share, last = share / 2, f"The last point that could not be evaluated: {error}"
            continue
        reached = there.value + log_prior(likelihood, candidate)
        if reached >= value + 1e-4 * share * slope:
            return candidate, there, reached
        share /= 2
    return last


def _require_dependence(likelihood: Likelihood[EvaluatedT], at: EvaluatedT) -> None:
    shares = np.diag(at.information) * likelihood.prior_sd**2
    for name, share in zip(likelihood.names, shares, strict=True):
        if not share > 1e-10:
            raise InvalidInput(
                f'estimate: the data do not depend on "{name}": its information is '
                f"{max(share, 0.0):.2g} of the prior's. Leave it out, or observe the tissue it affects."
            )
