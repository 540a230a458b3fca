"""Quantiles of Student's t and Fisher's F: of a whole statistics library, all that finding cycles needs."""

from __future__ import annotations

import math
from functools import lru_cache

__all__ = ["fisher", "student"]


def student(freedom: float, share: float) -> float:
    """The value that Student's t stays below with this probability in [0.5, 1)."""
    return math.sqrt(fisher(1, freedom, 2.0 * share - 1.0))


@lru_cache(maxsize=256)
def fisher(above: float, below: float, share: float) -> float:
    """The value that Fisher's F of these degrees of freedom stays below with this probability in [0, 1).

    F = n x / (m (1 - x)) for x of a beta distribution of m / 2 and n / 2; x / (1 - x) by bisection of its
    logarithm, to the last digits of a double.
    """
    a, b = 0.5 * above, 0.5 * below
    low, high = -700.0, 700.0
    while high - low > 4e-16 * max(abs(low), abs(high), 1.0):
        middle = 0.5 * (low + high)
        if middle in (low, high):
            break
        low, high = (middle, high) if _beta_below(a, b, middle) < share else (low, middle)
    return below / above * math.exp(0.5 * (low + high))


def _beta_below(a: float, b: float, logit: float) -> float:
    """The regularised incomplete beta function I_x(a, b) at x = 1 / (1 + exp(-logit))."""
    x, y = 1.0 / (1.0 + math.exp(-logit)), 1.0 / (1.0 + math.exp(logit))
    if x > (a + 1.0) / (a + b + 2.0):
        return 1.0 - _front(b, a, y, x) * _fraction(b, a, y)
    return _front(a, b, x, y) * _fraction(a, b, x)


def _front(a: float, b: float, x: float, y: float) -> float:
    """x^a y^b / (a B(a, b)), y = 1 - x."""
    if not x > 0.0:
        return 0.0
    logarithm = math.lgamma(a + b) - math.lgamma(a) - math.lgamma(b) + a * math.log(x) + b * math.log(y)
    return math.exp(logarithm) / a


def _fraction(a: float, b: float, x: float) -> float:
    """The continued fraction of the incomplete beta function (DLMF 8.17.22), by Lentz's algorithm.

    It converges fast for x < (a + 1) / (a + b + 2).
    """
    found = numerator = 1.0
    denominator = 0.0
    for k in range(1, 10_000):
        m = k // 2
        if k % 2:
            term = -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1))
        else:
            term = m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m))
        denominator = 1.0 / (1.0 + term * denominator)
        numerator = 1.0 + term / numerator
        found *= numerator * denominator
        if abs(numerator * denominator - 1.0) < 1e-16:
            break
    return 1.0 / found
