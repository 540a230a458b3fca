"""The levels of the noises that make a recording most probable at one tissue."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import linalg, optimize

from plica.identify.level_search import LevelDensity, least

__all__ = ["Noise", "profiled"]

Array = NDArray[np.float64]
_RATIOS = (-10.0, 30.0)
"""Of log(sigma_p^2 / sigma_v^2) times the largest eigenvalue of T' W T: its search."""
_RATIOS_BESIDE = (-12.0, 25.0)
"""The same where there are several levels, times the mean of the diagonal of the class."""


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
    """The levels of the highest likelihood, to round-off.

    Parameters
    ----------
    gram, projected, square : T' W T (i, i), T' W e (i) and e' W e
    count : of what is seen
    classes : how many inputs are pressures, forces of collisions, and gains of the flow's points
    held : sigma_c (Pa) where it is not estimated
    """
    p, c, g = classes
    if not gram.any():
        return Noise(0.0, math.sqrt(square / count), held or 0.0)
    ends = np.cumsum([0, *classes])
    parts = [slice(int(ends[k]), int(ends[k + 1])) for k in range(3)]
    if not c and not g:
        return _of_one_class(gram, projected, square, count)
    known = held is not None and c > 0
    free = [k for k in range(3) if classes[k] and not (k == 1 and known)]
    density = LevelDensity(
        gram,
        projected,
        square,
        count,
        [parts[k] for k in free],
        parts[1] if known else slice(0, 0),
        held if held is not None else 1.0,
    )
    middle = [-math.log(max(float(np.diag(gram)[parts[k]].mean()), 1e-300)) for k in free]
    plain = math.log(square / count)
    bounds = [(m + _RATIOS_BESIDE[0], m + _RATIOS_BESIDE[1]) for m in middle] + [(plain - 30, plain + 5)]
    if g:
        within = p + c
        near = profiled(gram[:within, :within], projected[:within], square, count, (p, c, 0), held)
        likely = _logs(near, [k for k in free if k < 2])
        starts = [[*likely, middle[-1] + shift, 2 * math.log(near.flow)] for shift in (0.0, 6.0)]
    elif known:
        near = profiled(gram, projected, square, count, classes, None)
        starts = [[*_logs(near, free), 2 * math.log(near.flow)], [*(m + 2 for m in middle), plain]]
    else:
        ratios = [np.array(middle) + shift for shift in (2.0, 10.0)]
        starts = [[*r, density.flow_level(r)] for r in ratios]
    found = [least(density, np.array(start), bounds) for start in starts]
    logs = min(found, key=lambda end: end[1])[0]
    return _noise(logs, free, bounds, held if known else None)


def _of_one_class(gram: Array, projected: Array, square: float, count: int) -> Noise:
    """Of pressures alone: by the eigenvalues of T' W T the slope is a sum, whose root is bracketed."""
    values, vectors = linalg.eigh(gram)
    values, squares = np.maximum(values, 0), (vectors.T @ projected) ** 2

    def variance(log_ratio: float) -> float:
        ratio = math.exp(log_ratio)
        return (square - float(np.sum(squares * ratio / (1 + ratio * values)))) / count

    def cost(log_ratio: float) -> float:
        level = variance(log_ratio)
        if level <= 0:
            return math.inf
        return count * math.log(level) + float(np.log1p(math.exp(log_ratio) * values).sum())

    def slope(log_ratio: float) -> float:
        ratio = math.exp(log_ratio)
        falls = float(np.sum(squares * ratio / (1 + ratio * values) ** 2))
        return float(np.sum(ratio * values / (1 + ratio * values))) - falls / variance(log_ratio)

    grid = -math.log(values[-1]) + np.linspace(*_RATIOS, 41)
    best = int(np.argmin([cost(g) for g in grid]))
    low, high = float(grid[max(best - 1, 0)]), float(grid[min(best + 1, len(grid) - 1)])
    found = float(grid[best])
    if slope(low) < 0 < slope(high) and variance(high) > 0:
        found = float(optimize.brentq(slope, low, high, xtol=1e-14, rtol=4 * np.finfo(float).eps))
    return _noise(np.array([found, math.log(variance(found))]), [0], [(grid[0], grid[-1])], None)


_NAMES = ("pressure", "collision", "gain")


def _logs(noise: Noise, classes: list[int]) -> list[float]:
    """log(sigma^2 / sigma_v^2) of classes."""
    return [2 * math.log(max(getattr(noise, _NAMES[k]), 1e-150) / noise.flow) for k in classes]


def _noise(logs: Array, free: list[int], bounds: Sequence[tuple[float, float]], held: float | None) -> Noise:
    """From the logarithms of the free levels, that of the flow's last; a level within a hundredth of a bound
    is told, but that of the gains, which may be none."""
    flow = math.exp(0.5 * logs[-1])
    levels, at_least, at_most = [0.0, held or 0.0, 0.0], [], []
    for k, log_ratio, (low, high) in zip(free, logs, bounds, strict=False):
        levels[k] = flow * math.exp(0.5 * log_ratio)
        if k < 2 and log_ratio <= low + 0.01:
            at_least.append(_NAMES[k])
        if k < 2 and log_ratio >= high - 0.01:
            at_most.append(_NAMES[k])
    return Noise(levels[0], flow, levels[1], levels[2], tuple(at_least), tuple(at_most))
