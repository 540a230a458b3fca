"""Harmonics and means of the cycles of a signal.

The amplitude of harmonic k of a cycle of the period T is that of its Fourier integral at k / T under a Hann
window of two periods about the middle of the cycle,

    a_k = 2 |sum w(t_n) x_n exp(-2 pi i k t_n / T)| / sum w(t_n).

The window's transform vanishes at all other harmonics and at zero, so that neither they nor a constant leak
into a_k, for periods that are no whole number of samples as well. (Sampled, its lobes fall off with the third
power of the frequency, which leaves 1e-7 with 100 samples a cycle.)
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from plica.measures.cycles import Cycles
from plica.measures.record import Floats, time_step

__all__ = ["cycle_means", "formant_gain", "harmonic_levels", "level_difference", "without_formants"]

_RESOLVED = 0.45  # of the samples a second, below which a harmonic is told
_ROUND_OFF = 1e-5  # of the largest harmonic, 100 dB: smaller ones are none


def harmonic_levels(
    time: Floats, signal: Floats, cycles: Cycles, count: int = 4, band: float = np.inf
) -> Floats:
    """(c, count) amplitudes of the first harmonics of each cycle, in the signal's unit.

    NaN for a cycle without half a period of the record on either side, for a harmonic above 0.45 of the
    sampling rate or above the band, and for one that is less than 1e-5 of the cycle's largest.

    Parameters
    ----------
    time : (k) s, equidistant
    signal : (k), finite
    cycles : Cycles
    count : int
        Harmonics, from the fundamental on.
    band : float
        Hz, up to which the signal is known.
    """
    step = time_step(time)
    highest = min(_RESOLVED / step, band)
    found = np.full((cycles.count, count), np.nan)
    for k, (start, end) in enumerate(pairwise(cycles.starts.tolist())):
        period = end - start
        low, high = start - 0.5 * period, end + 0.5 * period
        if low < time[0] - 0.5 * step or high > time[-1] + 0.5 * step:
            continue
        part = slice(int(np.searchsorted(time, low)), int(np.searchsorted(time, high, side="right")))
        turn = (time[part] - low) / period  # 0 to 2
        window = 1.0 - np.cos(np.pi * turn)
        number = np.arange(1, count + 1)
        waves = np.exp(-2j * np.pi * np.outer(number, turn))
        level = 2.0 * np.abs(waves @ (window * signal[part])) / window.sum()
        told = (number <= highest * period) & (level > _ROUND_OFF * level.max())
        found[k] = np.where(told, level, np.nan)
    return found


def level_difference(levels: Floats, one: int, other: int) -> Floats:
    """(c) dB, harmonic `one` over harmonic `other`, from 1 on, of levels (c, count)."""
    return np.asarray(20.0 * np.log10(levels[:, one - 1] / levels[:, other - 1]))


def formant_gain(frequency: Floats | float, formants: Floats, bandwidths: Floats) -> Floats:
    """dB by which resonances raise a frequency (Hz) above zero frequency.

    Of each, 20 log10 |s s* / ((i 2 pi f - s)(i 2 pi f - s*))| with s = pi (-b + 2 i F) (Fant, Acoustic Theory
    of Speech Production, 1960).

    Parameters
    ----------
    frequency : float or (k) Hz
    formants, bandwidths : (n) Hz
    """
    at = np.asarray(frequency, dtype=float)[..., None]
    centre, half = np.asarray(formants, dtype=float), 0.5 * np.asarray(bandwidths, dtype=float)
    below, above = (at - centre) ** 2 + half**2, (at + centre) ** 2 + half**2
    return np.asarray((20.0 * np.log10(centre**2 + half**2) - 10.0 * np.log10(below * above)).sum(axis=-1))


def without_formants(
    difference: Floats, frequency: Floats | float, one: int, other: int, formants: Floats, bandwidths: Floats
) -> Floats:
    """A level difference of two harmonics (dB) less what resonances add to it: H1*-H2* of H1-H2.

    Parameters
    ----------
    difference : (c) dB
    frequency : float or (c) Hz
        Fundamental frequency.
    one, other : int
        The harmonics, from 1 on.
    formants, bandwidths : (n) Hz
    """
    at = np.asarray(frequency, dtype=float)
    added = formant_gain(one * at, formants, bandwidths) - formant_gain(other * at, formants, bandwidths)
    return np.asarray(difference - added)


def cycle_means(time: Floats, signal: Floats, cycles: Cycles) -> Floats:
    """(c) mean of the signal, linear between samples, from the start to the end of each cycle."""
    between = 0.5 * (signal[1:] + signal[:-1]) * np.diff(time)
    summed = np.concatenate(([0.0], np.cumsum(between)))
    k = np.clip(np.searchsorted(time, cycles.starts, side="right") - 1, 0, time.size - 2)
    past = cycles.starts - time[k]
    slope = (signal[k + 1] - signal[k]) / (time[k + 1] - time[k])
    return np.asarray(np.diff(summed[k] + past * (signal[k] + 0.5 * past * slope)) / cycles.periods)
