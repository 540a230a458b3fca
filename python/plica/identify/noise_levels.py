"""The levels of the noises that make a recording most probable at one tissue."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import linalg, optimize

__all__ = ["Noise", "profiled"]

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Noise:
    """The levels of the two noises."""

    pressure: float
    """[Pa] sigma_p"""
    flow: float
    """[-] sigma_v, a factor on the observation's sd"""
    collision: float = 0.0
    """[Pa] sigma_c"""


def profiled(
    gram: Array, projected: Array, square: float, count: int, pressures: int, held: float | None
) -> Noise:
    """The levels of the highest likelihood: their ratios are searched, sigma_v is closed.

    Parameters
    ----------
    gram, projected, square : T' W T (i, i), T' W e (i) and e' W e
    count : of what is seen
    pressures : how many inputs come first; the others are forces of collisions
    held : the ratio sigma_c / sigma_v where it is not estimated
    """
    p = pressures
    if len(gram) > p and held is None:
        return _profiled_with_collisions(gram, projected, square, count, p)
    inner, right = gram[:p, :p], projected[:p]
    if len(gram) > p and held is not None:  # these go first: their ratio to sigma_v does not change
        factor = linalg.cho_factor(gram[p:, p:] + np.eye(len(gram) - p) / held**2, lower=True)
        inner = inner - gram[:p, p:] @ linalg.cho_solve(factor, gram[p:, :p])
        right = right - gram[:p, p:] @ linalg.cho_solve(factor, projected[p:])
        square = square - projected[p:] @ linalg.cho_solve(factor, projected[p:])
    if not p or not inner.any():
        flow = math.sqrt(square / count)
        return Noise(0.0, flow, (held or 0.0) * flow)
    values, vectors = linalg.eigh(inner)
    values, squares = np.maximum(values, 0), (vectors.T @ right) ** 2

    def level(log_ratio: float) -> float:
        ratio = math.exp(log_ratio)
        return (square - float(np.sum(squares * ratio / (1 + ratio * values)))) / count

    def cost(log_ratio: float) -> float:
        variance = level(log_ratio)
        if variance <= 0:
            return math.inf
        return count * math.log(variance) + float(np.log1p(math.exp(log_ratio) * values).sum())

    grid = -math.log(values[-1]) + np.linspace(-10, 30, 41)
    best = int(np.argmin([cost(g) for g in grid]))
    low, high = grid[max(best - 1, 0)], grid[min(best + 1, len(grid) - 1)]
    found = optimize.minimize_scalar(cost, bounds=(low, high), method="bounded", options={"xatol": 1e-9})
    flow = math.sqrt(level(found.x))
    return Noise(flow * math.exp(0.5 * found.x), flow, (held or 0.0) * flow)


def _profiled_with_collisions(gram: Array, projected: Array, square: float, count: int, p: int) -> Noise:
    """Both ratios at once, by the likelihood's gradient: w' Q^-1 w / sigma_v^2 - (i - tr S^-1 Q^-1) a
    class."""
    i = len(gram)
    classes = [k for k in (slice(0, p), slice(p, i)) if k.stop > k.start]
    middle = -math.log(float(np.diag(gram).mean()))

    def cost(logs: Array) -> tuple[float, Array]:
        inverse_Q = np.empty(i)
        for k, log_ratio in zip(classes, logs, strict=True):
            inverse_Q[k] = math.exp(-log_ratio)
        factor = linalg.cho_factor(gram + np.diag(inverse_Q), lower=True)
        w = linalg.cho_solve(factor, projected)
        variance = (square - float(projected @ w)) / count
        shares = inverse_Q * np.diag(linalg.cho_solve(factor, np.eye(i)))
        log_det = 2 * float(np.log(np.diag(factor[0])).sum()) - float(np.log(inverse_Q).sum())
        value = count * math.log(variance) + log_det
        gradient = [
            float(np.sum(1 - shares[k]) - np.sum(w[k] ** 2 * inverse_Q[k]) / variance) for k in classes
        ]
        return value, np.array(gradient)

    bounds = [(middle - 12, middle + 25)] * len(classes)
    starts = [np.full(len(classes), middle + shift) for shift in (2.0, 10.0)]
    ends = [
        optimize.minimize(
            cost, start, jac=True, method="L-BFGS-B", bounds=bounds, options={"ftol": 1e-15, "gtol": 1e-7}
        )
        for start in starts
    ]
    logs = min(ends, key=lambda end: float(end.fun)).x
    ratios = dict(zip([k.start for k in classes], np.exp(0.5 * logs), strict=True))
    pressure, collision = (float(ratios.get(0, 0.0)) if p else 0.0), float(ratios[p])
    inverse_Q = np.concatenate([np.full(p, pressure**-2.0 if p else 0.0), np.full(i - p, collision**-2.0)])
    w = linalg.solve(gram + np.diag(inverse_Q), projected, assume_a="pos")
    flow = math.sqrt((square - float(projected @ w)) / count)
    return Noise(pressure * flow, flow, collision * flow)
