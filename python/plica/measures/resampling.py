"""A sampled signal, or its slope, at another rate.

The signal is its samples under a windowed sinc, x(t) = h sum x_k g(t - t_k) with
g(t) = 2 f_c sinc(2 f_c t) w(t), and its slope has g' in place of g: differentiated, limited to both rates'
bands and resampled at once, for any two rates. With f the lower of the rates, g passes up to 0.45 f and stops
from 0.5 f on, by 120 dB: w is Kaiser's window over 80 / f to either side, and f_c = 0.475 f. Beyond its ends
the signal is mirrored at its first and last sample, by odd reflection, which keeps its value and slope.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from plica.measures.record import Array, Floats

__all__ = ["passed_share", "resampled", "resampled_slope"]

passed_share = 0.45  # of the lower rate: the highest frequency that is passed
_STOPPED = 0.5  # of the lower rate
_cutoff = 0.5 * (passed_share + _STOPPED)
_ATTENUATION = 120.0  # dB
_REACH = 80  # samples of the lower rate to either side: Kaiser's rule for both
_SAME = 1e-9  # of a sample: instants that lie so alike have the same weights
_PHASES = 1024  # a sample of the lower rate, between which weights are linear to 1e-6
_AT_ONCE = 1 << 20  # weights


def resampled(signal: Floats, step: float, rate: float) -> Floats:
    """(n) the signal at 0, 1 / rate, 2 / rate, ... up to its last sample (see the module docstring).

    Parameters
    ----------
    signal : (k), finite, k >= 2
    step : float
        s, between its samples.
    rate : float
        Hz, of the result.
    """
    return np.asarray(_convolved(signal, step, rate, _weights) + signal.mean())


def resampled_slope(signal: Floats, step: float, rate: float) -> Floats:
    """(n) the slope of the signal, per s, as :func:`resampled`."""
    return _convolved(signal, step, rate, _slope_weights)


def _convolved(signal: Floats, step: float, rate: float, kernel: Callable[[Array, float], Floats]) -> Floats:
    """(n) the signal less its mean under a kernel, at the instants of the result."""
    lower = min(1.0 / step, rate)
    reach = int(np.ceil(_REACH / (lower * step)))
    padded = np.pad(signal - signal.mean(), reach, mode="reflect", reflect_type="odd")
    count = int(np.floor((signal.size - 1) * step * rate + _SAME)) + 1
    place = np.arange(count) / (rate * step)
    first = np.floor(place + _SAME).astype(int)
    phase = np.round((place - first) / _SAME) * _SAME
    phases, which = np.unique(phase, return_inverse=True)
    share = np.zeros(count)
    if phases.size > _PHASES:
        steps = int(np.ceil(_PHASES * lower * step))
        phases = np.arange(steps + 1) / steps
        which = np.minimum((phase * steps).astype(int), steps - 1)
        share = phase * steps - which
    taps = np.arange(1 - reach, reach + 1)
    weights = step * kernel((phases[:, None] - taps) * step, lower)
    windows = np.lib.stride_tricks.sliding_window_view(padded, taps.size)
    found, chunk = np.empty(count), max(_AT_ONCE // taps.size, 1)
    for low in range(0, count, chunk):
        part = slice(low, low + chunk)
        chosen = weights[which[part]]
        if share.any():
            chosen += share[part, None] * (weights[which[part] + 1] - chosen)
        found[part] = np.einsum("ij,ij->i", windows[first[part] + 1], chosen)
    return found


def _weights(time: Array, lower: float) -> Floats:
    """g (1/s) at times (s)."""
    window, _ = _window(time, lower)
    sinc, _ = _sinc(2.0 * np.pi * _cutoff * lower * time)
    return np.asarray(2.0 * _cutoff * lower * sinc * window)


def _slope_weights(time: Array, lower: float) -> Floats:
    """g' (1/s^2) at times (s)."""
    cutoff = _cutoff * lower
    window, window_slope = _window(time, lower)
    sinc, sinc_slope = _sinc(2.0 * np.pi * cutoff * time)
    return np.asarray(2.0 * cutoff * (2.0 * np.pi * cutoff * sinc_slope * window + sinc * window_slope))


def _window(time: Array, lower: float) -> tuple[Floats, Floats]:
    """Kaiser's window and its slope (1/s)."""
    from scipy import special

    beta, end = 0.1102 * (_ATTENUATION - 8.7), _REACH / lower
    part = time / end
    root = np.sqrt(np.maximum(1.0 - part**2, 0.0))
    scale = np.where(np.abs(part) < 1.0, 1.0 / special.i0(beta), 0.0)
    bend = np.divide(special.i1(beta * root), root, out=np.full(root.shape, 0.5 * beta), where=root > 1e-6)
    return np.asarray(scale * special.i0(beta * root)), np.asarray(-scale * beta * part / end * bend)


def _sinc(turn: Array) -> tuple[Floats, Floats]:
    """sin(x) / x and its slope."""
    near = np.abs(turn) < 1e-4
    safe = np.where(near, 1.0, turn)
    value = np.where(near, 1.0 - turn**2 / 6.0, np.sin(safe) / safe)
    return value, np.where(near, -turn / 3.0, (np.cos(safe) - value) / safe)
