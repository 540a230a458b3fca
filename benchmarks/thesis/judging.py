"""Whether values obey a claim, given how well they are known: pass, fail or undecided."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import numpy as np

Verdict = Literal["pass", "fail", "undecided", "no value"]


@dataclass(frozen=True)
class Value:
    """A mean and its standard error; infinite where it rests on a single sample, zero where it is exact."""

    mean: float
    error: float = 0.0

    @classmethod
    def of(cls, samples: Iterable[float]) -> Value | None:
        """Of one sample a cycle; those that are not finite are left out. None without samples."""
        values = np.array([x for x in samples if np.isfinite(x)], dtype=float)
        if not values.size:
            return None
        error = np.inf if values.size < 2 else values.std(ddof=1) / np.sqrt(values.size)
        return cls(float(values.mean()), float(error))

    def over(self, other: Value) -> Value:
        """The ratio, errors of independent values carried over to first order."""
        ratio = self.mean / other.mean
        parts = [abs(v.error / v.mean) if v.mean else np.inf * v.error for v in (self, other) if v.error]
        return Value(ratio, abs(ratio) * float(np.hypot.reduce(parts)) if parts else 0.0)


def rises(values: Sequence[Value | None]) -> Verdict:
    """The last value above the first by more than twice the error of their difference, and no step down.

    One that is below the one before it by as much, or a last below the first, fails; else it is undecided.
    """
    known = [value for value in values if value is not None]
    if len(known) < len(values):
        return "no value"
    steps = [_change(first, second) for first, second in pairwise(known)]
    whole = _change(known[0], known[-1])
    if min(*steps, whole) < 0:
        return "fail"
    return "pass" if whole > 0 else "undecided"


def _change(first: Value, second: Value) -> int:
    """1 up, -1 down, 0 within twice the error of the difference."""
    change, doubt = second.mean - first.mean, 2 * float(np.hypot(first.error, second.error))
    return int(change > doubt) - int(change < -doubt)


def falls(values: Sequence[Value | None]) -> Verdict:
    """As `rises`, downward."""
    return rises(values[::-1])


def between(value: Value | None, low: float, high: float) -> Verdict:
    """Within the limits by more than twice its error, or outside by as much."""
    if value is None:
        return "no value"
    doubt = 2 * value.error
    if low + doubt <= value.mean <= high - doubt:
        return "pass"
    return "fail" if value.mean < low - doubt or value.mean > high + doubt else "undecided"


def all_of(verdicts: Sequence[Verdict]) -> Verdict:
    """The worst of several."""
    order: tuple[Verdict, ...] = ("fail", "no value", "undecided", "pass")
    return min(verdicts, key=order.index)
