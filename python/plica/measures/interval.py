"""Bootstrap intervals of what is averaged over cycles, and of its difference between two recordings.

Cycles are drawn with replacement; from thirty on in blocks of n^(1/3) that follow each other (the last one
by the first: Politis and Romano, 1992), since neighbours are alike. What noise of the frames does to single
cycles is part of their scatter and so of the interval; what it does to all of them alike is not. A
percentile interval of few cycles is too narrow: its levels are those of Hesterberg's expanded percentiles
(Am. Stat. 69, 2015), the normal distribution at sqrt(n / (n - 1)) times Student's quantile, n being the
number of blocks.

The interval of a difference is that of the differences between both recordings' replicates, drawn
independently: never what two intervals leave between them. Each side's replicates are first spread by its
own sqrt(n / (n - 1)), and Student's quantile is that of Welch's degrees of freedom,
(v + w)^2 / (v^2 / (n - 1) + w^2 / (m - 1)) for variances v, w of n and m blocks. Where one side does not
scatter, it is the interval of the other.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from plica.measures.record import Floats

__all__ = ["Replicates", "difference_interval", "of_mean", "of_ratio", "of_slope"]

coverage = 0.95
_DRAWS = 2000
_SEED = 20210
_MANY = 30  # cycles from which blocks are drawn


@dataclass(frozen=True, eq=False)
class Replicates:
    """What a value over n blocks of cycles comes to when they are drawn again and again.

    Attributes
    ----------
    values : (draws)
        In the order of the draws, which is no order.
    blocks : float
        n, >= 3.
    """

    values: Floats
    blocks: float

    @cached_property
    def interval(self) -> tuple[float, float]:
        """Of the value at 95 %: expanded percentiles."""
        return _ends(self.values, np.sqrt(self.blocks / (self.blocks - 1)), self.blocks - 1)

    def mapped(self, change: Callable[[Floats], Floats]) -> Replicates:
        """Those of a function of the value."""
        return Replicates(change(self.values), self.blocks)


def difference_interval(before: Replicates, after: Replicates) -> tuple[float, float]:
    """Of `after` less `before` at 95 %, both from cycles of their own (the rule stands at the head)."""
    sides, variances, freedoms = [], [], []
    for side in (before, after):
        wide = np.sqrt(side.blocks / (side.blocks - 1))
        sides.append(side.values.mean() + wide * (side.values - side.values.mean()))
        variances.append(float(sides[-1].var()))
        freedoms.append(side.blocks - 1)
    # Equal numbers of cycles are drawn alike: shuffled, two recordings have nothing in common.
    random = np.random.default_rng([_SEED, 2])
    first, second = (random.choice(side, _DRAWS, replace=side.size < _DRAWS) for side in sides)
    together = sum(variances)
    parts = sum(part**2 / freedom for part, freedom in zip(variances, freedoms, strict=True))
    return _ends(second - first, 1.0, together**2 / parts if parts else min(freedoms))


def of_mean(values: Floats) -> Replicates | None:
    """Of the mean of one value per cycle; None for fewer than three."""
    return of_ratio(values, np.ones(values.size))


def of_slope(values: Floats) -> Replicates | None:
    """Of the slope of the line through the values of successive cycles over their mean; None for fewer than
    four. Cycles are drawn with their numbers."""
    n = values.size
    if n < 4:
        return None
    drawn = np.random.default_rng([_SEED, n, 1]).integers(0, n, (_DRAWS, n))
    drawn = drawn[np.ptp(drawn, axis=1) > 0]
    number, value = drawn - drawn.mean(axis=1, keepdims=True), values[drawn]
    return Replicates((number * value).sum(axis=1) / (number**2).sum(axis=1) / value.mean(axis=1), n)


def of_ratio(top: Floats, bottom: Floats) -> Replicates | None:
    """Of sum(top) / sum(bottom) over cycles, each drawn as a pair; None for fewer than three.

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
    drawn = ((begins[..., None] + np.arange(length)) % n).reshape(_DRAWS, -1)[:, :n]
    bottoms = bottom[drawn].sum(axis=1)
    return Replicates(top[drawn].sum(axis=1)[bottoms != 0] / bottoms[bottoms != 0], n / length)


def _ends(found: Floats, wide: float, freedom: float) -> tuple[float, float]:
    """Percentiles of what was drawn at the normal levels of so many times Student's quantile."""
    from scipy import special

    tail = float(special.ndtr(wide * special.stdtrit(freedom, (1 - coverage) / 2)))
    low, high = np.quantile(found, [tail, 1 - tail])
    return float(low), float(high)
