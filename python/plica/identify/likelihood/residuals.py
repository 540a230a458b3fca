"""Test of the residuals: independent and of equal variance if the model holds."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from plica.errors import InvalidInput
from plica.identify.likelihood.input_space import InputSpace, Solved

__all__ = ["ResidualTest", "innovations", "residual_test"]

Array = NDArray[np.float64]
LIMIT = 3.3
"""Standard score beyond which a test fails: once in a thousand if the model holds."""
_LARGEST_VARIANCE = 10.0
"""Largest variance of an innovation, relative to that with a known initial state. One with a larger variance
determines the initial state and tests nothing."""


@dataclass(frozen=True)
class ResidualTest:
    """Scores of the whitened residuals, each standard normal if the model holds."""

    count: int
    """Number of residuals."""
    in_time: float
    """Score of the product of residuals of one row in consecutive frames."""
    in_space: float
    """Score of the product of residuals of neighbouring points in one frame."""
    tails: float
    """Score of the fourth moment."""
    level: float
    """Score of the second moment in the second half against that in the first."""
    correlation_in_time: float
    """[-] Correlation between consecutive frames, in [-1, 1]."""
    correlation_in_space: float
    """[-] Correlation between neighbouring points, in [-1, 1]."""
    consecutive: int = 1
    """Number of products of consecutive frames; without one, correlation in time is not tested."""

    @property
    def passed(self) -> bool:
        """Whether no score is beyond 3.3, and correlation in time was tested."""
        return self.consecutive > 0 and all(
            abs(s) <= LIMIT for s in (self.in_time, self.in_space, self.tails, self.level)
        )

    def sentences(self) -> list[str]:
        """A warning for each score that failed."""
        warnings = []
        if not self.consecutive:
            warnings.append(
                "No two consecutive frames are observed: whether residuals are correlated in time, as those "
                "of a wrong model are, was not tested."
            )
        if abs(self.in_time) > LIMIT:
            warnings.append(
                f"The residuals of consecutive frames are correlated ({self.correlation_in_time:+.2f}, score "
                f"{self.in_time:+.1f}): the model does not follow a part of the motion."
            )
        if abs(self.in_space) > LIMIT:
            warnings.append(
                f"The residuals of neighbouring points are correlated ({self.correlation_in_space:+.2f}, "
                f"score {self.in_space:+.1f}): the flow's error is smooth, so there are fewer independent "
                "measurements than points. Thin the points until this passes."
            )
        if abs(self.tails) > LIMIT:
            warnings.append(
                f"The residuals have {'heavy' if self.tails > 0 else 'light'} tails (score "
                f"{self.tails:+.1f}): some of the flow is wrong by more than its stated error, or the stated "
                "errors vary too little."
            )
        if abs(self.level) > LIMIT:
            warnings.append(
                f"The residuals grow or shrink over the recording (score {self.level:+.1f}): the level of "
                "the flow's error or of the pressures is not constant."
            )
        return warnings


def innovations(space: InputSpace, solved: Solved, columns: Array) -> Array:
    """Apply the whitening of y - mu to columns (N, m', k) of the rows with independent errors: innovations
    frame by frame, divided by the Cholesky factor of their covariance, and scaled to variance sigma_v^2; nan
    where missing or used for the initial state.

    The recursion updates the posterior of the inputs; a frame depends only on those up to it.
    O(N m (N q)^2).
    """
    weights, chosen, scale = space.weights, space.chosen, space.scale
    q, kinds = solved.lags.shape[2], columns.shape[2]
    gains = space.classes[2]
    order = np.argsort(chosen, kind="stable")
    frame_of = chosen[order] // q
    variances = solved.prior_variance  # the gains act in all frames, so they come first
    covariance = np.diag(np.append(variances[len(chosen) :], variances[order]))
    during = np.array(variances)
    during[space.before] = 0.0
    during = np.append(during[len(chosen) :], during[order])
    mean = np.zeros((len(variances), kinds))
    out = np.full((*weights.shape, kinds), np.nan)
    for k in range(len(weights)):
        seen = np.flatnonzero(weights[k] > 0)
        if not len(seen):
            continue
        i = int(np.searchsorted(frame_of, k, side="right"))
        used = chosen[order[:i]]
        moved = solved.lags[k - used // q, :, used % q].T[seen] * scale[order[:i]]
        T = np.hstack([space.gain_columns(k)[seen], moved])
        i += gains
        P = covariance[:i, :i]
        PT = P @ T.T
        C = T @ PT + np.diag(1 / weights[k, seen])
        factor = linalg.cholesky(C, lower=True)
        known = T**2 @ during[:i] + 1 / weights[k, seen]
        z = linalg.solve_triangular(factor, columns[k, seen] - T @ mean[:i], lower=True)
        gain = linalg.solve_triangular(factor, PT.T, lower=True)
        mean[:i] += gain.T @ z
        P -= gain.T @ gain
        z[np.diag(factor) ** 2 > _LARGEST_VARIANCE * known] = np.nan
        out[k, seen] = z
    return out


def residual_test(z: Array, positions: Array) -> ResidualTest:
    """The scores of whitened residuals z (N, 2 r), nan where missing, of points at `positions` (r, 2) px.

    Raises InvalidInput where all are missing.
    """
    if not np.isfinite(z).any():
        raise InvalidInput(f"Residuals: none of {z.size} is a number; some must be. Is any frame observed?")
    frames = len(z)
    neighbour = _nearest(positions)
    by_point = z.reshape(frames, -1, 2)
    time = (z[1:] * z[:-1]).ravel()
    # A single point has no neighbour.
    space = (by_point * by_point[:, neighbour]).ravel() if len(neighbour) > 1 else np.full(1, np.nan)
    finite = z[np.isfinite(z)]
    squares = np.nanmean(np.where(np.isfinite(z), z**2, np.nan)[np.isfinite(z).any(axis=1)], axis=1)
    counts = np.isfinite(z).sum(axis=1)[np.isfinite(z).any(axis=1)]
    half = len(squares) // 2
    n1, n2 = counts[:half].sum(), counts[half:].sum()
    late = float(np.average(squares[half:], weights=counts[half:]))
    early = float(np.average(squares[:half], weights=counts[:half])) if half else late
    level = (late - early) / math.sqrt(2 / n1 + 2 / n2) if half else 0.0
    mutual = 1 + np.mean(neighbour[neighbour] == np.arange(len(neighbour)))  # mutual neighbours count twice
    return ResidualTest(
        count=len(finite),
        consecutive=int(np.isfinite(time).sum()),
        in_time=_score(time),
        in_space=_score(space) / math.sqrt(mutual),
        tails=float((np.mean(finite**4) - 3) / math.sqrt(96 / len(finite))),
        level=level,
        correlation_in_time=_correlation(z[1:], z[:-1]),
        correlation_in_space=_correlation(by_point, by_point[:, neighbour]) if len(neighbour) > 1 else 0.0,
    )


def _score(products: Array) -> float:
    there = products[np.isfinite(products)]
    return float(there.sum() / math.sqrt(len(there))) if len(there) else 0.0


def _correlation(first: Array, second: Array) -> float:
    """Correlation of values of mean 0, where both are finite."""
    there = np.isfinite(first * second)
    a, b = first[there], second[there]
    size = math.sqrt(float(a @ a) * float(b @ b))
    return float(a @ b) / size if size else 0.0


def _nearest(image: Array) -> NDArray[np.intp]:
    """The nearest other point of each point; of a single point itself."""
    if len(image) == 1:
        return np.zeros(1, dtype=np.intp)
    square = np.asarray(np.sum((image[:, None] - image) ** 2, axis=2))
    np.fill_diagonal(square, np.inf)
    return np.asarray(np.argmin(square, axis=1))
