"""Phase of a motion at the frequency of its cycles."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from plica.measures.circular import principal
from plica.measures.record import Floats

Mask = npt.NDArray[np.bool_]

harmonics = 5  # largest number fitted, so that they do not leak into the fundamental
_CREST = 5  # samples, of a cosine with a constant
still = 1e-6  # of the larger of two motions; a smaller motion is treated as zero


def fundamental(time: Floats, signal: Floats, start: float, end: float) -> complex:
    """Fourier coefficient c of one cycle at its frequency w = 2 pi / (end - start).

    The signal has the part Re(c exp(i w (t - start))): A cos(w (t - start) - lag) has c = A exp(-i lag).
    Least squares over the n samples with start <= t < end, of a constant, the fundamental and harmonics up
    to the n / 4-th, at most the fifth: exact for signals in their span, at any instants.

    Parameters
    ----------
    time : (k) s, ascending
    signal : (k)
    start, end : float
        s, the cycle's.

    Returns
    -------
    complex
        In units of the signal; NaN for fewer than four samples or one that is not finite.
    """
    return fundamentals(time, (signal,), start, end)[0]


def fundamentals(time: Floats, signals: Sequence[Floats], start: float, end: float) -> list[complex]:
    """That of each of several signals, as `fundamental`, for little more than that of one."""
    first, last = np.searchsorted(time, (start, end))
    values = np.stack([np.asarray(signal[first:last], dtype=float) for signal in signals], axis=1)
    finite = np.isfinite(values).all(axis=0)
    if len(values) < 4 or not finite.any():
        return [complex("nan")] * len(signals)
    turn = 2 * np.pi * (time[first:last] - start) / (end - start)
    orders = turn[:, None] * np.arange(1, min(harmonics, len(values) // 4) + 1)
    basis = np.concatenate((np.cos(orders), np.sin(orders), np.ones((len(values), 1))), axis=1)
    found = np.full((basis.shape[1], len(signals)), np.nan)
    found[:, finite] = np.linalg.lstsq(basis, values[:, finite], rcond=None)[0]
    return [complex(one[0], -one[orders.shape[1]]) for one in found.T]


def crest(time: Floats, signal: Floats, seen: Mask, start: float, end: float) -> complex:
    """The cosine at the cycle's frequency that a signal follows about its largest values, as `fundamental`.

    Of the samples that are seen, those above a quarter of the signal's range, five at least, by least squares
    with a constant beside it. What the signal does elsewhere does not matter.

    Parameters
    ----------
    time : (k) s, ascending
    signal : (k)
    seen : (k) bool
    start, end : float
        s, the cycle's.

    Returns
    -------
    complex
        In units of the signal; the `fundamental` where fewer than five samples are seen, NaN where one is not
        finite.
    """
    first, last = np.searchsorted(time, (start, end))
    values, there = np.asarray(signal[first:last], dtype=float), seen[first:last]
    if there.sum() < _CREST or not np.isfinite(values).all():
        return fundamental(time, signal, start, end)
    quarter = values.min() + 0.25 * np.ptp(values)
    fifth = np.sort(values[there])[-_CREST]
    chosen = there & (values >= min(quarter, fifth))
    turn = 2 * np.pi * (time[first:last] - start)[chosen] / (end - start)
    basis = np.stack((np.cos(turn), np.sin(turn), np.ones(turn.size)), axis=1)
    found = np.linalg.lstsq(basis, values[chosen], rcond=None)[0]
    return complex(found[0], -found[1])


def phase_lag(first: complex, second: complex) -> float:
    """Angle by which the second fundamental lags behind the first, in (-pi, pi].

    Positive if the second is later; NaN if one of them does not move.
    """
    small, large = sorted((abs(first), abs(second)))
    if not small > still * large:
        return float("nan")
    return principal(float(np.angle(first * second.conjugate())))
