"""Cycles of a waveform: their starts, which of them are stationary, and the kind of vibration.

A cycle is one pulse (its start is defined in :mod:`plica.measures.pulses`), also if pulses alternate.

The vibration has ended if no cycle starts in the last part of the record, longer than 1.5 of the longest of
the six periods before it. :mod:`plica.measures.stationary` determines from periods and peak-to-peak
amplitudes which cycles up to the end are stationary: all of those are used. Without any the vibration is
changing, and the last three cycles are used. A stationary vibration is steady if the standard deviation is
at most 2 % for periods and 5 % for amplitudes, subharmonic if they have a pattern of 2 to 4 pulses, else
irregular. Over the cycles used, periods change by at most 2 % and amplitudes by 5 %, and by 0.5 % and 1 %
per cycle; if they change by more, but within their scatter, the note states the change.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Literal

import numpy as np

from plica.measures.instants import highest
from plica.measures.pulses import pulses, rises
from plica.measures.record import Floats
from plica.measures.scale import SI, Scale
from plica.measures.stationary import (
    Fit,
    drifts,
    exceeds,
    fewest,
    fit,
    of_amplitude,
    of_period,
    slope,
    stationary_from,
)

Verdict = Literal[
    "steady",
    "subharmonic",
    "irregular",
    "changing",
    "ended",
    "none",
    "regular",
    "diplophonic",
    "aperiodic",
]

weak = 0.10  # range in the last third, relative to the largest magnitude there
silent = 0.01  # range in the last third, relative to the largest magnitude of the record
longest_silence = 1.5  # in longest periods; after a longer silence the vibration has ended


@dataclass(frozen=True)
class Cycles:
    """Consecutive cycles: of a run the stationary part, of a recording all (:mod:`plica.measures.recorded`).

    Attributes
    ----------
    starts : (c + 1) s, the start of each cycle and the end of the last; empty without cycles
    note : str
        Why there are none, or what is unusual about them; empty for a steady vibration without drift.
    verdict : Verdict
        "steady"; "subharmonic": pulses alternate in a repeating pattern; "irregular": stationary, but cycles
        differ; "changing": amplitude or frequency change, the last three cycles are used; "ended": silent at
        the end of the record, these are the cycles before; "none": no cycles. For a recording "regular",
        "diplophonic", "aperiodic" or "none".
    pattern : int
        Number of pulses after which a subharmonic or diplophonic vibration repeats; else 1.
    recorded : bool
        Whether they are from a recording: averages then have a bootstrap interval.
    left_out : tuple of int
        Indices of cycles of a recording that are excluded from averages.
    """

    starts: Floats
    note: str = ""
    verdict: Verdict = "steady"
    pattern: int = 1
    recorded: bool = False
    left_out: tuple[int, ...] = ()

    def used(self, values: Floats) -> Floats:
        """(c) values of each cycle, NaN for excluded cycles."""
        found = np.array(values, dtype=float)
        found[list(self.left_out)] = np.nan
        return found

    @property
    def settled(self) -> bool:
        """Whether the vibration is steady or subharmonic to the end of the record."""
        return self.verdict in ("steady", "subharmonic")

    @property
    def count(self) -> int:
        """Number of cycles; 0 if fewer than three were found."""
        return max(self.starts.size - 1, 0)

    @property
    def periods(self) -> Floats:
        """(c) s."""
        return np.diff(self.starts)

    @property
    def frequency(self) -> float:
        """Cycles per second, c / (t_c - t_0) for c cycles; NaN without cycles.

        Not the mean of 1 / T, which is larger if periods differ.
        """
        return self.count / float(self.starts[-1] - self.starts[0]) if self.count else float("nan")

    def samples(self, time: Floats) -> list[slice]:
        """Samples of each cycle: start <= time < end."""
        return _slices(time, self.starts)

    def extent(self, time: Floats) -> slice:
        """Samples of all cycles; without cycles all of a recording, or the last third of a run."""
        if not self.count:
            return slice(0 if self.recorded else time.size - max(time.size // 3, 1), time.size)
        return slice(int(np.searchsorted(time, self.starts[0])), int(np.searchsorted(time, self.starts[-1])))


def find_cycles(time: Floats, signal: Floats, *, name: str = "signal", scale: Scale = SI) -> Cycles:
    """Find the stationary cycles of a signal (see the module docstring).

    Parameters
    ----------
    time : (k) s, ascending
    signal : (k), finite
    name : str
        Name of the signal in the notes.
    scale : Scale
        Whether the time is in s or in frames, for the notes.

    Returns
    -------
    Cycles
        At least three cycles, or none and a note with the reason.
    """
    if signal.size < 8:
        return _none(f"too short: {signal.size} samples")
    tail = signal[signal.size - signal.size // 3 :]
    largest = float(np.abs(signal).max())
    if np.ptp(tail) <= silent * largest:
        if float(np.abs(tail).max()) <= silent * largest:
            return _none(f"no oscillation: the {name} stays at zero in the last third of the record")
        return _none(f"no oscillation: the {name} varies by less than 1 % in the last third of the record")
    starts = pulses(time, signal)
    if starts.size <= fewest:
        count = max(starts.size - 1, 0)
        return _none(too_few(count, name, fewest))
    found = _classified(time, signal, starts, scale)
    found = replace(
        found, note="; ".join(filter(None, (found.note, _extra_rises(time, signal, found, name))))
    )
    varies = float(np.ptp(tail)) / float(np.abs(tail).max())
    if varies >= weak:
        return found
    note = f"weak: the {name} varies by only {100 * varies:.2g} % in the last third of the record"
    return replace(found, note="; ".join(text for text in (note, found.note) if text))


def too_few(count: int, name: str, fewest: int) -> str:
    """The reason for not measuring this number of complete cycles."""
    cycles = "cycle" if count == 1 else "cycles"
    return f"too short: {count} complete {cycles} of the {name}; at least {fewest} are needed"


def _none(reason: str) -> Cycles:
    return Cycles(np.empty(0), reason, "none")


def _classified(time: Floats, signal: Floats, starts: Floats, scale: Scale) -> Cycles:
    """The cycles to use and the kind of vibration."""
    periods = np.diff(starts)
    amplitudes = np.array([_amplitude(time, signal, part) for part in _slices(time, starts)])
    first = stationary_from([(periods, of_period), (amplitudes, of_amplitude)])
    if first is None:
        used = starts[-fewest - 1 :]
        note = f"not settled: {_trend(periods, amplitudes)}; the last {fewest} cycles are used"
        found = Cycles(used, note, "changing")
    else:
        lines = fit(periods[first:], of_period), fit(amplitudes[first:], of_amplitude)
        found = _regular(starts[first:], *lines, scale.unit("Hz"))
    last, until = float(starts[-1]), float(time[-1])
    if until - last <= longest_silence * float(periods[-2 * fewest :].max()):
        return found
    apart = np.flatnonzero(np.abs(signal - signal[-1]) > 0.1 * np.ptp(signal[_slices(time, starts)[-1]]))
    silence = float(time[apart[-1]])
    unit = scale.unit("s")
    end = f"the voice ends at t = {silence:.4g} {unit}, the record at {until:.4g}; the cycles before are used"
    before = found.note or "steady until then"
    return replace(found, note=f"{end}; {before}", verdict="ended")


def _extra_rises(time: Floats, signal: Floats, found: Cycles, name: str) -> str:
    """A note if the signal rises more than once per cycle, from 10 to 20 % of its range."""
    part = found.extent(time)
    low, reach = float(signal[part].min()), float(np.ptp(signal[part]))
    instants = rises(time[part], signal[part], low + 0.1 * reach, low + 0.15 * reach, low + 0.2 * reach)
    count = instants.size + 1  # the first one is before the start of the first cycle
    if count < 1.5 * found.count:
        return ""
    return f"the {name} rises {count / found.count:.2g} times a cycle; lesser rises are not counted as cycles"


def _regular(starts: Floats, period: Fit, amplitude: Fit, unit: str) -> Cycles:
    """Classify stationary cycles as steady, subharmonic or irregular."""
    pattern = max(period.pattern, amplitude.pattern)
    starts = starts[(starts.size - 1) % pattern :]  # whole patterns, so that no extra pulse biases the mean
    frequency = (starts.size - 1) / float(starts[-1] - starts[0])
    notes = []
    if pattern > 1:
        notes.append(
            f"subharmonic: the pulses ({frequency:.4g} {unit}) repeat in a pattern of {pattern} "
            f"({frequency / pattern:.4g} {unit}); frequency and quotients are those of the pulses"
        )
    scatter = [(period, of_period, "periods"), (amplitude, of_amplitude, "amplitudes")]
    wide = [
        f"{what} scatter by {100 * line.spread:.2g} %"
        for line, same, what in scatter
        if line.spread > same.scatter
    ]
    for line, same, what in scatter:
        if not wide and exceeds(line, same):  # within chance, as the cycles are stationary
            trend = "rise" if line.rate > 0 else "fall"
            notes.append(
                f"the {what} {trend} by {100 * abs(line.rate):.2g} % a cycle over {line.residual.size} "
                "cycles, which is within their scatter: a longer run would clarify this"
            )
    if wide:
        notes.append(f"irregular: {' and '.join(wide)} (standard deviation)")
    verdict: Verdict = "subharmonic" if pattern > 1 else "irregular" if wide else "steady"
    return Cycles(starts, "; ".join(notes), verdict, pattern)


def _trend(periods: Floats, amplitudes: Floats) -> str:
    """The trends of frequency and amplitude over a record, as text, from lines through the logarithms."""
    trends = []
    if drifts(fit(periods, of_period), of_period):
        rate = np.expm1(slope(-np.log(periods)))
        trends.append(f"the frequency {'rises' if rate > 0 else 'falls'} by {100 * abs(rate):.2g} %")
    if drifts(fit(amplitudes, of_amplitude), of_amplitude):
        rate = np.expm1(slope(np.log(amplitudes)))
        trends.append(f"the amplitude {'grows' if rate > 0 else 'falls'} by {100 * abs(rate):.2g} %")
    if not trends:
        return "periods or amplitudes scatter more in one part of the record than in another"
    return " and ".join(trends) + " a cycle"


def _amplitude(time: Floats, signal: Floats, part: slice) -> float:
    """Peak to peak; the maximum by a parabola, since sampled maxima would alternate like a voice."""
    peak = part.start + int(np.argmax(signal[part]))
    return highest(time, signal, peak)[1] - float(signal[part].min())


def _slices(time: Floats, starts: Floats) -> list[slice]:
    edges = np.searchsorted(time, starts)
    return [slice(int(a), int(b)) for a, b in pairwise(edges)]
