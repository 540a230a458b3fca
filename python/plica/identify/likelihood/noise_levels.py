"""Maximum likelihood estimates of the noise levels at one point of the tissue parameters."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import linalg, optimize

from plica.errors import InvalidInput
from plica.identify.likelihood.level_search import LevelDensity, minimum

__all__ = ["Noise", "profiled"]

Array = NDArray[np.float64]
_RATIOS = (-10.0, 30.0)
"""Search range of log(sigma_p^2 / sigma_v^2), relative to -log of the largest eigenvalue of T' W T."""
_RATIOS_OF_SEVERAL = (-12.0, 25.0)
"""The same for several levels, relative to -log of the mean diagonal of T' W T of each class."""


@dataclass(frozen=True)
class Noise:
    """Noise levels; the default: no unknown pressure, errors as stated."""

    pressure: float = 0.0
    """[Pa] sigma_p"""
    flow: float = 1.0
    """[-] sigma_v, a factor on the observation's sd"""
    collision: float = 0.0
    """[Pa] sigma_c"""
    gain: float = 0.0
    """[-] sigma_g, of the gains of the flow's points"""
    at_least: tuple[str, ...] = ()
    """Names of levels at the lower bound of their search: effectively zero."""
    at_most: tuple[str, ...] = ()
    """Names of levels at the upper bound: effectively infinite compared with the flow's error."""

    def __post_init__(self) -> None:
        for name, unit in (("pressure", " Pa"), ("flow", ""), ("collision", " Pa"), ("gain", "")):
            value = getattr(self, name)
            if not (math.isfinite(value) and value >= 0):
                raise InvalidInput(f"Noise: {name} = {value:g}{unit}; must be a number >= 0.")

    def sentences(self) -> list[str]:
        """A warning for each level at a bound of its search."""
        kinds = {"pressure": "unknown pressures", "collision": "forces of closed frames"}
        low = [
            f"The level of the {kinds[name]} is at the lower bound of its search: the recording shows none "
            "of them, and the intervals assume that there are none."
            for name in self.at_least
        ]
        return low + [
            f"The level of the {kinds[name]} is at the upper bound of its search: they can follow the motion "
            "with any tissue, so neither they nor the flow's error are determined. Use fewer patterns or "
            "more points."
            for name in self.at_most
        ]


def profiled(
    gram: Array,
    projected: Array,
    square: float,
    count: int,
    classes: tuple[int, int, int],
    fixed: float | None,
) -> Noise:
    """The levels that maximise the likelihood, to round-off.

    Parameters
    ----------
    gram, projected, square : T' W T (i, i), T' W e (i) and e' W e
    count : number of observed values
    classes : numbers of inputs that are pressures, forces of collisions, and gains of the flow's points
    fixed : sigma_c (Pa) if it is fixed
    """
    p, c, g = classes
    if not gram.any():
        return Noise(0.0, math.sqrt(square / count), fixed or 0.0)
    ends = np.cumsum([0, *classes])
    parts = [slice(int(ends[k]), int(ends[k + 1])) for k in range(3)]
    if not c and not g:
        return _of_one_class(gram, projected, square, count)
    known = fixed is not None and c > 0
    free = [k for k in range(3) if classes[k] and not (k == 1 and known)]
    density = LevelDensity(
        gram,
        projected,
        square,
        count,
        [parts[k] for k in free],
        parts[1] if known else slice(0, 0),
        fixed if fixed is not None else 1.0,
    )
    middle = [-math.log(max(float(np.diag(gram)[parts[k]].mean()), 1e-300)) for k in free]
    plain = math.log(square / count)
    bounds = [(m + _RATIOS_OF_SEVERAL[0], m + _RATIOS_OF_SEVERAL[1]) for m in middle] + [
        (plain - 30, plain + 5)
    ]
    if g:
        within = p + c
        near = profiled(gram[:within, :within], projected[:within], square, count, (p, c, 0), fixed)
        likely = _logs(near, [k for k in free if k < 2])
        starts = [[*likely, middle[-1] + shift, 2 * math.log(near.flow)] for shift in (0.0, 6.0)]
    elif known:
        near = profiled(gram, projected, square, count, classes, None)
        starts = [[*_logs(near, free), 2 * math.log(near.flow)], [*(m + 2 for m in middle), plain]]
    else:
        ratios = [np.array(middle) + shift for shift in (2.0, 10.0)]
        starts = [[*r, density.flow_level(r)] for r in ratios]
    found = [minimum(density, np.array(start), bounds) for start in starts]
    logs = min(found, key=lambda end: end[1])[0]
    return _noise(logs, free, bounds, fixed if known else None)


def _of_one_class(gram: Array, projected: Array, square: float, count: int) -> Noise:
    """For pressures alone: in the eigenbasis of T' W T the slope is a sum, whose root is bracketed."""
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
    """log(sigma^2 / sigma_v^2) of the classes."""
    return [2 * math.log(max(getattr(noise, _NAMES[k]), 1e-150) / noise.flow) for k in classes]


def _noise(logs: Array, free: list[int], bounds: Sequence[tuple[float, float]], fixed: float | None) -> Noise:
    """The levels from the logarithms of the free ones, that of the flow last. Levels within 0.01 of a bound
    are named, except that of the gains, which may be zero."""
    flow = math.exp(0.5 * logs[-1])
    levels, at_least, at_most = [0.0, fixed or 0.0, 0.0], [], []
    for k, log_ratio, (low, high) in zip(free, logs, bounds, strict=False):
        levels[k] = flow * math.exp(0.5 * log_ratio)
        if k < 2 and log_ratio <= low + 0.01:
            at_least.append(_NAMES[k])
        if k < 2 and log_ratio >= high - 0.01:
            at_most.append(_NAMES[k])
    return Noise(levels[0], flow, levels[1], levels[2], tuple(at_least), tuple(at_most))
