"""The gradient of the log-likelihood and its Fisher information, from the factor of S at one point.

With D_j = dT/dx_j, X_j = T' W D_j, e = y - mu, w = S^-1 T' W e, all in units of sigma_v:

    gradient_j = (dmu_j + D_j w)' W (e - T w) / sigma_v^2 - tr S^-1 X_j
    information_ij = [dmu_i' W dmu_j - (T' W dmu_i)' S^-1 (T' W dmu_j)] / sigma_v^2
                     + tr S^-1 X_i S^-1 X_j + tr (Q - S^-1) (D_j' W D_i - X_j' S^-1 X_i) .

Inputs b before the recording are treated as fixed effects: their motion D_jb w_b belongs to dmu_j; W of the
others is W - W T_b A T_b' W, A = (T_b' W T_b + Q_b^-1)^-1; the gradient gains tr A X_jb, and the information
loses the spurious part tr (S^-1)_bb D_ib' (W - W T S^-1 T' W) D_jb that comes from the error of w_b
(docs/identification_theory.md).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from plica.identify.likelihood.input_space import InputSpace, Solved

__all__ = ["gradient_and_information"]

Array = NDArray[np.float64]
_LEAST_GAIN_FREEDOM = 1e-3
"""Effective degrees of freedom of all gains below which their level is not estimated."""


def gradient_and_information(
    space: InputSpace, solved: Solved, means: Sequence[Array], T_derivatives: Array, noise_is_free: bool
) -> tuple[Array, Array]:
    """Gradient (p) and information (p, p) at one point.

    Parameters
    ----------
    space, solved : the unknown inputs, and S at the point
    means : p derivatives of mu, each (N, m)
    T_derivatives : (t, N, m, q) derivatives of T by the first t <= p coordinates; it depends on no other
    noise_is_free : whether the noise levels are estimated; they are then eliminated from the information
    """
    weights, variance, tissue = space.weights, solved.noise.flow**2, len(T_derivatives)
    before, others = space.before, space.others
    start = np.zeros_like(solved.inputs)
    start[before] = solved.inputs[before]
    means = [d + space.moved(D, start) for d, D in zip(means, T_derivatives, strict=False)] + list(
        means[tissue:]
    )
    moved = np.stack([np.where(weights > 0, d, 0.0) for d in means], axis=-1)  # (N, m, p)
    weighted = weights[..., None] * moved
    left = weights * solved.residual
    T_moved = space.gathered(solved.lags, weighted)  # (i, p)
    gradient = np.einsum("nmp,nm->p", moved, left) / variance
    information = (np.einsum("nmp,nmk->pk", moved, weighted) - T_moved.T @ solved.solve(T_moved)) / variance
    X = [space.gram(solved.lags, D, gains=(True, False)) for D in T_derivatives]
    inverse = solved.inverse[np.ix_(others, others)]
    excess = np.diag(solved.prior_variance[others]) - inverse  # Q - S^-1
    AX = [solved.before @ x[before][:, others] for x in X]
    X_own = [x[np.ix_(others, others)] - solved.coupling.T @ x[before][:, others] for x in X]
    SX = [inverse @ x for x in X_own]
    traces = np.array([np.trace(sx) for sx in SX] + [0.0] * (len(means) - tissue))
    spurious, of_T = np.zeros_like(information), np.zeros_like(information)
    for j, D in enumerate(T_derivatives):
        gathered = space.gathered(D, left, gains=False)[:, 0]
        gradient[j] += solved.inputs[others] @ gathered[others] / variance
        gradient[j] += np.sum(solved.before * X[j][before, before].T) - np.sum(solved.inverse * X[j].T)
        X_excess = X_own[j] @ excess
        for i in range(j + 1):
            squares = space.gram(D, T_derivatives[i], gains=(False, False))
            spurious[i, j] = spurious[j, i] = _spurious_information(space, solved, squares, X[j], X[i])
            own = squares[np.ix_(others, others)] - X[j][before][:, others].T @ AX[i]
            of_T[i, j] = of_T[j, i] = (
                np.sum(own * excess) - np.sum(X_excess * SX[i]) + np.sum(SX[i] * SX[j].T)
            )
    information = _positive_part(information, spurious) + of_T
    if noise_is_free:
        information = _without_noise(information, space, solved, SX, traces)
    return gradient, information


def _spurious_information(
    space: InputSpace, solved: Solved, squares: Array, first: Array, second: Array
) -> float:
    """tr (S^-1)_bb D_jb' (W - W T S^-1 T' W) D_ib of squares D_j' W D_i, first X_j and second X_i."""
    b = space.before
    left = squares[b, b] - first[:, b].T @ solved.solve(second[:, b])
    return float(np.sum(solved.inverse[b, b] * left))


def _positive_part(information: Array, spurious: Array) -> Array:
    """The positive semidefinite part of information - spurious, independent of the units of the coordinates:
    it is taken after scaling so that the diagonals of the two add up to 1."""
    size = np.diag(information) + np.diag(spurious)
    unit = np.sqrt(np.where(size > 0, size, 1.0))
    left = information - spurious
    values, vectors = np.linalg.eigh(left / np.outer(unit, unit))
    if values.min(initial=0.0) >= 0:
        return left
    spread = unit[:, None] * vectors
    return np.asarray((spread * np.maximum(values, 0.0)) @ spread.T)


def _without_noise(
    information: Array, space: InputSpace, solved: Solved, SX: list[Array], traces: Array
) -> Array:
    """The Schur complement that eliminates the estimated levels, log Q of each class and log sigma_v^2, from
    the information. With a fixed sigma_c, its Q decreases as sigma_v^2 increases."""
    ends, others = np.cumsum([0, *space.classes]), space.others
    inverse = solved.inverse[np.ix_(others, others)]
    shrunk = np.eye(len(others)) - inverse / solved.prior_variance[others]  # S^-1 T' W T
    held = space.fixed_collision_sd is not None
    used = [solved.noise.pressure > 0, held or solved.noise.collision > 0, solved.noise.gain > 0]
    parts = [slice(int(ends[c]), int(ends[c + 1])) for c in range(3)]
    used[2] = used[2] and float(np.trace(shrunk[parts[2], parts[2]])) >= _LEAST_GAIN_FREEDOM
    numbers = [c for c in range(3) if used[c] and space.classes[c]]
    classes = [parts[c] for c in numbers]
    levels = len(classes) + 1
    own, cross = np.zeros((levels, levels)), np.zeros((len(information), levels))
    own[-1, -1], cross[:, -1] = 0.5 * space.count, traces
    for a, k in enumerate(classes):
        own[a, -1] = own[-1, a] = 0.5 * np.trace(shrunk[k, k])
        for b, other in enumerate(classes):
            own[a, b] = 0.5 * np.sum(shrunk[k, other] * shrunk[other, k].T)
        for j, sx in enumerate(SX):
            cross[j, a] = np.sum(sx[k, :] * shrunk[:, k].T)
    if held:
        own_level = numbers.index(1)
        rises = np.delete(np.eye(levels), own_level, axis=0)
        rises[-1, own_level] = -1.0
        own, cross = rises @ own @ rises.T, cross @ rises.T
    reduced: Array = information - cross @ np.linalg.solve(own, cross.T)
    return reduced
