"""Bootstrap intervals of averages over cycles, and of their differences between two recordings.

Cycles are resampled with replacement; from thirty cycles on in circular blocks of n^(1/3) (Politis and
Romano, 1992), since neighbours are correlated. The interval includes noise of the frames that affects single
cycles, but not noise that affects all of them alike. A percentile interval of few cycles is too narrow: the
levels are those of Hesterberg's expanded percentiles (Am. Stat. 69, 2015), the normal distribution at sqrt(n
/ (n - 1)) times Student's quantile, with n the number of blocks.

The interval of a difference is that of the differences between the replicates of both recordings, resampled
independently; it does not follow from the two intervals. The replicates of each side are first scaled by its
sqrt(n / (n - 1)), and Student's quantile is that of Welch's degrees of freedom,
(v + w)^2 / (v^2 / (n - 1) + w^2 / (m - 1)) for variances v, w of n and m blocks. If one side has no scatter,
it is the interval of the other.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from plica.measures.record import Floats

__all__ = ["Replicates", "difference_interval", "of_mean", "of_ratio", "of_slope"]

coverage = 0.95
_DRAWS = 2000
_SEED = 20210
_MANY = 30  # cycles from which blocks are used


@dataclass(frozen=True, eq=False)
class Replicates:
    """Bootstrap replicates of a value over n blocks of cycles.

    Attributes
    ----------
    values : (draws)
        In the order of the draws.
    blocks : float
        n, >= 3.
    """

    values: Floats
    blocks: float

    @cached_property
    def interval(self) -> tuple[float, float]:
        """95 % interval of the value, by expanded percentiles."""
        return _ends(self.values, np.sqrt(self.blocks / (self.blocks - 1)), self.blocks - 1)

    @property
    def tail(self) -> float:
        """Share of the replicates below the interval, and above: less than 2.5 % where blocks are few."""
        return _tail(np.sqrt(self.blocks / (self.blocks - 1)), self.blocks - 1)

    def mapped(self, change: Callable[[Floats], Floats]) -> Replicates:
        """Replicates of a function of the value."""
        return Replicates(change(self.values), self.blocks)


def difference_interval(before: Replicates, after: Replicates) -> tuple[float, float]:
    """95 % interval of `after` minus `before` (see the module docstring)."""
    sides, variances, freedoms = [], [], []
    for side in (before, after):
        wide = np.sqrt(side.blocks / (side.blocks - 1))
        sides.append(side.values.mean() + wide * (side.values - side.values.mean()))
        variances.append(float(sides[-1].var()))
        freedoms.append(side.blocks - 1)
    # Equal numbers of cycles have identical draws; shuffling makes both sides independent.
    random = np.random.default_rng([_SEED, 2])
    first, second = (random.choice(side, _DRAWS, replace=side.size < _DRAWS) for side in sides)
    together = sum(variances)
    parts = sum(part**2 / freedom for part, freedom in zip(variances, freedoms, strict=True))
    return _ends(second - first, 1.0, together**2 / parts if parts else min(freedoms))


def of_mean(values: Floats) -> Replicates | None:
    """Replicates of the mean of one value per cycle; None for fewer than three."""
    return of_ratio(values, np.ones(values.size))


def of_slope(places: npt.NDArray[np.int_], values: Floats) -> Replicates | None:
    """Replicates of the slope of the line through the values (n) of the cycles with these numbers (n),
    divided by their mean; None for fewer than four. Cycles are drawn with their numbers."""
    n = values.size
    if n < 4:
        return None
    indices = np.random.default_rng([_SEED, n, 1]).integers(0, n, (_DRAWS, n))
    indices = indices[np.ptp(indices, axis=1) > 0]
    number, value = places[indices] - places[indices].mean(axis=1, keepdims=True), values[indices]
    return Replicates((number * value).sum(axis=1) / (number**2).sum(axis=1) / value.mean(axis=1), n)


def of_ratio(top: Floats, bottom: Floats) -> Replicates | None:
    """Replicates of sum(top) / sum(bottom) over cycles, drawn as pairs; None for fewer than three.

    Parameters
    ----------
    top, bottom : (n), finite
    """
    n = top.size
    if n < 3:
        return None
    length = round(n ** (1 / 3)) if n >= _MANY else 1
    random = np.random.default_rng([_SEED, n])
    begins = random.integers(0, n, (_DRAWS, -(-n // length)))
    indices = ((begins[..., None] + np.arange(length)) % n).reshape(_DRAWS, -1)[:, :n]
    bottoms = bottom[indices].sum(axis=1)
    return Replicates(top[indices].sum(axis=1)[bottoms != 0] / bottoms[bottoms != 0], n / length)


def _ends(found: Floats, wide: float, freedom: float) -> tuple[float, float]:
    """Percentiles of the draws at the normal levels of `wide` times Student's quantile."""
    tail = _tail(wide, freedom)
    low, high = np.quantile(found, [tail, 1 - tail])
    return float(low), float(high)


def _tail(wide: float, freedom: float) -> float:
    from scipy import special

    return float(special.ndtr(wide * special.stdtrit(freedom, (1 - coverage) / 2)))
