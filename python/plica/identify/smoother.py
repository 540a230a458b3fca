"""The Rauch-Tung-Striebel smoother with lag-one covariances."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from plica import _engine
from plica.identify.kalman import STEADY_TOLERANCE, Filtered, Update
from plica.identify.linear_gaussian import LinearGaussian
from plica.identify.steady import Settling

__all__ = ["Smoothed", "SmoothedFrame", "smooth", "smoothed_frames"]

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class SmoothedFrame:
    """A state given all frames. Where the recursions have settled, frames share their covariances.

    Attributes
    ----------
    mean : (n,)
        m_{k|N}.
    covariance : (n, n)
        P_{k|N}.
    adjoint : (n,)
        lambda, with m_{k|N} = m_{k|k-1} + P_{k|k-1} lambda: Gamma_w lambda is the mean of the noise w_{k-1}.
        Zero at k = 0.
    information : (n, n)
        Lambda, with P_{k|N} = P - P Lambda P, P = P_{k|k-1}; zero at k = 0.
    lag_one : (n, n) or None
        P_{k,k-1|N} = Cov(z_k, z_{k-1} | y); None at k = 0.
    """

    mean: Array
    covariance: Array
    adjoint: Array
    information: Array
    lag_one: Array | None


@dataclass(frozen=True, eq=False)
class Smoothed:
    """What `smooth` returns.

    Attributes
    ----------
    mean : (N + 1, n)
        m_{k|N}, k = 0 ... N: the state before the first frame is the first row.
    covariance : list of N + 1 (n, n)
        P_{k|N}.
    lag_one : list of N (n, n)
        P_{k,k-1|N}, k = 1 ... N.
    """

    mean: Array
    covariance: list[Array]
    lag_one: list[Array]


def smooth(model: LinearGaussian, filtered: Filtered) -> Smoothed:
    """Means, covariances and lag-one covariances of the states given all frames.

    These are the moments of Rauch, Tung and Striebel,

        A_k = P_{k|k} G' P_{k+1|k}^-1,  P_{k|N} = P_{k|k} + A_k (P_{k+1|N} - P_{k+1|k}) A_k',
        P_{k,k-1|N} = P_{k|N} A_{k-1}',

    computed without the inverse (P. de Jong, Biometrika 75, 1988): force noise of a few patterns leaves
    P_{k+1|k} singular in round-off. 8 n^3 operations a frame, O(n^2) where the covariances have settled.

    Parameters
    ----------
    model : LinearGaussian
    filtered : Filtered
        Of the same model, by `kalman_filter`.
    """
    frames = list(smoothed_frames(model, filtered))[::-1]
    return Smoothed(
        np.array([frame.mean for frame in frames]),
        [frame.covariance for frame in frames],
        [frame.lag_one for frame in frames if frame.lag_one is not None],
    )


def smoothed_frames(model: LinearGaussian, filtered: Filtered) -> Iterator[SmoothedFrame]:
    """The same frame by frame, k = N ... 0, for who needs only sums over the frames."""
    G, n = model.G, model.states
    frames = len(filtered.updates)
    adjoint = np.zeros(n)  # lambda of frame k + 1 seen from frame k: G' lambda
    back = _Backward(model)
    for k in range(frames - 1, -1, -1):
        update, mean = filtered.updates[k], filtered.filtered_mean[k]
        before = filtered.updates[k - 1] if k > 0 else None
        covariance, lag_one, information = back.step(update, before)
        smoothed = mean + filtered_product(update, adjoint)
        if len(update.W):
            adjoint = adjoint.copy()
            adjoint[update.columns] += (filtered.innovations[k] - update.W @ adjoint) @ update.V
        yield SmoothedFrame(smoothed, covariance, adjoint, information, lag_one)
        adjoint = adjoint @ G
    yield SmoothedFrame(model.m0 + model.P0 @ adjoint, back.prior(), np.zeros(n), np.zeros((n, n)), None)


def filtered_product(update: Update, x: Array) -> Array:
    """P_{k|k} x without forming P_{k|k}."""
    out: Array = update.covariance @ x
    return out - (update.W @ x) @ update.W if len(update.W) else out


class _Backward:
    """The recursion of the covariances, from the last frame back.

    With P = P_{k|k-1}, Lambda of frame k, and F = P_{k-1|k-1} of the frame before:
    P_{k,k-1|N} = (I - P Lambda) G F and P_{k-1|N} = F - (G F)' Lambda (G F).
    """

    def __init__(self, model: LinearGaussian) -> None:
        self._model = model
        self._covariance: Array | None = None  # P_{k|N} of the frame that comes next
        self._carried: Array | None = None  # G' Lambda G of the frame before the one that comes next
        self._made_from: tuple[Update, Update | None] | None = None
        self._last: tuple[Array, Array, Array] | None = None
        self._settling = Settling(STEADY_TOLERANCE)
        self._settled = False

    def step(self, update: Update, before: Update | None) -> tuple[Array, Array, Array]:
        """P_{k|N}, P_{k,k-1|N} and Lambda_k."""
        made_from = (update, before)
        same = self._made_from is not None and all(
            a is b for a, b in zip(made_from, self._made_from, strict=True)
        )
        if same and self._settled and self._last is not None:
            return self._last
        if not same:
            self._settling.restart()
        covariance = update.filtered_covariance() if self._covariance is None else self._covariance
        information = self._information(update)
        F = self._model.P0 if before is None else before.filtered_covariance()
        GF = _engine.product(self._model.G, F)
        LGF = _engine.product(information, GF)
        lag_one = GF - _engine.product(update.covariance, LGF)
        self._covariance = F - _engine.symmetric_product(GF.T, LGF)
        self._carried = _engine.congruence(self._model.G.T, information, np.zeros_like(F))
        self._settled = same and self._last is not None and self._settling.settled(information, self._last[2])
        self._made_from = made_from
        self._last = covariance, lag_one, information
        return self._last

    def prior(self) -> Array:
        """P_{0|N}, after the first frame."""
        assert self._covariance is not None
        return self._covariance

    def _information(self, update: Update) -> Array:
        """Lambda_k = (I - W'V)' G' Lambda_{k+1} G (I - W'V) + V'V."""
        n = self._model.states
        if self._carried is None:
            information = np.zeros((n, n))
            if len(update.W):
                information[update.columns, update.columns] = _engine.symmetric_product(update.V.T, update.V)
            return information
        if not len(update.W):
            return self._carried
        V = np.zeros_like(update.W)
        V[:, update.columns] = update.V
        X = _engine.product(update.W, self._carried)
        Y = _engine.symmetric_product(X, update.W.T)
        Y[np.diag_indices_from(Y)] += 1.0
        Z = 0.5 * _engine.product(Y, V) - X
        return self._carried + _engine.symmetric_product(np.concatenate([V, Z]).T, np.concatenate([Z, V]))
