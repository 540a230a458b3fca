"""The Rauch-Tung-Striebel smoother with lag-one covariances."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from plica import _engine
from plica.identify.state_space.kalman import STEADY_TOLERANCE, Filtered, Update
from plica.identify.state_space.linear_gaussian import LinearGaussian
from plica.identify.state_space.steady import Settling

__all__ = ["Smoothed", "SmoothedFrame", "smooth", "smoothed_frames"]

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class SmoothedFrame:
    """A state given all frames. Once the recursions are steady, frames share their covariances.

    With P = P_{k|k-1} and F = P_{k-1|k-1}; at k = 0 there is no previous frame, and the last four are empty.

    Attributes
    ----------
    mean : (n,)
        m_{k|N}.
    covariance : (n, n)
        P_{k|N}.
    adjoint : (n,)
        lambda, with m_{k|N} = m_{k|k-1} + P lambda: Gamma_w lambda is the mean of the noise w_{k-1}.
    information : (n, n)
        Lambda, with P_{k|N} = P - P Lambda P.
    information_lag : (n, n)
        Lambda G F: Cov(w_{k-1}, z_{k-1} | y) = -Gamma_w Lambda G F.
    update : Update or None
        The filter's update of the frame.
    """

    mean: Array
    covariance: Array
    adjoint: Array
    information: Array
    information_lag: Array
    update: Update | None

    def lag_one(self) -> Array:
        """P_{k,k-1|N} = Cov(z_k, z_{k-1} | y) = (I - P Lambda) G F, for k >= 1."""
        assert self.update is not None
        return self.update.moved - _engine.product(self.update.covariance, self.information_lag)


@dataclass(frozen=True, eq=False)
class Smoothed:
    """Result of `smooth`.

    Attributes
    ----------
    mean : (N + 1, n)
        m_{k|N}, k = 0 ... N; the first row is the state before the first frame.
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

    computed without the inverse (P. de Jong, Biometrika 75, 1988), because force noise of a few patterns
    leaves P_{k+1|k} singular to round-off. 8 n^3 operations per frame, O(n^2) once the covariances are
    steady.

    Parameters
    ----------
    model : LinearGaussian
    filtered : Filtered
        Result of `kalman_filter` for the same model.
    """
    frames = list(smoothed_frames(model, filtered))[::-1]
    lag_one: list[Array] = []
    for before, frame in pairwise(frames):
        shared = frame.information_lag is before.information_lag and frame.update is before.update
        lag_one.append(lag_one[-1] if shared else frame.lag_one())
    return Smoothed(
        np.array([frame.mean for frame in frames]), [frame.covariance for frame in frames], lag_one
    )


def smoothed_frames(model: LinearGaussian, filtered: Filtered) -> Iterator[SmoothedFrame]:
    """The same frame by frame, k = N ... 0, to accumulate sums. 6 n^3 operations each."""
    back = _Backward(model, filtered.updates[-1])
    adjoint = np.zeros(model.states)  # G' lambda of the previous step
    for k in range(len(filtered.updates) - 1, -1, -1):
        update = filtered.updates[k]
        before = filtered.updates[k - 1] if k > 0 else None
        covariance, information, information_lag = back.step(update, before)
        mean = filtered.filtered_mean[k] + filtered_product(update, adjoint)
        if len(update.W):
            adjoint = adjoint.copy()
            adjoint[update.columns] += (filtered.innovations[k] - update.W @ adjoint) @ update.V
        yield SmoothedFrame(mean, covariance, adjoint, information, information_lag, update)
        adjoint = adjoint @ model.G
    none = np.empty((0, 0))
    yield SmoothedFrame(model.m0 + model.P0 @ adjoint, back.covariance, np.empty(0), none, none, None)


def filtered_product(update: Update, x: Array) -> Array:
    """P_{k|k} x without forming P_{k|k}."""
    out: Array = update.covariance @ x
    return out - (update.W @ x) @ update.W if len(update.W) else out


class _Backward:
    """The backward recursion of the covariances.

    With Lambda of frame k, G F = `moved` and F = P_{k-1|k-1}: P_{k-1|N} = F - (G F)' Lambda (G F).

    Attributes
    ----------
    covariance : (n, n)
        P_{k|N} of the frame of the next step.
    """

    def __init__(self, model: LinearGaussian, last: Update) -> None:
        self.covariance = last.filtered_covariance()
        self._model = model
        self._carried: Array | None = None  # G' Lambda G of the previous step
        self._made_from: tuple[Update, Update | None] | None = None
        self._information: Array | None = None
        self._information_lag: Array | None = None
        self._settling = Settling(STEADY_TOLERANCE)
        self._settled = False

    def step(self, update: Update, before: Update | None) -> tuple[Array, Array, Array]:
        """P_{k|N}, Lambda and Lambda G F of frame k."""
        covariance = self.covariance
        same = self._made_from is not None and self._made_from[0] is update and self._made_from[1] is before
        if not (same and self._settled):
            if not same:
                self._settling.restart()
            information = self._backward(update)
            previous, self._information = self._information, information
            self._settled = previous is not None and self._settling.settled(information, previous)
            self._information_lag = _engine.product(information, update.moved)
            F = self._model.P0 if before is None else before.filtered_covariance()
            self.covariance = F - _engine.symmetric_product(update.moved.T, self._information_lag)
            G = self._model.G
            self._carried = _engine.symmetric_product(G.T, _engine.product(information, G))
            self._made_from = update, before
        assert self._information is not None
        assert self._information_lag is not None
        return covariance, self._information, self._information_lag

    def _backward(self, update: Update) -> Array:
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
