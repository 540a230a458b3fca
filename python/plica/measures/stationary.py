"""Stationary cycles of a vibration: periods and amplitudes without trend.

A sequence is one value per cycle, relative to its mean. It *drifts* if the line through it rises or falls by
more than is allowed, and by more than its scatter about the line explains (t-test, 0.5 %). Allowed from the
first of n cycles to the last are 2 % of the period and 5 % of the amplitude, but at most 0.5 % and 1 % per
cycle. It is *uneven* if the scatter in one of its halves exceeds the tolerance, is at least three times that
of the other, and more than chance explains (F-test, 0.1 %). Else it is stationary, however irregular.

A vibration that repeats only every second, third or fourth cycle has a *pattern*: its cycles, sorted by their
position in the pattern, scatter within tolerance, or half as much as unsorted and by less than chance
explains (F-test, 0.1 %). Drift and scatter are then those about the pattern.

In a whole record that is stationary, and in the last half, quarter, ... of one that is not, all cycles are
used back to the first that departs from the last ones: by more than 2 % and 5 %, and by more than their
scatter explains (prediction interval, 0.01 %; 1 % for the cycles that are then first). So cycles are never
selected for being alike, which would halve the spread of an irregular vibration.

Any short part of a trend looks stationary. So the stationary end of a record that was changing is only used
if the vibration became steady: either the whole record rises or falls at least three times as fast as its
end, and faster by more than the scatter of neighbouring cycles explains (logarithms, t-test, 0.5 %; under a
constant trend both are equally fast), or the same number of cycles before depart from the mean of the end at
least six times as much as its own do (root mean square; 3.6 times under a constant trend), and by more than
chance explains (F-test, 0.1 %). Either is asked of all cycles back to the first that agrees; where these fail
and nothing drifted, as in a beat that dies away, of the last half, quarter, ... alone. Moreover, unless that
end is irregular, no trend beyond what is allowed may even be likely in it: after a change it is steadiness
that has to be shown. (Likely: t-test, 5 %, and of fewer than three degrees of freedom any, since among so few
the test finds none.)
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from plica.measures.record import Floats

fewest = 3  # cycles needed for statistics
longest_pattern = 4  # cycles
slower = 3.0  # rate of the whole record over that of a steady end; 1 under a constant trend
calmer = 6.0  # departure before over departure within a steady end; 3.6 under a constant trend
uneven = 3.0  # scatter of one half over that of the other


@dataclass(frozen=True)
class Tolerance:
    """Tolerances relative to the mean."""

    scatter: float
    """Largest standard deviation of a regular vibration, and largest drift over all cycles of a steady
    one."""
    rate: float
    """Largest drift per cycle."""


of_period = Tolerance(0.02, 0.005)
of_amplitude = Tolerance(0.05, 0.01)


@dataclass(frozen=True)
class Fit:
    """Line through a sequence of n values relative to their mean, with a level for each position in a
    pattern.

    Attributes
    ----------
    pattern : int
        Length of the pattern; 1 without one.
    rate : float
        Slope, per cycle.
    error : float
        Standard error of the slope.
    spread : float
        Standard deviation of the values about the pattern, without the line.
    residual : (n)
        Values minus line and pattern.
    """

    pattern: int
    rate: float
    error: float
    spread: float
    residual: Floats

    @property
    def freedom(self) -> int:
        """Degrees of freedom of the residual."""
        return self.residual.size - self.pattern - 1


def stationary_from(sequences: list[tuple[Floats, Tolerance]]) -> int | None:
    """Index of the first of the stationary cycles at the end; None if the vibration is still changing.

    Parameters
    ----------
    sequences : list of ((n), Tolerance)
        Periods and amplitudes, n >= 3.
    """
    size = sequences[0][0].size
    changed, trend = [False] * len(sequences), False
    count = size
    while count >= fewest:
        ends = [
            (values[size - count :], same, fit(values[size - count :], same)) for values, same in sequences
        ]
        trend = trend or any(drifts(line, same) for _, same, line in ends)
        still = [_is_stationary(*end) for end in ends]
        changed = [past or not now for past, now in zip(changed, still, strict=True)]
        if all(still):
            core = count if count < size else max((size + 1) // 2, fewest)
            first = _reach(sequences, size - core)
            parts = [values for (values, _), past in zip(sequences, changed, strict=True) if past]
            # Cycles that agree with the core may be the end of a beat that dies away, which is no trend.
            if not trend and not all(_settles(values, first) for values in parts):
                first = size - core
            if all(_settles(values, first) for values in parts):
                first = _without_onset(sequences, first, size - core)
                while count < size and _may_drift(sequences, first) and first < size - core:
                    first += 1
                if count == size or not _may_drift(sequences, first):
                    return first
        count //= 2
    return None


def fit(values: Floats, tolerance: Tolerance) -> Fit:
    """The line through a sequence, with its shortest pattern."""
    plain = _fit(values, 1)
    if plain.spread <= tolerance.scatter:
        return plain
    found = plain
    for pattern in range(2, longest_pattern + 1):
        if values.size < 2 * pattern + 1:
            break
        sorted_ = _fit(values, pattern)
        if _explains(sorted_, plain) and (
            sorted_.spread <= tolerance.scatter or sorted_.spread <= 0.5 * found.spread
        ):
            found = sorted_
            if found.spread <= tolerance.scatter:
                break
    return found


def exceeds(line: Fit, tolerance: Tolerance) -> bool:
    """Whether the line through a sequence rises or falls by more than is allowed, regardless of scatter."""
    steps = line.residual.size - 1
    return abs(line.rate) * steps > min(tolerance.scatter, tolerance.rate * steps)


def may_drift(line: Fit, tolerance: Tolerance) -> bool:
    """Whether a sequence that is regular about its line and does not provably drift is still likely to."""
    from scipy import special

    if float(line.residual @ line.residual) > line.freedom * tolerance.scatter**2:
        return False
    if not exceeds(line, tolerance) or line.freedom < fewest:
        return exceeds(line, tolerance)
    return bool(abs(line.rate) > special.stdtrit(line.freedom, 1 - 0.05 / 2) * line.error)


def drifts(line: Fit, tolerance: Tolerance) -> bool:
    """Whether a sequence rises or falls by more than is allowed and more than its scatter explains."""
    from scipy import special

    return exceeds(line, tolerance) and bool(
        abs(line.rate) > special.stdtrit(line.freedom, 1 - 0.005 / 2) * line.error
    )


def _fit(values: Floats, pattern: int) -> Fit:
    relative = values / values.mean() - 1.0
    places, basis, variance = _basis(values.size, pattern)
    solution = np.linalg.lstsq(basis, relative, rcond=None)[0]
    residual = relative - basis @ solution
    about = relative - places @ (places.T @ relative / places.sum(axis=0))
    freedom = values.size - pattern - 1
    error = np.sqrt(residual @ residual / freedom * variance)
    spread = np.sqrt(about @ about / (freedom + 1))
    return Fit(pattern, float(solution[-1]), float(error), float(spread), residual)


@lru_cache(maxsize=256)
def _basis(size: int, pattern: int) -> tuple[Floats, Floats, float]:
    """Places in the pattern (size, pattern), the same with the line (size, pattern + 1), and the variance of
    its slope where that of a value is 1. Not to be written to."""
    number = np.arange(size)
    places = (number[:, None] % pattern == np.arange(pattern)).astype(float)
    basis = np.concatenate((places, (number - number.mean())[:, None]), axis=1)
    return places, basis, np.linalg.inv(basis.T @ basis)[-1, -1]


def _explains(sorted_: Fit, plain: Fit) -> bool:
    """Whether sorting by position reduces the scatter about the line by more than chance."""
    from scipy import special

    left, all_ = float(sorted_.residual @ sorted_.residual), float(plain.residual @ plain.residual)
    gain = (all_ - left) / (sorted_.pattern - 1) * sorted_.freedom
    limit = special.fdtri(sorted_.pattern - 1, sorted_.freedom, 1 - 0.001)
    return bool(gain > limit * left)


def _is_stationary(values: Floats, tolerance: Tolerance, line: Fit) -> bool:
    return not (drifts(line, tolerance) or _is_uneven(values, line.pattern, tolerance))


def _is_uneven(values: Floats, pattern: int, tolerance: Tolerance) -> bool:
    from scipy import special

    half = values.size // 2
    if half < pattern + fewest - 1:
        return False
    relative = values / values.mean()
    found = []
    for part in (relative[:-half], relative[-half:]):  # the middle one of an odd number is in the first
        about = part - np.resize([part[k::pattern].mean() for k in range(pattern)], part.size)
        freedom = part.size - pattern
        found.append((float(about @ about) / freedom, freedom))
    (small, of_small), (large, of_large) = sorted(found)
    limit = max(special.fdtri(of_large, of_small, 1 - 0.001 / 2), uneven**2)
    return bool(large > tolerance.scatter**2 and large > limit * small)


def _may_drift(sequences: list[tuple[Floats, Tolerance]], first: int) -> bool:
    return any(may_drift(fit(values[first:], same), same) for values, same in sequences)


def _settles(values: Floats, first: int) -> bool:
    """Whether the vibration was changing before cycle `first` and not after."""
    from scipy import special

    end = values[first:] / values[first:].mean()
    before = values[max(2 * first - values.size, 0) : first] / values[first:].mean()
    whole_rate, rate = (abs(slope(np.log(part))) for part in (values, end))
    doubt = neighbours_scatter(values) * np.sqrt(12.0 / (end.size * (end.size**2 - 1)))
    gain = whole_rate - rate
    if whole_rate >= slower * rate and gain > special.stdtrit(values.size - 2, 1 - 0.005 / 2) * doubt:
        return True
    limit = max(calmer**2, special.fdtri(before.size, end.size - 1, 1 - 0.001))
    return bool(np.mean((before - 1.0) ** 2) >= limit * np.mean((end - 1.0) ** 2))


def slope(values: Floats) -> float:
    """Slope of a sequence, per cycle."""
    number = np.arange(values.size) - 0.5 * (values.size - 1)
    return float(number @ values / (number @ number))


def neighbours_scatter(values: Floats) -> float:
    """Relative standard deviation of single values, from second differences, which are independent of a
    trend.

    From their median (for normal values 0.6745 of their standard deviation, which is sqrt(6) that of the
    values), so that outliers have little effect; the minimum over differences of 1 to 4 cycles, so that a
    pattern has none.
    """
    logarithm = np.log(values)
    lags = [lag for lag in range(1, longest_pattern + 1) if values.size > 4 * lag] or [1]
    second = [np.abs(logarithm[2 * q :] - 2 * logarithm[q:-q] + logarithm[: -2 * q]) for q in lags]
    return min(float(np.median(part)) for part in second) / (0.6745 * 6**0.5)


def _reach(sequences: list[tuple[Floats, Tolerance]], core: int) -> int:
    """First of the cycles that agree with those from `core` on and are stationary together with them."""
    apart = np.flatnonzero(np.any([_departs(*pair, core, 1e-4) for pair in sequences], axis=0))
    first = int(apart[-1]) + 1 if apart.size else 0
    while first < core and not all(
        _is_stationary(values[first:], same, fit(values[first:], same)) for values, same in sequences
    ):
        first += max((core - first) // 16, 1)
    return first


def _without_onset(sequences: list[tuple[Floats, Tolerance]], first: int, core: int) -> int:
    """The first cycle from `first` on that agrees with those from `core` on."""
    apart = np.any([_departs(*pair, core, 1e-2) for pair in sequences], axis=0)
    while first < core and apart[first]:
        first += 1
    return first


def _departs(values: Floats, tolerance: Tolerance, core: int, chance: float) -> NDArray[np.bool_]:
    """Which cycles before `core` depart from those from `core` on."""
    from scipy import special

    end = values[core:]
    line = fit(end, tolerance)
    levels = np.array([end[k :: line.pattern].mean() for k in range(line.pattern)])
    expected = levels[(np.arange(core) - core) % line.pattern]
    each = end.size / line.pattern  # cycles in each place
    factor = special.stdtrit(end.size - line.pattern, 1 - chance / 2) * np.sqrt(1 + 1 / each)
    limit = max(tolerance.scatter, factor * line.spread) * end.mean()
    return np.asarray(np.abs(values[:core] - expected) > limit)
