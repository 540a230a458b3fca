"""The levels of the noises that make a recording most probable at one tissue."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import linalg, optimize

__all__ = ["Noise", "profiled"]

Array = NDArray[np.float64]
_RATIOS = (-10.0, 30.0)
"""Of log(sigma_p^2 / sigma_v^2) times the largest eigenvalue of T' W T: its search."""
_RATIOS_BESIDE = (-12.0, 25.0)
"""The same where there are two levels, times the mean of the diagonal."""


@dataclass(frozen=True)
class Noise:
    """The levels of the noises."""

    pressure: float
    """[Pa] sigma_p"""
    flow: float
    """[-] sigma_v, a factor on the observation's sd"""
    collision: float = 0.0
    """[Pa] sigma_c"""
    gain: float = 0.0
    """[-] sigma_g, of the gains of the flow's points"""
    at_least: tuple[str, ...] = ()
    """Levels, by name, that ended at the lower bound of their search: as good as zero."""
    at_most: tuple[str, ...] = ()
    """Levels that ended at the upper bound: as good as infinite beside the flow's error."""

    def sentences(self) -> list[str]:
        """What a level at a bound of its search means."""
        kinds = {"pressure": "unknown pressures", "collision": "forces of closed frames"}
        told = [
            f"The level of the {kinds[name]} came out at the lower end of its search: the recording shows "
            "none of them, and the intervals count on there being none."
            for name in self.at_least
        ]
        return told + [
            f"The level of the {kinds[name]} came out at the upper end of its search: they follow the motion "
            "whatever the tissue is, so that neither they nor the flow's error are known. Take fewer "
            "patterns or more points."
            for name in self.at_most
        ]


def profiled(
    gram: Array,
    projected: Array,
    square: float,
    count: int,
    classes: tuple[int, int, int],
    held: float | None,
) -> Noise:
    """The levels of the highest likelihood: their ratios are searched, sigma_v is closed.

    Parameters
    ----------
    gram, projected, square : T' W T (i, i), T' W e (i) and e' W e
    count : of what is seen
    classes : how many inputs are pressures, forces of collisions, and gains of the flow's points
    held : sigma_c (Pa) where it is not estimated
    """
    p, c, g = classes
    if g:
        near = profiled(gram[: p + c, : p + c], projected[: p + c], square, count, (p, c, 0), held)
        return _profiled_with_gains(gram, projected, square, count, classes, held, near)
    if len(gram) > p:
        free = _profiled_with_collisions(gram, projected, square, count, p)
        return free if held is None else _profiled_beside(gram, projected, square, count, p, held, free)
    if not p or not gram.any():
        return Noise(0.0, math.sqrt(square / count))
    values, vectors = linalg.eigh(gram)
    values, squares = np.maximum(values, 0), (vectors.T @ projected) ** 2

    def level(log_ratio: float) -> float:
        ratio = math.exp(log_ratio)
        return (square - float(np.sum(squares * ratio / (1 + ratio * values)))) / count

    def cost(log_ratio: float) -> float:
        variance = level(log_ratio)
        if variance <= 0:
            return math.inf
        return count * math.log(variance) + float(np.log1p(math.exp(log_ratio) * values).sum())

    grid = -math.log(values[-1]) + np.linspace(*_RATIOS, 41)
    best = int(np.argmin([cost(g) for g in grid]))
    low, high = grid[max(best - 1, 0)], grid[min(best + 1, len(grid) - 1)]
    found = optimize.minimize_scalar(cost, bounds=(low, high), method="bounded", options={"xatol": 1e-9})
    flow = math.sqrt(level(found.x))
    ends = _ends({"pressure": float(found.x)}, (grid[0], grid[-1]))
    return Noise(flow * math.exp(0.5 * found.x), flow, 0.0, 0.0, *ends)


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

    bounds = [(middle + _RATIOS_BESIDE[0], middle + _RATIOS_BESIDE[1])] * len(classes)
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
    names = ("pressure", "collision") if p else ("collision",)
    found = dict(zip(names, logs.tolist(), strict=True))
    return Noise(pressure * flow, flow, collision * flow, 0.0, *_ends(found, bounds[0]))


def _profiled_beside(
    gram: Array, projected: Array, square: float, count: int, p: int, held: float, near: Noise
) -> Noise:
    """sigma_p and sigma_v beside a known sigma_c (Pa), whose ratio to sigma_v moves with sigma_v.

    By the gradient of -2 log p in log(sigma_p^2 / sigma_v^2) and log sigma_v^2, from the levels near which
    the likelihood is highest where sigma_c is free, and from flow of its plain size.
    """
    i = len(gram)

    def cost(logs: Array) -> tuple[float, Array]:
        variance = math.exp(logs[-1])
        inverse_Q = np.full(i, variance / held**2)
        inverse_Q[:p] = math.exp(-logs[0]) if p else 0.0
        factor = linalg.cho_factor(gram + np.diag(inverse_Q), lower=True)
        w = linalg.cho_solve(factor, projected)
        shares = inverse_Q * np.diag(linalg.cho_solve(factor, np.eye(i)))
        by_level = 1 - shares - w**2 * inverse_Q / variance  # of -2 log p by each log Q
        misfit = (square - float(projected @ w)) / variance
        log_det = 2 * float(np.log(np.diag(factor[0])).sum()) - float(np.log(inverse_Q).sum())
        gradient = [float(by_level[:p].sum())] if p else []
        return count * logs[-1] + log_det + misfit, np.array(
            [*gradient, count - misfit - float(by_level[p:].sum())]
        )

    middle, plain = -math.log(float(np.diag(gram).mean())), math.log(square / count)
    bounds = [(middle + _RATIOS_BESIDE[0], middle + _RATIOS_BESIDE[1])] * bool(p) + [(plain - 30, plain + 5)]
    likely = 2 * math.log(max(near.pressure, 1e-150) / near.flow)
    starts = [[likely] * bool(p) + [2 * math.log(near.flow)], [middle + 2] * bool(p) + [plain]]
    ends = [
        optimize.minimize(
            cost,
            np.clip(start, *np.transpose(bounds)),
            jac=True,
            method="L-BFGS-B",
            bounds=bounds,
            options={"ftol": 1e-15, "gtol": 1e-7},
        )
        for start in starts
    ]
    logs = min(ends, key=lambda end: float(end.fun)).x
    flow = math.exp(0.5 * logs[-1])
    found = {"pressure": float(logs[0])} if p else {}
    return Noise(flow * math.exp(0.5 * logs[0]) if p else 0.0, flow, held, 0.0, *_ends(found, bounds[0]))


def _profiled_with_gains(
    gram: Array,
    projected: Array,
    square: float,
    count: int,
    sizes: tuple[int, int, int],
    held: float | None,
    near: Noise,
) -> Noise:
    """All levels at once, by the gradient of -2 log p in the free log(sigma^2 / sigma_v^2) and log sigma_v^2,
    from those without gains. A level of the gains at the lower bound is none."""
    ends = np.cumsum([0, *sizes])
    free = [k for k in range(3) if sizes[k] and not (k == 1 and held is not None)]
    classes = [slice(ends[k], ends[k + 1]) for k in free]
    fixed = slice(ends[1], ends[2]) if held is not None else slice(0, 0)

    def cost(logs: Array) -> tuple[float, Array]:
        variance = math.exp(logs[-1])
        inverse_Q = np.full(len(gram), 1.0 if held is None else variance / held**2)
        for k, log_ratio in zip(classes, logs, strict=False):
            inverse_Q[k] = math.exp(-log_ratio)
        factor = linalg.cho_factor(gram + np.diag(inverse_Q), lower=True)
        w = linalg.cho_solve(factor, projected)
        shares = inverse_Q * np.diag(linalg.cho_solve(factor, np.eye(len(gram))))
        by_level = 1 - shares - w**2 * inverse_Q / variance  # of -2 log p by each log Q
        misfit = (square - float(projected @ w)) / variance
        log_det = 2 * float(np.log(np.diag(factor[0])).sum()) - float(np.log(inverse_Q).sum())
        last = count - misfit - float(by_level[fixed].sum())
        gradient = np.array([*(float(by_level[k].sum()) for k in classes), last])
        return count * logs[-1] + log_det + misfit, gradient

    middle = [-math.log(max(float(np.diag(gram)[k].mean()), 1e-300)) for k in classes]
    plain = math.log(square / count)
    bounds = [(m + _RATIOS_BESIDE[0], m + _RATIOS_BESIDE[1]) for m in middle] + [(plain - 30, plain + 5)]
    known = {0: near.pressure, 1: near.collision}
    likely = [2 * math.log(max(known[k], 1e-150) / near.flow) for k in free if k in known]
    found = [
        optimize.minimize(
            cost,
            np.clip([*likely, middle[-1] + shift, 2 * math.log(near.flow)], *np.transpose(bounds)),
            jac=True,
            method="L-BFGS-B",
            bounds=bounds,
            options={"ftol": 1e-15, "gtol": 1e-7},
        )
        for shift in (0.0, 6.0)
    ]
    logs = min(found, key=lambda end: float(end.fun)).x
    flow = math.exp(0.5 * logs[-1])
    levels = [0.0, held or 0.0, 0.0]
    names = ("pressure", "collision")
    at_end: list[tuple[str, ...]] = [(), ()]
    for k, log_ratio, bound in zip(free, logs, bounds, strict=False):
        levels[k] = flow * math.exp(0.5 * log_ratio)
        if k < 2:
            low, high = _ends({names[k]: float(log_ratio)}, bound)
            at_end = [at_end[0] + low, at_end[1] + high]
    return Noise(levels[0], flow, levels[1], levels[2], at_end[0], at_end[1])


def _ends(found: dict[str, float], bounds: tuple[float, float]) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Names of the log ratios found within a hundredth of the lower and of the upper bound."""
    low, high = bounds
    least = tuple(name for name, log_ratio in found.items() if log_ratio <= low + 0.01)
    return least, tuple(name for name, log_ratio in found.items() if log_ratio >= high - 0.01)
