"""Cycles of a waveform: where they begin, which of them are stationary, and what the voice does.

A cycle is one pulse (:mod:`plica.measures.pulses` tells where it begins), also where pulses alternate.

The voice has ended if no cycle begins in the last stretch of the record, longer than 1.5 of the longest of
the six periods before it. Of periods and peak-to-peak amplitudes, :mod:`plica.measures.stationary` tells
which are the stationary ones up to the end: all of those are used. Without any the voice is changing, and
the last three cycles are used. A stationary voice is steady if its periods scatter by no more than 2 % and
its amplitudes by 5 % (standard deviation), subharmonic if they have a pattern of 2 to 4 pulses, else
irregular. Over the cycles that are used its periods change by no more than 2 % and its amplitudes by 5 %, and
by 0.5 % and 1 % a cycle; where they change by more, but their scatter may explain it, the note says how much.
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

weak = 0.10  # range over the last third, relative to the largest magnitude there
silent = 0.01  # range over the last third, relative to the largest magnitude of the record
over = 1.5  # of the longest period: a voice that is silent for longer has ended


@dataclass(frozen=True)
class Cycles:
    """Consecutive cycles: of a run the stationary part, of a recording all (:mod:`plica.measures.recorded`).

    Attributes
    ----------
    starts : (c + 1) s, the beginning of each cycle and the end of the last; empty without cycles
    note : str
        Why there are none, or what is unusual about them; empty for a steady voice that does not drift.
    verdict : Verdict
        "steady"; "subharmonic": pulses alternate in a pattern that repeats itself; "irregular": stationary,
        but its cycles differ; "changing": it grows, decays or glides, the last three cycles are used;
        "ended": it is silent at the end of the record, these are the cycles before; "none": no cycles. Of a
        recording "regular", "diplophonic", "aperiodic" or "none".
    pattern : int
        Pulses after which a subharmonic or diplophonic voice repeats itself; else 1.
    recorded : bool
        Of a person's voice: what is averaged over them gets a bootstrap interval.
    left_out : tuple of int
        Cycles of a recording, counted from 0, over which nothing is averaged.
    """

    starts: Floats
    note: str = ""
    verdict: Verdict = "steady"
    pattern: int = 1
    recorded: bool = False
    left_out: tuple[int, ...] = ()

    def used(self, values: Floats) -> Floats:
        """(c) values of each cycle, not a number where the cycle is left out."""
        found = np.array(values, dtype=float)
        found[list(self.left_out)] = np.nan
        return found

    @property
    def settled(self) -> bool:
        """Whether the voice repeats itself to the end of the record: steady or subharmonic."""
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

        Not the mean of 1 / T, which is larger where periods differ.
        """
        return self.count / float(self.starts[-1] - self.starts[0]) if self.count else float("nan")

    def samples(self, time: Floats) -> list[slice]:
        """Samples of each cycle: start <= time < end."""
        return _slices(time, self.starts)

    def extent(self, time: Floats) -> slice:
        """Samples of all cycles together; without cycles all of a recording, of a run the last third."""
        if not self.count:
            return slice(0 if self.recorded else time.size - max(time.size // 3, 1), time.size)
        return slice(int(np.searchsorted(time, self.starts[0])), int(np.searchsorted(time, self.starts[-1])))


def find_cycles(time: Floats, signal: Floats, *, name: str = "signal", scale: Scale = SI) -> Cycles:
    """Find the stationary cycles of a signal (the rule stands at the head of this module).

    Parameters
    ----------
    time : (k) s, ascending
    signal : (k), finite
    name : str
        What the signal is, for the notes.
    scale : Scale
        Whether the time is in s or in frames, for the notes.

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
    starts = pulses(time, signal)
    if starts.size <= fewest:
        count = max(starts.size - 1, 0)
        return _none(too_few(count, name, fewest))
    found = _judged(time, signal, starts, scale)
    found = replace(found, note="; ".join(filter(None, (found.note, _again(time, signal, found, name)))))
    varies = float(np.ptp(tail)) / float(np.abs(tail).max())
    if varies >= weak:
        return found
    note = f"weak: the {name} varies by only {100 * varies:.2g} % in the last third of the record"
    return replace(found, note="; ".join(text for text in (note, found.note) if text))


def too_few(count: int, name: str, fewest: int) -> str:
    """Why so few complete cycles of the signal of this name are not measured."""
    cycles = "cycle" if count == 1 else "cycles"
    return f"too short: {count} complete {cycles} of the {name}; at least {fewest} are needed"


def _none(reason: str) -> Cycles:
    return Cycles(np.empty(0), reason, "none")


def _judged(time: Floats, signal: Floats, starts: Floats, scale: Scale) -> Cycles:
    """The cycles to use and what the voice does."""
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
    if until - last <= over * float(periods[-2 * fewest :].max()):
        return found
    apart = np.flatnonzero(np.abs(signal - signal[-1]) > 0.1 * np.ptp(signal[_slices(time, starts)[-1]]))
    silence = float(time[apart[-1]])
    unit = scale.unit("s")
    end = f"the voice ends at t = {silence:.4g} {unit}, the record at {until:.4g}; the cycles before are used"
    before = found.note or "steady until then"
    return replace(found, note=f"{end}; {before}", verdict="ended")


def _again(time: Floats, signal: Floats, found: Cycles, name: str) -> str:
    """That the signal comes up more than once a cycle, from 10 to 20 % of its range."""
    part = found.extent(time)
    low, reach = float(signal[part].min()), float(np.ptp(signal[part]))
    instants = rises(time[part], signal[part], low + 0.1 * reach, low + 0.15 * reach, low + 0.2 * reach)
    count = instants.size + 1  # the first one lies before the first cycle's beginning
    if count < 1.5 * found.count:
        return ""
    return f"the {name} rises {count / found.count:.2g} times a cycle; lesser rises are not counted as cycles"


def _regular(starts: Floats, period: Fit, amplitude: Fit, unit: str) -> Cycles:
    """Of stationary cycles: steady, subharmonic or irregular."""
    pattern = max(period.pattern, amplitude.pattern)
    starts = starts[(starts.size - 1) % pattern :]  # whole patterns, or their odd pulse would tilt the mean
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
        if not wide and exceeds(line, same):  # not by more than chance, or it were not stationary
            way = "rise" if line.rate > 0 else "fall"
            notes.append(
                f"the {what} {way} by {100 * abs(line.rate):.2g} % a cycle, which their scatter about "
                f"that line may explain, over {line.residual.size} cycles: a longer run tells"
            )
    if wide:
        notes.append(f"irregular: {' and '.join(wide)} (standard deviation)")
    verdict: Verdict = "subharmonic" if pattern > 1 else "irregular" if wide else "steady"
    return Cycles(starts, "; ".join(notes), verdict, pattern)


def _trend(periods: Floats, amplitudes: Floats) -> str:
    """What changes over a record, as lines through the logarithms have it."""
    said = []
    if drifts(fit(periods, of_period), of_period):
        rate = np.expm1(slope(-np.log(periods)))
        said.append(f"the frequency {'rises' if rate > 0 else 'falls'} by {100 * abs(rate):.2g} %")
    if drifts(fit(amplitudes, of_amplitude), of_amplitude):
        rate = np.expm1(slope(np.log(amplitudes)))
        said.append(f"the amplitude {'grows' if rate > 0 else 'falls'} by {100 * abs(rate):.2g} %")
    if not said:
        return "periods or amplitudes scatter more in one part of the record than in another"
    return " and ".join(said) + " a cycle"


def _amplitude(time: Floats, signal: Floats, part: slice) -> float:
    """Peak to peak; the top by a parabola, since samples beside it would alternate as a voice does."""
    peak = part.start + int(np.argmax(signal[part]))
    return highest(time, signal, peak)[1] - float(signal[part].min())


def _slices(time: Floats, starts: Floats) -> list[slice]:
    edges = np.searchsorted(time, starts)
    return [slice(int(a), int(b)) for a, b in pairwise(edges)]
