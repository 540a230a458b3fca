"""A sampled signal, or its slope, at another rate.

The signal is its samples under a windowed sinc, x(t) = h sum x_k g(t - t_k) with
g(t) = 2 f_c sinc(2 f_c t) w(t), and its slope has g' in place of g: differentiated, limited to both rates'
bands and resampled at once, for any two rates. With f the lower of the rates, g passes up to 0.45 f and stops
from 0.5 f on, by 120 dB: w is Kaiser's window over 80 / f to either side, and f_c = 0.475 f. Beyond its ends
the signal is mirrored at its first and last sample, by odd reflection, which keeps its value and slope.
"""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction

import numpy as np

from plica.measures.record import Array, Floats

__all__ = ["passed_share", "resampled", "resampled_slope"]

passed_share = 0.45  # of the lower rate: the highest frequency that is passed
_STOPPED = 0.5  # of the lower rate
_cutoff = 0.5 * (passed_share + _STOPPED)
_ATTENUATION = 120.0  # dB
_REACH = 80  # samples of the lower rate to either side: Kaiser's rule for both
_SAME = 1e-6  # of a sample, by which an instant may be off
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
    taps = np.arange(1 - reach, reach + 1)
    windows = np.lib.stride_tricks.sliding_window_view(padded, taps.size)[1:]  # of the samples in order
    count = int(np.floor((signal.size - 1) * step * rate + _SAME)) + 1
    ratio = Fraction(rate * step).limit_denominator(_PHASES)

    def weights(phases: Floats) -> Floats:
        return step * kernel((phases[:, None] - taps) * step, lower)

    if ratio and abs(1 / float(ratio) - 1 / (rate * step)) * count < _SAME:
        return _of_a_ratio(windows, ratio, count, weights)
    return _of_any(windows, np.arange(count) / (rate * step), int(np.ceil(_PHASES * lower * step)), weights)


def _of_a_ratio(windows: Floats, ratio: Fraction, count: int, weights: Callable[[Floats], Floats]) -> Floats:
    """(count) where `ratio` samples of the result are one of the signal: its numerator of phases recur."""
    up, down = ratio.numerator, ratio.denominator
    first, rest = np.divmod(down * np.arange(up), up)
    found, chosen = np.empty(count), weights(rest / up)
    for k in range(min(up, count)):
        size = len(range(k, count, up))
        found[k::up] = np.einsum("ij,j->i", windows[first[k] :: down][:size], chosen[k])
    return found


def _of_any(windows: Floats, place: Floats, phases: int, weights: Callable[[Floats], Floats]) -> Floats:
    """(n) at any places, in samples of the signal: weights are linear between so many phases."""
    table = weights(np.arange(phases + 1) / phases)
    first = np.floor(place + _SAME).astype(int)
    phase = (place - first) * phases
    which = np.clip(phase.astype(int), 0, phases - 1)
    found, chunk = np.empty(place.size), max(_AT_ONCE // windows.shape[1], 1)
    for low in range(0, place.size, chunk):
        part = slice(low, low + chunk)
        chosen = table[which[part]]
        chosen += (phase - which)[part, None] * (table[which[part] + 1] - chosen)
        found[part] = np.einsum("ij,ij->i", windows[first[part]], chosen)
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
