"""Instants between samples: level crossings and maxima of pulses."""

from __future__ import annotations

import numpy as np

from plica.measures.record import Floats

top_share = 0.9  # of a pulse's range, above which samples are used to locate its maximum


def crossing(time: Floats, signal: Floats, k: int, level: float) -> float:
    """Instant at which the signal, linear between samples k - 1 and k, crosses the level."""
    part = (level - signal[k - 1]) / (signal[k] - signal[k - 1])
    return float(time[k - 1] + part * (time[k] - time[k - 1]))


def highest(time: Floats, signal: Floats, peak: int) -> tuple[float, float]:
    """Instant and height of the maximum near sample `peak`, by a parabola through three samples."""
    if peak == 0 or peak == time.size - 1:
        return float(time[peak]), float(signal[peak])
    before, at, after = (float(value) for value in signal[peak - 1 : peak + 2])
    curvature = before - 2 * at + after
    shift = 0.5 * (before - after) / curvature if curvature < 0 else 0.0
    step = float(time[peak + 1] - time[peak])
    return float(time[peak]) + shift * step, at - 0.25 * (before - after) * shift


def _above(signal: Floats, peak: int, way: int, level: float) -> int:
    """Number of samples next to the peak, before (way = -1) or after it (1), that are above the level."""
    k = peak + way
    while 0 <= k < signal.size and signal[k] > level:
        k += way
    return abs(k - peak) - 1


def summit(time: Floats, signal: Floats, peak: int, floor: float) -> float:
    """Instant of the maximum of a pulse, also for flanks of different slope.

    (A parabola through three samples is off by a fifth of a step if one flank is curved twice as much as the
    other.) Near its maximum the pulse is h - a |t - t0|^p before t0 and h - b |t - t0|^p after, through
    samples m and 2 m before and after the largest one; p is 2, or 1 (a corner) if that is nearer to the
    largest sample. m is the largest for which all of them are above 90 % of the range from `floor` to the
    largest. For three or more equal largest samples, `peak` being the first, it is their middle.
    """
    flat = 1
    while peak + flat < signal.size and signal[peak + flat] == signal[peak]:
        flat += 1
    if 2 < flat < signal.size - peak:
        return float(0.5 * (time[peak] + time[peak + flat - 1]))
    level = floor + top_share * (signal[peak] - floor)
    m = max(min(_above(signal, peak, -1, level), _above(signal, peak, 1, level)) // 2, 1)
    if peak < 2 * m or peak + 2 * m >= time.size:
        return highest(time, signal, peak)[0]
    y = [float(signal[peak + k * m]) for k in (-2, -1, 0, 1, 2)]
    rise, fall = y[1] - y[0], y[3] - y[4]
    if not (rise > 0 and fall > 0):
        return highest(time, signal, peak)[0]

    # Through both samples of a flank: h(x) = y + rise g(x), for the top at x (in units of m samples).
    square = np.array([1.0, 2.0, 1.0])  # (1 + x)^2, and g(x) = (1 + x)^2 / (3 + 2 x) for p = 2
    both = np.convolve(rise * square, (-2.0, 3.0)) - np.convolve(fall * square * (1, -1, 1), (2.0, 3.0))
    both[1:] += (y[1] - y[3]) * np.array([-4.0, 0.0, 9.0])  # (3 + 2 x) (3 - 2 x)
    roots = np.roots(both)
    round_tops = [float(x.real) for x in roots if np.isreal(x) and abs(x) <= 1]
    corner = (y[3] - y[1] + fall - rise) / (rise + fall)  # g(x) = 1 + x for p = 1
    tops = [(x, 2) for x in round_tops] + ([(corner, 1)] if abs(corner) <= 1 else [])
    if not tops:
        return highest(time, signal, peak)[0]

    def miss(top: tuple[float, int]) -> float:
        x, p = top
        side, bend, near = (1, rise, y[1]) if x > 0 else (-1, fall, y[3])
        scale = bend / ((2 + side * x) ** p - (1 + side * x) ** p)
        return abs(near + scale * ((1 + side * x) ** p - abs(x) ** p) - y[2])

    return float(time[peak] + min(tops, key=miss)[0] * (time[peak + m] - time[peak]))
