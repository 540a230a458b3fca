"""Detect when a recursion of covariances is steady."""

from __future__ import annotations

from collections import deque

import numpy as np
from numpy.typing import NDArray

__all__ = ["Settling"]

Array = NDArray[np.float64]


class Settling:
    """Convergence test of a recursion of positive semidefinite matrices, in units of sqrt(P_ii P_jj).

    With the geometric rate rho of the last changes of the diagonal, the remaining change after a change d is
    d rho / (1 - rho); the recursion is steady when that is within the tolerance for all entries.

    Parameters
    ----------
    tolerance : float
        >= 0; 0: never.
    """

    _window = 8
    _slowest = 0.999  # larger rates are round-off

    def __init__(self, tolerance: float) -> None:
        self._tolerance = tolerance
        self._changes: deque[float] = deque(maxlen=self._window)

    def restart(self) -> None:
        """Forget the previous changes: another recursion starts."""
        self._changes.clear()

    def settled(self, now: Array, before: Array) -> bool:
        """Whether `now`, computed from `before`, is within the tolerance of the limit; both (n, n)."""
        if self._tolerance == 0.0:
            return False
        diagonal = np.diagonal(now)
        change = float(np.max(_in_units(np.abs(diagonal - np.diagonal(before)), diagonal)))
        self._changes.append(change)
        if len(self._changes) < self._window:
            return False
        if change > self._tolerance:
            return False
        first = self._changes[0]
        rate = (change / first) ** (1.0 / (self._window - 1)) if first > 0 else 0.0
        rate = min(rate, self._slowest)
        allowed = self._tolerance * (1.0 - rate) / max(rate, 1.0 - self._slowest)
        if change > allowed:
            return False
        spread = np.sqrt(np.maximum(diagonal, 0.0))
        change = float(np.max(_in_units(np.abs(now - before), np.outer(spread, spread))))
        return change <= allowed


def _in_units(change: Array, unit: Array) -> Array:
    """change / unit; 0 where both are 0."""
    out: Array = np.divide(change, unit, out=np.where(change > 0, np.inf, 0.0), where=unit > 0)
    return out
