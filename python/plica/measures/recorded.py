"""Cycles of a recording: all complete ones, and the kind of voice.

A recorded voice need not be steady: the differences between its cycles are of clinical interest, so no cycle
is left out.

A first search follows the voice's level. With T the autocorrelation's period of the whole record, limits are
at 15, 25 and 35 % of the way from the least to the largest area within 1.25 T of each instant; where these
are less than a tenth as far apart as in the whole record there is no voice. A pulse rises from the lowest
limit to the highest before it falls back. Its cycle begins at the mean of the three instants at which it
rises through 20, 30 and 40 % of its own height over the least area before it, each by a cubic through the
four samples about it: so a mark depends on one pulse, and on neither its height nor the frame grid. (Lower,
the slits that a lens closes would move it; higher, it would mix two cycles where the period changes between
pulses.) The first and the last cycle are complete; a pulse that the record cuts off at its crest has the
height of the one before it.

The kind follows Titze (Workshop on Acoustic Voice Analysis, 1995) as far as cycles allow: *diplophonic* if
pulses repeat in a pattern of two to four (:mod:`plica.measures.stationary`); *aperiodic* if no lag of the
record has an autocorrelation of 0.5; *ambiguous* if the autocorrelation has another frequency than the pulses
(:func:`plica.measures.cycles.differing`); else *regular*, however much its cycles vary, which jitter and
shimmer measure.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from plica.measures.cycles import Cycles, Verdict, differing, too_few
from plica.measures.instants import highest
from plica.measures.pulses import autocorrelation_frequency, autocorrelation_peak, rises
from plica.measures.record import Floats, time_step
from plica.measures.scale import SI, Scale
from plica.measures.stationary import drifts, fewest, fit, of_amplitude, of_period, slope
from plica.measures.thresholds import mark_shares

Ints = NDArray[np.intp]

_PASSED = 0.9  # of a pulse's height: a record that ends above it may not have the crest
_LIMITS = (0.15, 0.25, 0.35)  # of the local range
_REACH = 1.25  # periods on each side that define the local range
_SILENT = 0.1  # of the whole range; a smaller local range is silence
_PERIODIC = 0.5  # autocorrelation below which a voice is aperiodic
_WEAK = 0.1  # range over the largest value
_WHOLE = 6  # least number of cycles for a pattern
_LOCAL = 10  # cycles of a glide that are near enough in frequency for an autocorrelation


def recorded_cycles(time: Floats, signal: Floats, *, name: str = "signal", scale: Scale = SI) -> Cycles:
    """All complete cycles of a recording (see the module docstring).

    Parameters
    ----------
    time : (k) s, ascending, equidistant
    signal : (k), finite
    name : str
        Name of the signal in the notes.
    scale : Scale
        Whether the time is in s or in frames, for the notes.

    Returns
    -------
    Cycles
        Three or more, or none and a note with the reason.
    """
    if signal.size < 8:
        return _none(f"too short: {signal.size} samples")
    size, largest = float(np.ptp(signal)), float(np.abs(signal).max())
    if size <= 0.01 * largest or largest == 0:
        return _none(f"no oscillation: the {name} varies by less than 1 % over the record")
    starts = marks(time, signal)
    count = max(starts.size - 1, 0)
    if count < fewest:
        return _none(too_few(count, name, fewest))
    verdict, pattern, notes = _kind(time, signal, starts, scale)
    if size < _WEAK * largest:
        notes.insert(0, f"weak: the {name} varies by only {100 * size / largest:.2g} %")
    found = Cycles(starts, "", verdict, pattern, recorded=True)
    said = _no_period(time, signal, found, scale)
    if said and verdict == "regular":
        found = replace(found, verdict="ambiguous")
    return replace(found, note="; ".join(filter(None, (said, *notes))), no_period=said)


def _none(reason: str) -> Cycles:
    return Cycles(np.empty(0), reason, "none", recorded=True)


def marks(time: Floats, signal: Floats) -> Floats:
    """(c + 1) instants (s) at which cycles start, and the end of the last."""
    from scipy import ndimage

    frequency = autocorrelation_frequency(signal, time_step(time))
    period = 1 / frequency / time_step(time) if np.isfinite(frequency) else signal.size / fewest
    width = 2 * max(round(_REACH * period), 2) + 1
    low = ndimage.minimum_filter1d(signal, width, mode="nearest")
    size = np.maximum(ndimage.maximum_filter1d(signal, width, mode="nearest") - low, _SILENT * np.ptp(signal))
    rough = rises(time, (signal - low) / size, *_LIMITS)
    edges = np.searchsorted(time, rough)
    places, passed, last = [], [], 0.0  # the height of the pulse before
    for k, (begin, end) in enumerate(pairwise([*edges.tolist(), signal.size])):
        peak = int(begin) + int(np.argmax(signal[begin:end]))
        before = int(edges[k - 1]) if k else 0
        top = before + int(np.argmax(signal[before:begin])) if k else 0  # of the pulse before
        foot = float(signal[top : peak + 1].min())
        height = highest(time, signal, peak)[1] - foot
        if end == signal.size and signal[peak:].min() > foot + _PASSED * height:
            height = max(height, last)  # the record may end before the crest
        last = height
        levels = [foot + share * height for share in mark_shares]
        lowest = top + int(np.flatnonzero(signal[top : peak + 1] == foot)[-1])
        if lowest == 0 or signal[peak] < levels[-1]:
            continue  # the record starts, or ends, within the flank
        below = [np.flatnonzero(signal[top:peak] < level) for level in levels]
        if below[0].size:  # the record has all of the flank
            places.append([top + int(k[-1]) + 1 for k in below])
            passed.append(levels)
    if not places:
        return np.empty(0)
    instants = _crossings(time, signal, np.ravel(places), np.ravel(passed))
    return np.array([np.mean(each) for each in np.split(instants, len(places))])


def _crossings(time: Floats, signal: Floats, k: Ints, level: Floats) -> Floats:
    """Instants (n) between samples k - 1 and k at which a cubic through the four nearest samples crosses the
    level.

    Linear at the ends of the record, and if the cubic leaves the interval (near a corner of the signal).
    """
    part = (level - signal[k - 1]) / (signal[k] - signal[k - 1])
    within = np.flatnonzero((k >= 2) & (k < signal.size - 1))
    within = within[signal[k[within] - 2] < signal[k[within] - 1]]
    y = [signal[k[within] + after] - level[within] for after in (-2, -1, 0, 1)]  # at -1, 0, 1 and 2
    third, second = (y[3] - y[0]) / 6 - (y[2] - y[1]) / 2, (y[0] + y[2]) / 2 - y[1]
    cubic = np.stack((third, second, y[2] - y[1] - third - second, y[1]), axis=1)
    bent = third != 0
    companion = np.zeros((np.count_nonzero(bent), 3, 3))
    companion[:, [1, 2], [0, 1]] = 1.0
    companion[:, 0] = -cubic[bent, 1:] / cubic[bent, :1]
    roots = np.full((len(cubic), 3), np.nan, dtype=complex)
    roots[bent] = np.linalg.eigvals(companion)
    for one in np.flatnonzero(~bent):
        found = np.roots(cubic[one])
        roots[one, : found.size] = found
    inside = (np.abs(roots.imag) < 1e-9) & (roots.real >= 0) & (roots.real <= 1)
    once = inside.sum(axis=1) == 1
    part[within[once]] = roots.real[once][inside[once]]
    return np.asarray(time[k - 1] + part * (time[k] - time[k - 1]))


def heights(time: Floats, signal: Floats, cycles: Cycles) -> Floats:
    """(c) range of each cycle, with the maximum by a parabola."""
    found = []
    for part in cycles.samples(time):
        peak = part.start + int(np.argmax(signal[part]))
        found.append(highest(time, signal, peak)[1] - float(signal[part].min()))
    return np.array(found)


def _kind(time: Floats, signal: Floats, starts: Floats, scale: Scale) -> tuple[Verdict, int, list[str]]:
    periods = np.diff(starts)
    lines = (
        fit(periods, of_period),
        fit(heights(time, signal, Cycles(starts)), of_amplitude),
    )
    pattern = max(line.pattern for line in lines)
    notes = _trend(periods)
    likeness = autocorrelation_peak(signal, time_step(time))[1]
    if not likeness >= _PERIODIC:
        shown = f"{likeness:.2g}" if np.isfinite(likeness) else "none"
        return "aperiodic", 1, [f"aperiodic: the largest autocorrelation is {shown}", *notes]
    if pattern > 1 and periods.size >= _WHOLE:
        frequency = periods.size / float(starts[-1] - starts[0])
        unit = scale.unit("Hz")
        note = (
            f"diplophonic: the pulses ({frequency:.4g} {unit}) repeat in a pattern of {pattern} "
            f"({frequency / pattern:.4g} {unit}); measures are those of the pulses"
        )
        return "diplophonic", pattern, [note, *notes]
    return "regular", 1, notes


def _no_period(time: Floats, signal: Floats, found: Cycles, scale: Scale) -> str:
    """Why the pulses are no periods; empty if they are.

    Where the frequency glides, the whole record has no one autocorrelation: the middle cycles are asked.
    """
    part = found
    if found.count > _LOCAL and _trend(found.periods):
        first = (found.count - _LOCAL) // 2
        part = replace(found, starts=found.starts[first : first + _LOCAL + 1])
    other = autocorrelation_frequency(signal[part.extent(time)], time_step(time))
    return differing(part, other, scale)


def _trend(periods: Floats) -> list[str]:
    """A note if the frequency changes."""
    if not drifts(fit(periods, of_period), of_period):
        return []
    rate = np.expm1(slope(-np.log(periods)))
    return [f"the frequency {'rises' if rate > 0 else 'falls'} by {100 * abs(rate):.2g} % a cycle"]
