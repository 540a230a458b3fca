"""Cycles of a waveform: where they begin, which of them are steady, and why there may be none.

The rule. Let r be the range of the signal in the last half of the record, and m its mean there. A cycle
begins where the signal rises through m after it was below m - q, if it then reaches m + q before it falls
below m - q again; q = r / 10, less where m lies near an end of the range. The instant is interpolated
linearly between samples. Where the autocorrelation's period is more than 1.1 of the mean one, ripples may
have been taken for cycles: the search is repeated with limits halfway from m to the least and to the
largest value, and its result is taken if it is nearer to the autocorrelation's period.

Counted back from the end, cycles are steady as long as their period and their peak-to-peak amplitude stay
within 5 % of the median of the last three. If fewer than three are steady, the record is either irregular
but stationary (the mean amplitudes of its last two quarters agree within 10 %: then the last half of the
cycles is used) or not settled (then the last three are used); the note says which.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from plica.measures.record import Floats, time_step

fewest = 3  # cycles that a statistic needs
settled = 0.05  # relative difference of period and amplitude within the steady part
stationary = 0.10  # relative difference of mean amplitude within an irregular record
weak = 0.10  # range over the last third, relative to the largest magnitude there
silent = 0.01  # range over the last third, relative to the largest magnitude of the record


@dataclass(frozen=True)
class Cycles:
    """Consecutive cycles, the steady part of a record.

    Attributes
    ----------
    starts : (c + 1) s, the beginning of each cycle and the end of the last; empty without cycles
    note : str
        Why there are none, or what is unusual about them; empty otherwise.
    settled : bool
        Whether period and amplitude had settled.
    """

    starts: Floats
    note: str = ""
    settled: bool = True

    @property
    def count(self) -> int:
        """Number of cycles; 0 if fewer than three were found."""
        return max(self.starts.size - 1, 0)

    @property
    def periods(self) -> Floats:
        """(c) s."""
        return np.diff(self.starts)

    def samples(self, time: Floats) -> list[slice]:
        """Samples of each cycle: start <= time < end."""
        return _slices(time, self.starts)

    def extent(self, time: Floats) -> slice:
        """Samples of all cycles together; the last third of the record if there are no cycles."""
        if not self.count:
            return slice(time.size - max(time.size // 3, 1), time.size)
        return slice(int(np.searchsorted(time, self.starts[0])), int(np.searchsorted(time, self.starts[-1])))


def find_cycles(time: Floats, signal: Floats, *, name: str = "signal") -> Cycles:
    """Find the steady cycles of a signal (the rule stands at the head of this module).

    Parameters
    ----------
    time : (k) s, ascending
    signal : (k), finite
    name : str
        What the signal is, for the notes.

    Returns
    -------
    Cycles
        At least three cycles, or none and a note that says why.
    """
    if signal.size < 8:
        return _none(f"too short: {signal.size} samples")
    tail = signal[signal.size - signal.size // 3 :]
    largest = float(np.abs(signal).max())
    if np.ptp(tail) <= silent * largest:
        if float(np.abs(tail).max()) <= silent * largest:
            return _none(f"no oscillation: the {name} stays at zero in the last third of the record")
        return _none(f"no oscillation: the {name} varies by less than 1 % in the last third of the record")
    starts = _without_ripples(time, signal, rising_crossings(time, signal))
    if starts.size <= fewest:
        count = max(starts.size - 1, 0)
        return _none(f"too short: {count} complete cycles of the {name}; at least {fewest} are needed")
    found = _steady(time, signal, starts)
    varies = float(np.ptp(tail)) / float(np.abs(tail).max())
    if varies >= weak:
        return found
    note = f"weak: the {name} varies by only {100 * varies:.2g} % in the last third of the record"
    return replace(found, note="; ".join(text for text in (note, found.note) if text))


def rising_crossings(time: Floats, signal: Floats, share: float = 0.1) -> Floats:
    """Instants (s) at which the signal rises through its mean, with hysteresis, both from its last half.

    The limits lie `share` of the range from the mean, but at most halfway to the least and largest value.
    """
    half = signal[signal.size // 2 :]
    low, high, level = float(half.min()), float(half.max()), float(half.mean())
    below = level - min(share * (high - low), 0.5 * (level - low))
    above = level + min(share * (high - low), 0.5 * (high - level))
    starts: list[float] = []
    armed = False
    candidate = 0.0
    for k in range(signal.size):
        if k and signal[k - 1] < level <= signal[k]:
            candidate = _crossing(time, signal, k, level)
        if signal[k] < below:
            armed = True
        elif armed and signal[k] > above:
            starts.append(candidate)
            armed = False
    return np.array(starts)


def autocorrelation_frequency(signal: Floats, step: float) -> float:
    """Frequency (Hz) of the first autocorrelation peak within 10 % of the highest; NaN if none is positive.

    The mean is removed, each lag is divided by the norms of the two parts that overlap (so that a periodic
    signal reaches exactly 1), lags go up to half the signal, and a parabola places the peak.
    """
    centred = signal - signal.mean()
    length = 1 << (2 * centred.size - 1).bit_length()
    transform = np.fft.rfft(centred, length)
    correlation = np.fft.irfft(np.abs(transform) ** 2, length)[: centred.size // 2 + 2]
    power = np.concatenate(([0.0], np.cumsum(centred**2)))
    lags = np.arange(correlation.size)
    norms = np.sqrt(power[centred.size - lags] * (power[-1] - power[lags]))
    correlation = np.divide(correlation, norms, out=np.zeros_like(correlation), where=norms > 0)
    negative = np.flatnonzero(correlation < 0)
    if not negative.size:
        return float("nan")
    inner = correlation[1:-1]
    peaks = 1 + np.flatnonzero((inner >= correlation[:-2]) & (inner > correlation[2:]))
    peaks = peaks[(peaks > negative[0]) & (correlation[peaks] > 0)]
    if not peaks.size:
        return float("nan")
    lag = int(peaks[correlation[peaks] >= 0.9 * correlation[peaks].max()][0])
    before, at, after = correlation[lag - 1 : lag + 2]
    curvature = before - 2 * at + after
    shift = 0.5 * (before - after) / curvature if curvature < 0 else 0.0
    return float(1.0 / ((lag + shift) * step))


def _none(reason: str) -> Cycles:
    return Cycles(np.empty(0), reason, False)


def _without_ripples(time: Floats, signal: Floats, starts: Floats) -> Floats:
    """The crossings, or those of a wider hysteresis if the autocorrelation speaks for longer periods."""
    if starts.size < 3:
        return starts
    half = signal[signal.size // 2 :]
    expected = 1.0 / autocorrelation_frequency(half, time_step(time))
    period = float(np.diff(starts[starts.size // 2 - 1 :]).mean())
    if not expected > 1.1 * period:
        return starts
    wider = rising_crossings(time, signal, 0.5)
    if wider.size < 3:
        return starts
    longer = float(np.diff(wider[wider.size // 2 - 1 :]).mean())
    return wider if abs(longer - expected) < abs(period - expected) else starts


def _steady(time: Floats, signal: Floats, starts: Floats) -> Cycles:
    periods = np.diff(starts)
    amplitudes = np.array([np.ptp(signal[part]) for part in _slices(time, starts)])
    alike = np.ones(periods.size, dtype=bool)
    for values in (periods, amplitudes):
        centre = float(np.median(values[-fewest:]))
        alike &= np.abs(values - centre) <= settled * centre
    count = periods.size if alike.all() else int(np.argmin(alike[::-1]))
    if count >= fewest:
        return Cycles(starts[-count - 1 :])
    quarter = periods.size // 4
    if quarter >= 2:
        last, previous = amplitudes[-quarter:].mean(), amplitudes[-2 * quarter : -quarter].mean()
        if abs(last - previous) <= stationary * last:
            kept = max(periods.size // 2, fewest)
            return Cycles(
                starts[-kept - 1 :], "irregular: periods or amplitudes differ by more than 5 %", False
            )
    note = "not settled: period or amplitude still change; the last three cycles are used"
    return Cycles(starts[-fewest - 1 :], note, False)


def _slices(time: Floats, starts: Floats) -> list[slice]:
    edges = np.searchsorted(time, starts)
    return [slice(int(a), int(b)) for a, b in pairwise(edges)]


def _crossing(time: Floats, signal: Floats, k: int, level: float) -> float:
    part = (level - signal[k - 1]) / (signal[k] - signal[k - 1])
    return float(time[k - 1] + part * (time[k] - time[k - 1]))
