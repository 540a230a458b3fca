"""Bootstrap intervals of what is averaged over cycles.

Cycles are drawn with replacement; from thirty on in blocks of n^(1/3) that follow each other (the last one
by the first: Politis and Romano, 1992), since neighbours are alike. What noise of the frames does to single
cycles is part of their scatter and so of the interval; what it does to all of them alike is not. A
percentile interval of few cycles is too narrow: its levels are those of Hesterberg's expanded percentiles
(Am. Stat. 69, 2015), the normal distribution at sqrt(n / (n - 1)) times Student's quantile, n being the
number of blocks.
"""

from __future__ import annotations

import numpy as np

from plica.measures.record import Floats

coverage = 0.95
_DRAWS = 2000
_SEED = 20210
_MANY = 30  # cycles from which blocks are drawn


def mean_interval(values: Floats) -> tuple[float, float] | None:
    """Of the mean of one value per cycle; None for fewer than three."""
    return ratio_interval(values, np.ones(values.size))


def slope_interval(values: Floats) -> tuple[float, float] | None:
    """Of the slope of the line through the values of successive cycles over their mean; None for fewer than
    four. Cycles are drawn with their numbers."""
    n = values.size
    if n < 4:
        return None
    drawn = np.random.default_rng([_SEED, n, 1]).integers(0, n, (_DRAWS, n))
    drawn = drawn[np.ptp(drawn, axis=1) > 0]
    number, value = drawn - drawn.mean(axis=1, keepdims=True), values[drawn]
    return _ends((number * value).sum(axis=1) / (number**2).sum(axis=1) / value.mean(axis=1), n)


def ratio_interval(top: Floats, bottom: Floats) -> tuple[float, float] | None:
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
    return _ends(top[drawn].sum(axis=1)[bottoms != 0] / bottoms[bottoms != 0], n / length)


def _ends(found: Floats, n: float) -> tuple[float, float]:
    """The expanded percentiles of what was drawn of n blocks."""
    from scipy import special

    tail = float(special.ndtr(np.sqrt(n / (n - 1)) * special.stdtrit(n - 1, (1 - coverage) / 2)))
    low, high = np.quantile(found, [tail, 1 - tail])
    return float(low), float(high)
