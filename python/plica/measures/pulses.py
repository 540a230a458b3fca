"""Start instants of the pulses of a waveform.

Let r be the range of the signal in the last half of the record, and m its mean there. A pulse starts where
the signal rises through m after it was below m - q, if it then reaches m + q before it falls below m - q
again; q = r / 10, or less if m is near an end of the range. The instant is interpolated linearly between
samples. If the autocorrelation's period is more than 1.1 of the mean one, ripples may have been mistaken for
pulses: unless the crossings are evenly spaced like pulses, even alternating ones (no interval above 1.4 of
the mean), the search is repeated with limits halfway from m to the smallest and to the largest value, and
its result is used if it is nearer to the autocorrelation's period.
"""

from __future__ import annotations

import numpy as np

from plica.measures.instants import crossing
from plica.measures.record import Floats, time_step

even = 1.4  # longest interval between pulses, relative to the mean one


def pulses(time: Floats, signal: Floats) -> Floats:
    """Instants (s) at which pulses start (see the module docstring)."""
    starts = rising_crossings(time, signal)
    if starts.size < 3:
        return starts
    half = signal[signal.size // 2 :]
    expected = 1.0 / autocorrelation_frequency(half, time_step(time))
    periods = np.diff(starts[starts.size // 2 - 1 :])
    period = float(periods.mean())
    if not expected > 1.1 * period or periods.max() <= even * period:
        return starts
    wider = rising_crossings(time, signal, 0.5)
    if wider.size < 3:
        return starts
    longer = float(np.diff(wider[wider.size // 2 - 1 :]).mean())
    return wider if abs(longer - expected) < abs(period - expected) else starts


def rising_crossings(time: Floats, signal: Floats, share: float = 0.1) -> Floats:
    """Instants (s) at which the signal rises through its mean, with hysteresis, both from its last half.

    The limits are `share` of the range from the mean, but at most halfway to the smallest and largest value.
    """
    half = signal[signal.size // 2 :]
    low, high, level = float(half.min()), float(half.max()), float(half.mean())
    below = level - min(share * (high - low), 0.5 * (level - low))
    above = level + min(share * (high - low), 0.5 * (high - level))
    return rises(time, signal, below, level, above)


def rises(time: Floats, signal: Floats, below: float, level: float, above: float) -> Floats:
    """Instants (s) at which the signal crosses the level while rising from `below` to `above`."""
    starts: list[float] = []
    armed = False
    candidate = 0.0
    before = np.inf
    for k, value in enumerate(signal.tolist()):
        if before < level <= value:
            candidate = crossing(time, signal, k, level)
        if value < below:
            armed = True
        elif armed and value > above:
            starts.append(candidate)
            armed = False
        before = value
    return np.array(starts)


def summits(signal: Floats, height: float) -> int:
    """Number of maxima from which the signal falls by `height` or more on both sides before it is higher
    again, or ends; those of prominence `height` (in the unit of the signal; none if it is 0), of several
    equally high ones with less between them one.
    """
    count, rising, low, high = 0, False, np.inf, -np.inf
    for value in signal.tolist():
        if not rising:
            low = min(low, value)
            if value - low >= height > 0:
                rising, high = True, value
        else:
            high = max(high, value)
            if high - value >= height:
                count, rising, low = count + 1, False, value
    return count


def autocorrelation_frequency(signal: Floats, step: float) -> float:
    """Frequency (Hz) of the first autocorrelation peak within 10 % of the highest; NaN without one."""
    return autocorrelation_peak(signal, step)[0]


def autocorrelation_peak(signal: Floats, step: float) -> tuple[float, float]:
    """Frequency (Hz) and height of the first autocorrelation peak within 10 % of the highest; NaN if none is
    positive.

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
        return float("nan"), float("nan")
    inner = correlation[1:-1]
    peaks = 1 + np.flatnonzero((inner >= correlation[:-2]) & (inner > correlation[2:]))
    peaks = peaks[(peaks > negative[0]) & (correlation[peaks] > 0)]
    if not peaks.size:
        return float("nan"), float("nan")
    lag = int(peaks[correlation[peaks] >= 0.9 * correlation[peaks].max()][0])
    before, at, after = correlation[lag - 1 : lag + 2]
    curvature = before - 2 * at + after
    shift = 0.5 * (before - after) / curvature if curvature < 0 else 0.0
    return float(1.0 / ((lag + shift) * step)), float(at - 0.25 * (before - after) * shift)
