"""The unknown inputs of a recording, and all that the likelihood asks of T: T' W T, T' W x, T w."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from plica import _engine
from plica.identify.forcing import Forcing
from plica.identify.noise_levels import Noise
from plica.identify.observation import Observation

__all__ = ["InputSpace", "Solved"]

Array = NDArray[np.float64]


class InputSpace:
    """Which pressures of which frames are unknown: i of them, those of collisions last.

    Attributes
    ----------
    weights : (N, m) 1/px^2, W, zero where nothing is seen
    count : of what is seen
    chosen : (i) positions among all N (q + c) columns of T
    scale : (i) of the columns: the noise of their pattern
    pressures : of the i, how many are no forces of collisions
    held_collision_sd : Pa; None where it is estimated or there are no collisions
    """

    def __init__(self, observation: Observation, forcing: Forcing) -> None:
        self.weights = observation.weights
        self.count = int(np.count_nonzero(self.weights))
        frames, q = observation.frames, forcing.patterns.shape[1]
        c = 0 if forcing.collision is None else forcing.collision.shape[1]
        scale = np.zeros((frames, q + c))
        scale[:, :q] = forcing.noise
        collides = np.zeros((frames, q + c), dtype=bool)
        collides[:, q:] = np.asarray(observation.closed)[:, None]
        seen = np.flatnonzero(self.weights.any(axis=1))[-1]  # later inputs move nothing that is seen
        scale[seen + 1 :], collides[seen + 1 :] = 0, False
        pressures, collisions = np.flatnonzero(scale.ravel()), np.flatnonzero(collides.ravel())
        self.chosen = np.concatenate([pressures, collisions])
        self.scale = np.concatenate([scale.ravel()[pressures], np.ones(len(collisions))])
        self.pressures = len(pressures)
        self.held_collision_sd = forcing.collision_sd if len(collisions) else None

    def gram(self, first: Array, second: Array) -> Array:
        """first' W second of the inputs there are, (i, i)."""
        whole = _engine.toeplitz_gram(first, second, self.weights)
        chosen: Array = np.asarray(whole)[np.ix_(self.chosen, self.chosen)]
        chosen *= self.scale[:, None]
        chosen *= self.scale
        return chosen

    def gathered(self, lags: Array, rows: Array) -> Array:
        """lags' rows of the inputs there are, (i, k); rows (N, m, k) or (N, m)."""
        flat = np.ascontiguousarray(rows.reshape(self.weights.size, -1))
        whole = np.asarray(_engine.toeplitz_transposed_product(lags, flat))
        gathered: Array = whole[self.chosen] * self.scale[:, None]
        return gathered

    def spread(self, lags: Array, inputs: Array) -> Array:
        """lags times inputs (i), (N, m)."""
        whole = np.zeros((self.weights.shape[0] * lags.shape[2], 1))
        whole[self.chosen, 0] = self.scale * inputs
        return np.asarray(_engine.toeplitz_product(lags, whole)).reshape(self.weights.shape)


class Solved:
    """S = Q^-1 + T' W T at one point, and what follows from its factor."""

    def __init__(
        self,
        space: InputSpace,
        mean: Array,
        lags: Array,
        error: Array,
        gram: Array,
        projected: Array,
        noise: Noise,
    ) -> None:
        self.mean, self.lags, self.noise = mean, lags, noise
        weights, n = space.weights, space.count
        p, c = space.pressures, len(space.chosen) - space.pressures
        held = space.held_collision_sd
        ratios = np.array([noise.pressure, noise.collision if held is None else held]) / noise.flow
        least = 1e-20 / max(
            float(np.abs(np.diag(gram)).max(initial=0.0)), 1e-300
        )  # a level of zero: no input
        self.prior_variance = np.maximum(np.repeat(np.square(ratios), [p, c]), least)
        S = gram + np.diag(1 / self.prior_variance)
        self._factor = linalg.cho_factor(S, lower=True)
        self.inputs: Array = linalg.cho_solve(self._factor, projected)
        spread = space.spread(lags, self.inputs)
        self.residual = np.where(weights > 0, error - spread, 0.0)
        square = float(np.sum(weights * error * self.residual))
        log_det = 2 * float(np.log(np.diag(self._factor[0])).sum()) + float(np.log(self.prior_variance).sum())
        log_weights = float(np.log(weights[weights > 0]).sum())
        self.value = -0.5 * (
            n * math.log(2 * math.pi * noise.flow**2) - log_weights + log_det + square / noise.flow**2
        )

    @property
    def inverse(self) -> Array:
        """S^-1, (i, i)."""
        if not hasattr(self, "_inverse"):
            self._inverse = self.solve(np.eye(len(self.prior_variance)))
        return self._inverse

    def solve(self, right: Array) -> Array:
        """S^-1 right."""
        solved: Array = linalg.cho_solve(self._factor, right)
        return solved
