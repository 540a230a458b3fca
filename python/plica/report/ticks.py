"""Ticks of an axis: round numbers and how they are written."""

from __future__ import annotations

import math
from dataclasses import dataclass

__all__ = ["Ticks", "linear_ticks", "log_ticks"]

_ROUND = (1.0, 2.0, 2.5, 5.0, 10.0)
_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


@dataclass(frozen=True)
class Ticks:
    """Where ticks are, as shares of the axis, and their texts."""

    shares: list[float]
    labels: list[str]


def linear_ticks(low: float, high: float, most: float) -> Ticks:
    """Multiples of the smallest of 1, 2, 2.5 and 5 times a power of ten of which at most `most` (two or more)
    fit between low and high."""
    least = (high - low) / max(most, 2.0)
    power = 10.0 ** math.floor(math.log10(least))
    step = next(factor * power for factor in _ROUND if factor * power >= least * (1 - 1e-9))
    slack = 1e-9 * (high - low) / step
    numbers = range(math.ceil(low / step - slack), math.floor(high / step + slack) + 1)
    return Ticks([(k * step - low) / (high - low) for k in numbers], _linear_labels(numbers, step))


def _linear_labels(numbers: range, step: float) -> list[str]:
    largest = max((abs(k * step) for k in numbers), default=0.0)
    if largest and not 1e-3 <= largest < 1e5:
        power = math.floor(math.log10(largest))
        raised = str(power).translate(_RAISED)
        scaled = (f"{k * step / 10.0**power:.3g}" for k in numbers)
        return [f"{text}·10{raised}".replace("-", "−") if text != "0" else "0" for text in scaled]
    digits = next(n for n in range(9) if abs(step - round(step, n)) < 1e-6 * step)
    return [f"{k * step:.{digits}f}".replace("-", "−") if k else "0" for k in numbers]


def log_ticks(low: float, high: float, most: float) -> Ticks:
    """Powers of ten between low and high (> 0), every one or every few; if there are fewer than two, as
    `linear_ticks`, where they are on the logarithmic axis."""
    first, last = math.ceil(math.log10(low) - 1e-9), math.floor(math.log10(high) + 1e-9)
    width = math.log10(high / low)
    if last - first < 1:
        even = linear_ticks(low, high, most)
        values = [low + share * (high - low) for share in even.shares]
        return Ticks([math.log10(value / low) / width for value in values], even.labels)
    stride = max(1, math.ceil((last - first + 1) / max(most, 2.0)))
    powers = range(first, last + 1, stride)
    labels = [f"10{str(power).translate(_RAISED)}" for power in powers]
    return Ticks([(power - math.log10(low)) / width for power in powers], labels)
