"""The unknown inputs of a recording, and products with T for the likelihood: T' W T, T' W x, T w."""

from __future__ import annotations

import math
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy import linalg, sparse

from plica import _engine
from plica.errors import InvalidInput
from plica.identify.likelihood.noise_levels import Noise, profiled
from plica.identify.model.forcing import Forcing
from plica.identify.observation.observation import Observation

__all__ = ["InputSpace", "Solved"]

Array = NDArray[np.float64]
_GAIN_BLOCK = 32  # columns of gains that are dense at a time
_DIFFUSE_SD = 1e4
"""[Pa] kappa: sd of each pressure before the recording divided by sigma_v, the factor on the flow's stated
sd; ten times a phonation pressure where sigma_v is 1."""


class InputSpace:
    """The i unknown inputs: pressures of the frames, then those of collisions, then pressures of the frames
    before the first with data, and last the gains of the flow's points.

    Pressures before the recording determine its initial state. They have a diffuse prior and are eliminated
    as in a restricted likelihood (docs/identification_theory.md).

    Attributes
    ----------
    weights : (N, m) 1/px^2, W, zero where nothing is observed
    count : number of observed values
    chosen : positions of the pressures among all N (q + c) columns of T
    scale : of these columns: the noise of their pattern; 1 for collisions and before the recording
    classes : (3) numbers of inputs with the level of the pressures, of the collisions, and of the gains
    before : slice of the inputs before the recording, which have no level
    others : positions of the other inputs
    fixed_collision_sd : Pa; None if it is estimated or there are no collisions
    """

    def __init__(
        self,
        observation: Observation,
        forcing: Forcing,
        weights: Array | None = None,
        gains: sparse.csc_array | None = None,
    ) -> None:
        """weights (N, m) of rows other than the observation's; gains (N m, k) of the flow's points."""
        self.weights = observation.weights if weights is None else weights
        self.count = int(np.count_nonzero(self.weights))
        frames, q = observation.frames, forcing.patterns.shape[1]
        c = 0 if forcing.collision is None else forcing.collision.shape[1]
        scale = np.zeros((frames, q + c))
        scale[:, :q] = forcing.noise
        collides = np.zeros((frames, q + c), dtype=bool)
        collides[:, q:] = np.asarray(observation.closed)[:, None]
        seen = np.flatnonzero(self.weights.any(axis=1))
        if not len(seen):
            raise InvalidInput(
                "MarginalLikelihood: number of frames with data = 0; must be >= 1, not counting those that "
                "the flow's error uses as lags."
            )
        scale[seen[-1] + 1 :], collides[seen[-1] + 1 :] = 0, False  # later inputs affect no observed value
        begins = np.flatnonzero(observation.weights.any(axis=1))[0]
        early = np.arange(frames)[:, None] < begins
        groups = [scale > 0, collides, ((scale > 0) | collides) & early]
        groups[:2] = [group & ~early for group in groups[:2]]
        chosen = [np.flatnonzero(group) for group in groups]
        self.chosen = np.concatenate(chosen)
        scale[groups[1] | groups[2]] = 1.0
        self.scale = scale.ravel()[self.chosen]
        ends = np.cumsum([len(group) for group in chosen])
        self.before = slice(int(ends[1]), int(ends[2]))
        if self.count <= len(chosen[2]):
            raise InvalidInput(
                f"MarginalLikelihood: number of values = {self.count}; must be > {len(chosen[2])}, the "
                "number of unknown pressures before the recording. Use more points or frames, or a shorter "
                "lead."
            )
        self.fixed_collision_sd = forcing.collision_sd if len(chosen[1]) else None
        self._gains = gains
        self.classes = (len(chosen[0]), len(chosen[1]), 0 if gains is None else gains.shape[1])
        self.others = np.delete(np.arange(sum(self.classes) + len(chosen[2])), self.before)
        if gains is not None:
            self._weighted_gains = sparse.csc_array(gains.multiply(self.weights.reshape(-1, 1)))
            self._gain_gram = (gains.T @ self._weighted_gains).toarray()

    def gram(self, first: Array, second: Array, gains: tuple[bool, bool] = (True, True)) -> Array:
        """first' W second of the unknown inputs, (i, i); `gains`: whether first and second include the
        columns of the gains, or zeros in their place, as for derivatives of T."""
        whole = _engine.toeplitz_gram(first, second, self.weights)
        chosen: Array = np.asarray(whole)[np.ix_(self.chosen, self.chosen)]
        chosen *= self.scale[:, None]
        chosen *= self.scale
        if self._gains is None:
            return chosen
        i, k = len(chosen), self._gains.shape[1]
        extended = np.zeros((i + k, i + k))
        extended[:i, :i] = chosen
        if gains[1]:
            extended[:i, i:] = self._gain_rows(first)
        if gains[0]:
            extended[i:, :i] = (
                extended[:i, i:].T if gains[1] and second is first else self._gain_rows(second).T
            )
        if all(gains):
            extended[i:, i:] = self._gain_gram
        return extended

    def _gain_rows(self, lags: Array) -> Array:
        """lags' W gains, (pressures, k)."""
        width = self._weighted_gains.shape[1]
        parts = [self._weighted_gains[:, a : a + _GAIN_BLOCK].toarray() for a in range(0, width, _GAIN_BLOCK)]
        return np.hstack([self._of_pressures(lags, part) for part in parts])

    def _of_pressures(self, lags: Array, rows: Array) -> Array:
        flat = np.ascontiguousarray(rows.reshape(self.weights.size, -1))
        whole = np.asarray(_engine.toeplitz_transposed_product(lags, flat))
        return np.asarray(whole[self.chosen] * self.scale[:, None])

    def gathered(self, lags: Array, rows: Array, gains: bool = True) -> Array:
        """lags' rows of the unknown inputs, (i, k); rows (N, m, k) or (N, m); without `gains` those entries
        are zero."""
        found = self._of_pressures(lags, rows)
        if self._gains is None:
            return found
        flat = rows.reshape(self.weights.size, -1)
        own = self._gains.T @ flat if gains else np.zeros((self._gains.shape[1], flat.shape[1]))
        return np.vstack([found, own])

    def spread(self, lags: Array, inputs: Array) -> Array:
        """lags times inputs (i), plus the gain columns times the gains, (N, m)."""
        found = self.moved(lags, inputs)
        if self._gains is not None:
            found += (self._gains @ inputs[len(self.chosen) :]).reshape(found.shape)
        return found

    def moved(self, lags: Array, inputs: Array) -> Array:
        """(N, m) The motion by the pressures alone, of rows that need not be those of the weights."""
        whole = np.zeros((self.weights.shape[0] * lags.shape[2], 1))
        whole[self.chosen, 0] = self.scale * inputs[: len(self.chosen)]
        return np.asarray(_engine.toeplitz_product(lags, whole)).reshape(lags.shape[:2])

    def gain_columns(self, frame: int) -> Array:
        """(m, k) The gain columns of one frame."""
        m = self.weights.shape[1]
        if self._gains is None:
            return np.zeros((m, 0))
        return np.asarray(self._by_rows[frame * m : (frame + 1) * m].toarray())

    @cached_property
    def _by_rows(self) -> sparse.csr_array:
        assert self._gains is not None
        return self._gains.tocsr()


class Solved:
    """S = Q^-1 + T' W T at one point, and the quantities that follow from its factor.

    Attributes
    ----------
    inputs : (i), expected values
    residual : (N, m) px/frame, with these inputs
    value : the log-likelihood
    before : A = (T_b' W T_b + Q_b^-1)^-1 of the b inputs before the recording, (b, b)
    coupling : A T_b' W T of the others, (b, i - b)
    """

    def __init__(
        self, space: InputSpace, mean: Array, lags: Array, error: Array, noise: Noise | None = None
    ) -> None:
        """error (N, m) px/frame, y - mu, zero where missing; noise levels, or None: the most likely ones."""
        self.mean, self.lags = mean, lags
        weights, n, held = space.weights, space.count, space.fixed_collision_sd
        weighted = weights * error
        gram, projected = space.gram(lags, lags), space.gathered(lags, weighted)[:, 0]
        square = float(np.sum(weighted * error))
        before, others = space.before, space.others
        early = gram[before, before] + np.eye(before.stop - before.start) / _DIFFUSE_SD**2
        factor = np.asarray(np.linalg.cholesky(early), dtype=float)
        inverse = np.linalg.inv(factor)
        self.before: Array = inverse.T @ inverse
        self.coupling: Array = self.before @ gram[before][:, others]
        if noise is None:
            noise = profiled(
                gram[np.ix_(others, others)] - gram[others, before] @ self.coupling,
                projected[others] - projected[before] @ self.coupling,
                square - float(projected[before] @ self.before @ projected[before]),
                n,
                space.classes,
                held,
            )
        self.noise = noise
        ratios = [
            noise.pressure / noise.flow,
            (noise.collision if held is None else held) / noise.flow,
            noise.gain / noise.flow,
        ]
        least = 1e-20 / max(
            float(np.abs(np.diag(gram)).max(initial=0.0)), 1e-300
        )  # a level of zero means no input
        self.prior_variance = np.full(len(gram), _DIFFUSE_SD**2)
        self.prior_variance[others] = np.maximum(np.repeat(np.square(ratios), space.classes), least)
        S = gram + np.diag(1 / self.prior_variance)
        self._factor = linalg.cho_factor(S, lower=True)
        self.inputs: Array = linalg.cho_solve(self._factor, projected)
        spread = space.spread(lags, self.inputs)
        self.residual = np.where(weights > 0, error - spread, 0.0)
        log_det = _log_det(self._factor[0]) - _log_det(factor)
        log_det += float(np.log(self.prior_variance[others]).sum())
        log_weights = float(np.log(weights[weights > 0]).sum())
        square = float(np.sum(weighted * self.residual))
        self.value = -0.5 * (
            n * math.log(2 * math.pi * noise.flow**2) - log_weights + log_det + square / noise.flow**2
        )

    @cached_property
    def inverse(self) -> Array:
        """S^-1, (i, i)."""
        return self.solve(np.eye(len(self.prior_variance)))

    def solve(self, right: Array) -> Array:
        """S^-1 right."""
        solved: Array = linalg.cho_solve(self._factor, right)
        return solved


def _log_det(factor: Array) -> float:
    """Of the matrix with this Cholesky factor."""
    return 2 * float(np.log(np.diag(factor)).sum())
