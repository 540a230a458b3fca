"""Measures of the simulated or recorded motion of the left and the right fold."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from plica.measures.cycles import Cycles
from plica.measures.measure import Measure, absent, per_cycle, per_cycle_angle
from plica.measures.phase import Mask, crest, fundamentals, phase_lag, still
from plica.measures.record import Floats

_NAMES = ("amplitude_left", "amplitude_right", "amplitude_ratio", "amplitude_asymmetry", "left_right_phase")


def amplitudes(time: Floats, signal: Floats, cycles: Cycles) -> Floats:
    """(c) half the peak-to-peak range of the signal in each cycle."""
    return np.array([0.5 * np.ptp(signal[part]) for part in cycles.samples(time)])


def asymmetry(left: Floats, right: Floats) -> Floats:
    """(right - left) / (right + left); NaN if neither moves."""
    return ratio(right - left, right + left)


def ratio(top: Floats, bottom: Floats) -> Floats:
    """Top over bottom; NaN where the bottom is not positive."""
    found: Floats = np.divide(top, bottom, out=np.full(top.shape, np.nan), where=bottom > 0)
    return found


def lags(time: Floats, first: Floats, second: Floats, cycles: Cycles) -> Floats:
    """(c) rad, lag of the second signal behind the first at each cycle's fundamental."""
    both = (first, second)
    return np.array([phase_lag(*fundamentals(time, both, *ends)) for ends in pairwise(cycles.starts)])


def crest_lags(
    time: Floats, first: Floats, second: Floats, cycles: Cycles, apart: Mask | None = None
) -> Floats:
    """(c) rad, lag of the crest of the second edge behind that of the first, in each cycle.

    Of samples (k) in which the folds are `apart`, by default those in which these edges are: what stops the
    edges of folds that touch is no part of their phase.
    """
    if apart is None:
        width = first + second
        apart = width > still * np.abs(width).max(initial=0.0)
    return np.array(
        [
            phase_lag(crest(time, first, apart, *ends), crest(time, second, apart, *ends))
            for ends in pairwise(cycles.starts)
        ]
    )


def side_measures(
    time: Floats,
    left: Floats,
    right: Floats,
    cycles: Cycles,
    notes: tuple[str, str] = ("", ""),
    between: str = "",
) -> list[Measure]:
    """Amplitudes of the folds, their ratio and asymmetry, and the phase between them.

    Parameters
    ----------
    time : (k)
    left, right : (k)
        Distance of each fold's edge from the midline, both increasing as the glottis opens.
    cycles : Cycles
    notes : (str, str)
        Notes of the left and of the right amplitude.
    between : str
        Note of the measures that compare them.
    """
    if not cycles.count:
        return [absent(name, cycles.note) for name in _NAMES]
    of_left, of_right = amplitudes(time, left, cycles), amplitudes(time, right, cycles)
    return [
        per_cycle("amplitude_left", cycles, of_left, notes[0]),
        per_cycle("amplitude_right", cycles, of_right, notes[1]),
        per_cycle("amplitude_ratio", cycles, ratio(of_right, of_left), between),
        per_cycle("amplitude_asymmetry", cycles, asymmetry(of_left, of_right), between),
        per_cycle_angle("left_right_phase", cycles, crest_lags(time, left, right, cycles), between),
    ]
