"""-2 log p of a recording as a function of its noise levels, with exact derivatives, and its minimum.

The coordinates are log(sigma^2 / sigma_v^2) of each class of unknown inputs whose level is free, then
log sigma_v^2. With L = Q^-1, S = L + T' W T and w = S^-1 T' W e, up to a constant

    -2 log p = n log sigma_v^2 + log|S| - log|L| + (e' W e - e' W T w) / sigma_v^2 .

A class whose sigma is fixed in its own unit has an L that grows with sigma_v^2.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

__all__ = ["LevelDensity", "minimum"]

Array = NDArray[np.float64]
_LONGEST_STEP = 3.0
"""In each logarithm."""
_STEPS, _HALVINGS = 100, 30


class LevelDensity:
    """-2 log p as a function of the logarithms of the levels.

    Parameters
    ----------
    gram, projected, square : T' W T (i, i), T' W e (i) and e' W e
    count : n, number of observed values
    free : the inputs of each class whose level is free
    fixed, fixed_sd : the inputs of the class whose level is fixed, and that level
    """

    def __init__(
        self,
        gram: Array,
        projected: Array,
        square: float,
        count: int,
        free: Sequence[slice],
        fixed: slice = slice(0, 0),
        fixed_sd: float = 1.0,
    ) -> None:
        self._gram, self._projected, self._square, self._count = gram, projected, square, count
        self._free, self._fixed, self._fixed_sd = tuple(free), fixed, fixed_sd
        self._log_L_derivatives = np.zeros((len(self._free) + 1, len(gram)))  # by each coordinate
        for row, inputs in zip(self._log_L_derivatives, self._free, strict=False):
            row[inputs] = -1.0
        self._log_L_derivatives[-1, fixed] = 1.0

    def _inverse(self, logs: Array) -> Array:
        inverse = np.full(len(self._gram), math.exp(logs[-1]) / self._fixed_sd**2)
        for inputs, log_ratio in zip(self._free, logs, strict=False):
            inverse[inputs] = math.exp(-log_ratio)
        return inverse

    def flow_level(self, ratios: Array) -> float:
        """The best log sigma_v^2 at these log ratios if no level is fixed."""
        S = self._gram + np.diag(self._inverse(np.append(ratios, 0.0)))
        w = linalg.solve(S, self._projected, assume_a="pos")
        left = max(self._square - float(self._projected @ w), 1e-13 * self._square)  # not below round-off
        return math.log(left / self._count)

    def at(self, logs: Array) -> tuple[float, Array, Array]:
        """Value, gradient (k) and Hessian (k, k). O(i^3), most of it for S^-1."""
        variance, inverse_Q = math.exp(logs[-1]), self._inverse(logs)
        factor = linalg.cho_factor(self._gram + np.diag(inverse_Q), lower=True)
        inverse_S = linalg.cho_solve(factor, np.eye(len(inverse_Q)))
        w = linalg.cho_solve(factor, self._projected)
        misfit = (self._square - float(self._projected @ w)) / variance
        log_det = 2 * float(np.log(np.diag(factor[0])).sum()) - float(np.log(inverse_Q).sum())
        value = self._count * logs[-1] + log_det + misfit
        pushed = inverse_Q * w
        shares, sizes = inverse_Q * np.diag(inverse_S), w * pushed / variance
        turns = self._log_L_derivatives
        gradient = turns @ (shares - 1 + sizes)
        gradient[-1] += self._count - misfit
        mixed = np.outer(inverse_Q, inverse_Q) * inverse_S**2
        mixed += 2 / variance * np.outer(pushed, pushed) * inverse_S
        hessian = (turns * (shares + sizes)) @ turns.T - turns @ mixed @ turns.T
        falls = turns @ sizes
        hessian[-1] -= falls
        hessian[:, -1] -= falls
        hessian[-1, -1] += misfit
        return value, gradient, hessian


def minimum(
    density: LevelDensity, start: Array, bounds: Sequence[tuple[float, float]]
) -> tuple[Array, float]:
    """The minimum of -2 log p within bounds, found downhill from `start`, and the value there.

    Newton's method, downhill along directions of negative curvature too, until round-off stops it: the
    gradient is then zero to round-off in each coordinate that is not at its bound.
    """
    low, high = np.transpose(bounds)
    x = np.clip(start, low, high)
    value, gradient, hessian = density.at(x)
    for _ in range(_STEPS):
        inside = ~(((x <= low) & (gradient > 0)) | ((x >= high) & (gradient < 0)))
        if not inside.any():
            break
        step = np.zeros(len(x))
        step[inside] = _downhill(gradient[inside], hessian[np.ix_(inside, inside)])
        slack = 1e-11 * max(1.0, abs(value))  # round-off of the value
        promised = -float(gradient @ step)
        for halving in range(_HALVINGS if promised > slack else 1):
            tried = np.clip(x + 0.5**halving * step, low, high)
            there = density.at(tried)
            flatter = np.abs(there[1][inside]).max() < 0.5 * np.abs(gradient[inside]).max()
            if there[0] < value - slack or (there[0] <= value + slack and flatter):
                break
        else:
            break
        x, (value, gradient, hessian) = tried, there
    return x, value


def _downhill(gradient: Array, hessian: Array) -> Array:
    """Newton's step with the absolute values of the curvatures."""
    curvatures, directions = np.linalg.eigh(hessian)
    sizes = np.maximum(np.abs(curvatures), 1e-12 * max(1.0, float(np.abs(curvatures).max())))
    step = -(directions @ ((directions.T @ gradient) / sizes))
    return np.asarray(step * min(1.0, _LONGEST_STEP / max(float(np.abs(step).max()), 1e-300)))
