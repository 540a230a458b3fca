"""Expected sufficient statistics of the states, given all frames: the E step of EM."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from plica import _engine
from plica.identify.state_space.kalman import Filtered
from plica.identify.state_space.linear_gaussian import LinearGaussian, PatternNoise
from plica.identify.state_space.smoother import SmoothedFrame, smoothed_frames

__all__ = ["Moments", "expected_moments"]

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Moments:
    """Input of the M step. With C the sums of covariances and m the smoothed means,

        S11 = sum_1^N E z_k z_k' = C11 + later' later,  S00 = sum E z_{k-1} z_{k-1}' = C00 + earlier' earlier,
        S10 = sum E z_k z_{k-1}' = C10 + later' earlier.

    Attributes
    ----------
    later, earlier : (N, n)
        m_{k|N} and m_{k-1|N} of k = 1 ... N.
    C11, C00, C10 : (n, n)
    noise : (n, n) or (r, r)
        sum E w w' under the model; for `PatternNoise` sum E q q'.
    residual : (p, p) or (p,)
        sum E (y - H z)(y - H z)' over frames with an observed row, with expected values for missing rows;
        for variances, the sum of each row over the frames where it is observed.
    seen : (p,)
        Number of frames that each entry of `residual` sums.
    """

    later: Array
    earlier: Array
    C11: Array
    C00: Array
    C10: Array
    noise: Array
    residual: Array
    seen: Array

    def transition_residual(self, G: Array, f: Array | None) -> Array:
        """sum E (z_k - G z_{k-1} - f)(...)', symmetric (n, n)."""
        mean = self.later - self.earlier @ G.T
        if f is not None:
            mean = mean - f
        cross = self.C10 @ G.T
        out: Array = self.C11 - cross - cross.T + G @ self.C00 @ G.T + mean.T @ mean
        return 0.5 * (out + out.T)


def expected_moments(model: LinearGaussian, filtered: Filtered) -> Moments:
    """One pass of the smoother over `filtered`, keeping only sums."""
    n, frames = model.states, len(filtered.updates)
    means = np.empty((frames + 1, n))
    adjoints = np.empty((frames, n))
    C11, C00, information_lag, information = (_Sum(n) for _ in range(4))
    observed = _ObservedSum(model)
    for back, frame in enumerate(smoothed_frames(model, filtered)):
        k = frames - back
        means[k] = frame.mean
        if k > 0:
            C11.add(frame.covariance)
            information_lag.add(frame.information_lag)
            information.add(frame.information)
            adjoints[k - 1] = frame.adjoint
            observed.add(filtered.observations[k - 1], frame)
        if k < frames:
            C00.add(frame.covariance)
    # Cov(z_k, z_{k-1} | y) = G P_{k-1|N} + Cov(w_{k-1}, z_{k-1} | y)
    C10 = model.G @ C00.total() - model.Gamma_w @ information_lag.total()
    return Moments(
        later=means[1:],
        earlier=means[:-1],
        C11=C11.total(),
        C00=C00.total(),
        C10=C10,
        noise=_noise(model, adjoints, information.total()),
        residual=observed.residual,
        seen=observed.seen,
    )


def _noise(model: LinearGaussian, adjoints: Array, information: Array) -> Array:
    """sum E q q' = sum Q L' (lambda lambda' - Lambda) L Q + N Q: no difference of large states.

    The disturbance smoother of S. J. Koopman, Biometrika 80, 1993.
    """
    noise = model.process_noise
    if isinstance(noise, PatternNoise):
        seen, Q = noise.patterns @ noise.covariance, noise.covariance
    else:
        seen, Q = noise, noise
    mean = adjoints @ seen
    out: Array = mean.T @ mean + len(adjoints) * Q - seen.T @ information @ seen
    return 0.5 * (out + out.T)


class _Sum:
    """A sum of matrices in which many consecutive terms are the same object."""

    def __init__(self, n: int) -> None:
        self._total = np.zeros((n, n))
        self._pending: Array | None = None
        self._count = 0

    def add(self, matrix: Array) -> None:
        if matrix is not self._pending:
            self._flush()
            self._pending = matrix
        self._count += 1

    def total(self) -> Array:
        self._flush()
        return self._total

    def _flush(self) -> None:
        if self._pending is not None:
            self._total += self._count * self._pending
        self._pending, self._count = None, 0


class _ObservedSum:
    """Sum of E v v' over frames with at least one observed row."""

    def __init__(self, model: LinearGaussian) -> None:
        self._model = model
        self._independent = model.Gamma_v.ndim == 1
        p = model.rows
        self.residual = np.zeros(p if self._independent else (p, p))
        self.seen = np.zeros(p)
        observed_columns = np.flatnonzero(np.any(model.H != 0, axis=0))
        self._columns = (
            slice(int(observed_columns[0]), int(observed_columns[-1]) + 1)
            if len(observed_columns)
            else slice(0, 0)
        )
        self._H = np.ascontiguousarray(model.H[:, self._columns])
        self._of: Array | None = None  # the covariance that _seen_covariance is of
        self._spread = np.empty(0)

    def add(self, y: Array, frame: SmoothedFrame) -> None:
        seen = ~np.isnan(y)
        if not seen.any():
            return
        spread = self._seen_covariance(frame.covariance)
        error = np.where(seen, y - self._H @ frame.mean[self._columns], 0.0)
        if self._independent:
            self.residual += np.where(seen, error**2 + spread, 0.0)
            self.seen += seen
            return
        moment = np.outer(error, error) + spread
        if not seen.all():
            moment = self._completed(moment, seen)
        self.residual += moment
        self.seen += 1

    def _seen_covariance(self, covariance: Array) -> Array:
        """H P H', or its diagonal."""
        if covariance is not self._of:
            P = covariance[self._columns, self._columns]
            HP = _engine.product(self._H, P)
            self._spread = (
                (HP * self._H).sum(axis=1) if self._independent else _engine.symmetric_product(HP, self._H.T)
            )
            self._of = covariance
        return self._spread

    def _completed(self, moment: Array, seen: NDArray[np.bool_]) -> Array:
        """E v v', where v of missing rows is N(B v_o, rest) given v_o of the observed ones."""
        Gamma, unseen = self._model.Gamma_v, ~seen
        known, cross = Gamma[np.ix_(seen, seen)], Gamma[np.ix_(unseen, seen)]
        B = np.linalg.solve(known, cross.T).T
        out = np.empty_like(moment)
        inner = moment[np.ix_(seen, seen)]
        out[np.ix_(seen, seen)] = inner
        out[np.ix_(unseen, seen)] = B @ inner
        out[np.ix_(seen, unseen)] = inner @ B.T
        out[np.ix_(unseen, unseen)] = B @ inner @ B.T + Gamma[np.ix_(unseen, unseen)] - B @ cross.T
        return out
