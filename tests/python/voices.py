"""Glottal areas of voices whose every period and amplitude is known."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.floating[Any]]


def voice(
    periods: Floats, amplitudes: Floats, *, samples: float = 60, noise: float = 0.0, seed: int = 0
) -> tuple[Floats, Floats]:
    """Times and area: in each period a pulse sin^1.5 over its first 0.6, then closure.

    Parameters
    ----------
    periods, amplitudes : (n) s, 1
        Of each cycle.
    samples : float
        A median period has; where they begin is random.
    noise : float
        Standard deviation of what is added to each sample.
    seed : int
    """
    random = np.random.default_rng(seed)
    edges = np.concatenate(([0.0], np.cumsum(periods)))
    step = float(np.median(periods)) / samples
    time = step * (np.arange(int(edges[-1] / step)) + random.uniform(0.1, 0.9))
    cycle = np.clip(np.searchsorted(edges, time, side="right") - 1, 0, periods.size - 1)
    phase = (time - edges[cycle]) / periods[cycle]
    area = amplitudes[cycle] * np.where(phase < 0.6, np.sin(np.pi * np.clip(phase / 0.6, 0, 1)) ** 1.5, 0.0)
    return time, area + noise * random.standard_normal(time.size)


def folds_apart() -> tuple[Floats, Floats]:
    """As of folds 0.1 mm apart: now three, now four pulses in each 7.9 ms, in no order; and their periods."""
    lengths, heights = [], []
    for four in np.random.default_rng(3).integers(0, 2, 24):
        lengths += [2.72, 1.42, 1.22, 2.54] if four else [2.63, 2.64, 2.63]
        heights += [6.1, 4.7, 3.4, 3.8] if four else [5.7, 4.7, 4.2]
    return 1e-3 * np.array(lengths), np.array(heights)


def scattered(count: int, jitter: float = 0.0, shimmer: float = 0.0, seed: int = 0) -> tuple[Floats, Floats]:
    """Periods about 5 ms and amplitudes about 1 of given relative standard deviations, independent."""
    random = np.random.default_rng([7, seed])
    return (
        5e-3 * (1 + jitter * random.standard_normal(count)),
        1 + shimmer * random.standard_normal(count),
    )


def lf_pulse(period: float, step: float, peak: float) -> tuple[Floats, Floats, float]:
    """Time and flow of twelve pulses of Liljencrants and Fant's open phase, and E: the slope is
    e^(a t) sin(pi t / tp) to t = te, where it is -E, and zero from there on (no return phase), by
    quadrature."""
    tp, te = 0.45 * period, 0.6 * period
    fine = np.linspace(0.0, te, 20001)
    low, high = 0.0, 2000.0
    for _ in range(80):  # a: the flow is zero at te
        a = 0.5 * (low + high)
        slope = np.exp(a * fine) * np.sin(np.pi * fine / tp)
        low, high = (a, high) if np.trapezoid(slope, fine) > 0 else (low, a)
    scale = peak / np.trapezoid(np.maximum(slope, 0.0), fine)
    flow = scale * np.concatenate(([0.0], np.cumsum(0.5 * (slope[1:] + slope[:-1]) * np.diff(fine))))
    time = step * np.arange(int(12 * period / step))
    return time, np.interp(time % period, fine, flow, right=0.0), float(-scale * slope[-1])
