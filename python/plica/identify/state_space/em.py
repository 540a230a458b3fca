"""Expectation-maximisation of a linear Gaussian model (Paper D, Eqs. (19)-(27), corrected)."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from plica import _engine
from plica.errors import InvalidInput, SolveFailed
from plica.identify.state_space.kalman import kalman_filter
from plica.identify.state_space.linear_gaussian import LinearGaussian, PatternNoise
from plica.identify.state_space.moments import Moments, expected_moments

__all__ = ["EMResult", "Estimated", "append_log_likelihood", "check_limits", "em"]

Array = NDArray[np.float64]
Estimated = Literal["G", "Gamma_w", "Gamma_v"]
_ESTIMATED = ("G", "Gamma_w", "Gamma_v")
_ROUND_OFF = 1e-9  # relative: a smaller decrease of the log-likelihood is round-off


@dataclass(frozen=True, eq=False)
class EMResult:
    """What `em` returns.

    Attributes
    ----------
    model : LinearGaussian
        The model of the last entry of `log_likelihoods`.
    log_likelihoods : (i,)
        log p(y) of the initial model and after each iteration; it never decreases.
    converged : bool
        Whether its last increase was within the tolerance.
    """

    model: LinearGaussian
    log_likelihoods: Array
    converged: bool


def em(
    model: LinearGaussian,
    y: ArrayLike,
    f: ArrayLike | None = None,
    *,
    estimate: Collection[Estimated] = ("Gamma_w", "Gamma_v"),
    iterations: int = 100,
    tolerance: float = 1e-8,
) -> EMResult:
    """Noise covariances, and with "G" the whole evolution, that increase the likelihood of y.

    Parameters
    ----------
    model : LinearGaussian
        The initial model. H, m0 and P0 are kept: H is known, and from one record P0 would collapse.
    y : (N, p)
        NaN where a row or a frame is missing. Gamma_v is estimated from frames with at least one value.
    f : (N, n), optional
    estimate : collection of "G", "Gamma_w", "Gamma_v"
        A free G, as the thesis proposes: G = (S10 - sum f m') S00^-1. It is determined only up to a change
        of basis that H does not observe, so no tissue follows from it; see docs/identification_filter.md.
        Gamma_w of a `PatternNoise` keeps its patterns; a diagonal Gamma_v stays diagonal.
    iterations : int
        Maximum number, >= 1.
    tolerance : float
        Stops when the log-likelihood increases by less than this times its size, >= 0.

    Raises
    ------
    InvalidInput
        If y or f do not fit, or "G" is estimated with `PatternNoise` (states would have to stay on the
        patterns, which determines G up to them).
    SolveFailed
        If the log-likelihood decreases: the model is numerically out of range.
    """
    _check_em(model, estimate, iterations, tolerance)
    history: list[float] = []
    converged = False
    for _ in range(iterations + 1):
        filtered = kalman_filter(model, y, f)
        converged = append_log_likelihood("em", history, filtered.log_likelihood, tolerance)
        if converged or len(history) > iterations:
            break
        model = _maximised(model, expected_moments(model, filtered), filtered.input, estimate)
    return EMResult(model, np.array(history), converged)


def _check_em(model: LinearGaussian, estimate: Collection[str], iterations: int, tolerance: float) -> None:
    unknown = [name for name in estimate if name not in _ESTIMATED]
    if unknown or not estimate:
        raise InvalidInput(f"em: estimate = {list(estimate)}; must be names of {', '.join(_ESTIMATED)}.")
    if "G" in estimate and isinstance(model.process_noise, PatternNoise):
        raise InvalidInput(
            'em: estimate has "G" and the process noise is PatternNoise; must be a full Gamma_w. '
            "With pattern noise alone every G but the present one has likelihood zero."
        )
    check_limits("em", iterations, tolerance)


def check_limits(where: str, iterations: int, tolerance: float) -> None:
    """Raises InvalidInput for invalid iteration limits."""
    if iterations < 1:
        raise InvalidInput(f"{where}: iterations = {iterations}; must be >= 1.")
    if not tolerance >= 0:
        raise InvalidInput(f"{where}: tolerance = {tolerance:g}; must be >= 0.")


def append_log_likelihood(where: str, history: list[float], value: float, tolerance: float) -> bool:
    """Append a log-likelihood to the history; returns whether it has converged.

    Raises SolveFailed, prefixed by `where`, if it decreases, which EM cannot do.
    """
    if history and not value >= history[-1] - _ROUND_OFF * max(1.0, abs(value)):
        raise SolveFailed(
            f"{where}: iteration {len(history)}: the log-likelihood falls from {history[-1]:.9g} to "
            f"{value:.9g}; EM cannot lower it. The covariances have lost precision: is Gamma_w near zero?"
        )
    history.append(value)
    return len(history) > 1 and abs(value - history[-2]) <= tolerance * max(1.0, abs(value))


def _maximised(
    model: LinearGaussian, moments: Moments, f: Array | None, estimate: Collection[str]
) -> LinearGaussian:
    """The M step."""
    frames = len(moments.later)
    if "Gamma_v" in estimate:
        model = replace(model, Gamma_v=_observation_noise(model, moments))
    if "G" in estimate:
        target = moments.later if f is None else moments.later - f
        S10 = moments.C10 + target.T @ moments.earlier
        S00 = moments.C00 + moments.earlier.T @ moments.earlier
        model = replace(model, G=_right_divided(S10, S00))
        if "Gamma_w" in estimate:
            model = replace(model, process_noise=moments.transition_residual(model.G, f) / frames)
    elif "Gamma_w" in estimate:
        noise = model.process_noise
        covariance = moments.noise / frames
        model = replace(
            model,
            process_noise=(
                PatternNoise(noise.patterns, covariance) if isinstance(noise, PatternNoise) else covariance
            ),
        )
    return model


def _observation_noise(model: LinearGaussian, moments: Moments) -> Array:
    if model.Gamma_v.ndim == 1:  # a row that is never seen keeps its variance
        seen = np.maximum(moments.seen, 1)
        return np.where(moments.seen > 0, moments.residual / seen, model.Gamma_v)
    out: Array = moments.residual / moments.seen[0]
    return out


def _right_divided(S10: Array, S00: Array) -> Array:
    """S10 S00^-1."""
    try:
        R = _engine.cholesky(S00)
    except SolveFailed as error:
        raise SolveFailed(
            f"em: S00 is singular ({error}) A state never moves, so its column of G cannot be estimated."
        ) from None
    X = S10.T.copy()
    _engine.solve_lower(R, X)
    _engine.solve_upper(R, X)
    return np.ascontiguousarray(X.T)
