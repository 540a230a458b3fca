"""The Kalman filter of a linear Gaussian model."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg.blas import dtrsv

from plica import _engine
from plica.errors import InvalidInput, SolveFailed
from plica.identify.state_space.linear_gaussian import LinearGaussian
from plica.identify.state_space.steady import Settling
from plica.identify.state_space.whitening import WhitenedFrames, checked_input, checked_observations, whiten

__all__ = ["Filtered", "Update", "kalman_filter", "log_likelihood"]

Array = NDArray[np.float64]

STEADY_TOLERANCE = 1e-11


@dataclass(frozen=True, eq=False)
class Update:
    """Covariance update of one frame: P_{k|k} = P - W'W with W = R^-T H P and R'R = H P H' + I.

    H is the frame's whitened matrix, of the states in `columns`. Frames of a steady filter share it.

    Attributes
    ----------
    covariance : (n, n)
        P = P_{k|k-1} = G F G' + Gamma_w.
    moved : (n, n)
        G F, F the filtered covariance of the frame before.
    R : (r, r)
        Upper triangular.
    W : (r, n)
    group : WhitenedFrames
    """

    covariance: Array
    moved: Array
    R: Array
    W: Array
    group: WhitenedFrames

    @property
    def columns(self) -> slice:
        """The states that H observes."""
        return self.group.columns

    @cached_property
    def V(self) -> Array:  # noqa: N802 (a field letter)
        """R^-T H, (r, c)."""
        V = self.group.matrix.copy()
        _engine.solve_lower(self.R, V)
        return V

    def filtered_covariance(self) -> Array:
        """P_{k|k}, (n, n)."""
        if len(self.W) == 0:
            return self.covariance
        P = self.covariance.copy()
        _engine.gram_update(P, self.W, -1.0)
        return P

    def log_likelihood(self, innovation: Array) -> float:
        """Log-likelihood of the innovation R^-T (y - H m), without the constant of the frame."""
        return -0.5 * float(innovation @ innovation) - float(np.log(np.diag(self.R)).sum())


@dataclass(frozen=True, eq=False)
class Filtered:
    """Result of `kalman_filter`. Index k is frame k + 1.

    Attributes
    ----------
    predicted_mean, filtered_mean : (N, n)
        m_{k|k-1} and m_{k|k}.
    innovations : list of (r,)
        R^-T (y - H m): whitened and collapsed, independent N(0, 1) if the model holds; empty for a missing
        frame.
    updates : list of Update
        Covariances; frames of a steady filter share one.
    log_likelihoods : (N,)
        log p(y_k | y_1 ... y_{k-1}), 0 for a missing frame.
    input : (N, n) or None
    observations : (N, p)
    """

    predicted_mean: Array
    filtered_mean: Array
    innovations: list[Array]
    updates: list[Update]
    log_likelihoods: Array
    input: Array | None
    observations: Array

    @property
    def log_likelihood(self) -> float:
        """log p(y), the marginal likelihood of the innovations."""
        return float(self.log_likelihoods.sum())

    def predicted_covariance(self, k: int) -> Array:
        """P_{k|k-1} of index k, (n, n)."""
        return self.updates[k].covariance

    def filtered_covariance(self, k: int) -> Array:
        """P_{k|k} of index k, (n, n)."""
        return self.updates[k].filtered_covariance()

    @property
    def settled(self) -> int:
        """Number of frames that share the covariance of the previous frame."""
        return sum(a is b for a, b in zip(self.updates, self.updates[1:], strict=False))


def kalman_filter(
    model: LinearGaussian,
    y: ArrayLike,
    f: ArrayLike | None = None,
    *,
    steady_tolerance: float = STEADY_TOLERANCE,
) -> Filtered:
    """Filtered means and covariances of the states, and the log-likelihood of the frames.

    Parameters
    ----------
    model : LinearGaussian
    y : (N, p)
        Frame by frame; NaN where a row, or a whole frame, is missing.
    f : (N, n), optional
        Row k is the input f_k from frame k to frame k + 1.
    steady_tolerance : float
        The covariance is treated as steady, as long as the same rows are observed, when its entries P_ij are
        within this of their limit, in units of sqrt(P_ii P_jj); 0: never. >= 0.

    Notes
    -----
    Frames with the same observed rows are whitened together, and collapsed if they have more rows than
    states that H observes. The update is P - W'W (symmetric to the bit). One step costs
    3 n^3 + n r (2 c + n + r) operations with c observed states and r = min(p, c) rows, and O(n^2) once the
    covariance is steady.

    Raises
    ------
    InvalidInput
        If y or f do not fit the model.
    SolveFailed
        If a covariance of innovations is not positive definite (the frame is named).
    """
    where = "kalman_filter"
    y = checked_observations(model, y, where)
    f = checked_input(model, f, len(y), where)
    predicted, filtered = np.empty((len(y), model.states)), np.empty((len(y), model.states))
    terms = np.empty(len(y))
    innovations, updates = [], []
    for k, step in enumerate(_steps(model, y, f, steady_tolerance)):
        predicted[k], filtered[k], innovation, update, terms[k] = step
        innovations.append(innovation)
        updates.append(update)
    return Filtered(predicted, filtered, innovations, updates, terms, f, y)


def log_likelihood(
    model: LinearGaussian,
    y: ArrayLike,
    f: ArrayLike | None = None,
    *,
    steady_tolerance: float = STEADY_TOLERANCE,
) -> float:
    """log p(y) as in `kalman_filter`, keeping only the last covariance."""
    where = "log_likelihood"
    y = checked_observations(model, y, where)
    f = checked_input(model, f, len(y), where)
    return float(np.array([step[4] for step in _steps(model, y, f, steady_tolerance)]).sum())


Step = tuple[Array, Array, Array, Update, float]


def _steps(model: LinearGaussian, y: Array, f: Array | None, steady_tolerance: float) -> Iterator[Step]:
    """Predicted mean, filtered mean, innovation, update and log-likelihood, frame by frame."""
    if not steady_tolerance >= 0:
        raise InvalidInput(f"kalman_filter: steady_tolerance = {steady_tolerance:g}; must be >= 0.")
    frames = _by_frame(whiten(model, y), len(y))
    settling = Settling(steady_tolerance)
    G, noise = model.G, model.Gamma_w
    mean, P = model.m0, model.P0
    update: Update | None = None
    before: WhitenedFrames | None = None
    steady = False
    for k, (group, row) in enumerate(frames):
        mean = G @ mean if f is None else G @ mean + f[k]
        if update is None or not (steady and group is before):
            moved = _engine.product(G, P)
            P = _engine.symmetric_product(moved, G.T)
            P += noise
            if group is not before:
                settling.restart()
            steady = update is not None and settling.settled(P, update.covariance)
            update = _update(P, moved, group, k)
            P = update.filtered_covariance()
            before = group
        predicted = mean
        innovation = group.data[row] - group.matrix @ mean[group.columns]
        if len(innovation):
            innovation = dtrsv(update.R.T, innovation, lower=1)
            mean = mean + innovation @ update.W
        yield predicted, mean, innovation, update, update.log_likelihood(innovation) + group.constant[row]


def _by_frame(groups: list[WhitenedFrames], frames: int) -> list[tuple[WhitenedFrames, int]]:
    order = {int(frame): (group, row) for group in groups for row, frame in enumerate(group.frames)}
    return [order[k] for k in range(frames)]


def _update(P: Array, moved: Array, group: WhitenedFrames, k: int) -> Update:
    if group.size == 0:
        return Update(P, moved, np.empty((0, 0)), np.empty((0, len(P))), group)
    W = _engine.product(group.matrix, P[group.columns])
    S = _engine.symmetric_product(W[:, group.columns], group.matrix.T)
    S[np.diag_indices_from(S)] += 1.0
    try:
        R = _engine.cholesky(S)
    except SolveFailed as error:
        raise SolveFailed(
            f"kalman_filter: frame {k + 1}: the covariance of the innovations is not positive definite "
            f"({error}) Is the evolution unstable, or P0 badly scaled?"
        ) from None
    _engine.solve_lower(R, W)
    return Update(P, moved, R, W, group)
