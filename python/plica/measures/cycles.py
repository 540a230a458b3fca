"""Cycles of a waveform: their starts, which of them are stationary, and the kind of vibration.

A cycle is one pulse (its start is defined in :mod:`plica.measures.pulses`), also if pulses alternate.

The vibration has ended if no cycle starts in the last part of the record, longer than 1.5 of the longest of
the six periods before it. :mod:`plica.measures.stationary` determines from periods and peak-to-peak
amplitudes which cycles up to the end are stationary: all of those are used. Without any the vibration is
changing, and the last three cycles are used; it is decaying if its amplitude falls and is below half of the
largest (a quarter of the energy: no voice settles from so far above its steady amplitude). A stationary
vibration is subharmonic if it has a pattern of 2 to 4 pulses, irregular if the standard deviation is above
2 % for periods or 5 % for amplitudes, undecided if they probably change by more than 2 % and 5 % over the
cycles used (or 0.5 % and 1 % per cycle) though chance may explain it, else steady.

Of regular voices (1 % jitter, 3 % shimmer) some 1 % are called changing and up to 10 % undecided; growth of
2 % a cycle over ten such cycles is called changing in 97 % and steady in under 1 %. Without scatter both are
exact.
(tests/python/measures/test_cycles.py counts them on seeded records.)

Cycles are no periods where the autocorrelation finds another frequency, by more than 2 % and more than three
standard errors of the mean period (or 10 %, whatever these are), which no pattern explains: then there is no
fundamental frequency, and nothing is measured per cycle ("ambiguous"). A recording keeps such pulses, but
shares of a period and phases have no value.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Literal

import numpy as np

from plica.measures.instants import highest
from plica.measures.pulses import autocorrelation_frequency, pulses, rises
from plica.measures.record import Floats, time_step
from plica.measures.scale import SI, Scale
from plica.measures.stationary import (
    Fit,
    drifts,
    fewest,
    fit,
    may_drift,
    of_amplitude,
    of_period,
    slope,
    stationary_from,
)

Verdict = Literal[
    "steady",
    "subharmonic",
    "irregular",
    "undecided",
    "changing",
    "decaying",
    "ambiguous",
    "ended",
    "none",
    "regular",
    "diplophonic",
    "aperiodic",
]

weak = 0.10  # range in the last third, relative to the largest magnitude there
silent = 0.01  # range in the last third, relative to the largest magnitude of the record
largest_difference = 0.02  # relative, of the frequencies by cycles and by autocorrelation
most_doubtful = 0.1  # the same, however much the periods scatter
decayed = 0.5  # of the largest amplitude, below which one that still falls is a decay
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
        differ; "undecided": it probably still changes, or it is chance; "changing": amplitude or frequency
        change, the last three cycles are used; "decaying": so, to less than half; "ended": silent at the end
        of the record, these are the cycles before; "ambiguous": pulses are no periods, there are no cycles;
        "none": no cycles. For a recording "regular", "diplophonic", "aperiodic", "ambiguous" or "none".
    pattern : int
        Number of pulses after which a subharmonic or diplophonic vibration repeats; else 1.
    recorded : bool
        Whether they are from a recording: averages then have a bootstrap interval.
    left_out : tuple of int
        Indices of cycles of a recording that are excluded from averages.
    growth : float or None
        Relative change of the amplitude per cycle by which a vibration is changing or decaying (the slope of
        its logarithm over the last half of all cycles found): the cycles used are too few for it.
    no_period : str
        Why the cycles are no periods of a voice, so that shares of a period and phases have no value: the
        autocorrelation finds another frequency, or a run's vibration decays; empty if they are.
    """

    starts: Floats
    note: str = ""
    verdict: Verdict = "steady"
    pattern: int = 1
    recorded: bool = False
    left_out: tuple[int, ...] = ()
    growth: float | None = None
    no_period: str = ""

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
    if varies < weak:
        note = f"weak: the {name} varies by only {100 * varies:.2g} % in the last third of the record"
        found = replace(found, note="; ".join(text for text in (note, found.note) if text))
    other = autocorrelation_frequency(signal[found.extent(time)], time_step(time))
    said = differing(found, other, scale)
    if found.verdict == "decaying":
        return replace(found, no_period=found.note)
    if said and found.verdict != "changing":
        return Cycles(np.empty(0), "; ".join(filter(None, (said, found.note))), "ambiguous")
    return replace(found, no_period=said)


def differing(cycles: Cycles, other: float, scale: Scale = SI) -> str:
    """Why cycles are no periods: the autocorrelation finds another frequency; empty if it does not.

    Both may differ by 2 %, by three standard errors of the mean period, though by 10 % at most, as few cycles
    that differ much would agree with any frequency, and by a divisor of the pattern.

    Parameters
    ----------
    cycles : Cycles
        At least three.
    other : float
        Hz, by autocorrelation; NaN if it finds none.
    """
    unit, periods = scale.unit("Hz"), cycles.periods
    doubt = 3.0 * float(periods.std(ddof=1)) / float(periods.mean()) / np.sqrt(periods.size)
    limit = min(max(largest_difference, doubt if np.isfinite(doubt) else 0.0), most_doubtful)
    explained = [m for m in range(1, cycles.pattern + 1) if cycles.pattern % m == 0]
    if any(abs(np.log(m * other / cycles.frequency)) < limit for m in explained):
        return ""
    found = f"gives {other:.4g} {unit}" if np.isfinite(other) else "finds none"
    return (
        f"no fundamental frequency: the pulses have {cycles.frequency:.4g} {unit}, the autocorrelation "
        f"{found}: pulses are no periods"
    )


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
        found = _changing(starts, periods, amplitudes, scale.unit("Hz"))
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
    notes, undecided = [], False
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
        if not wide and may_drift(line, same):
            trend = "rise" if line.rate > 0 else "fall"
            undecided = True
            notes.append(
                f"the {what} {trend} by {100 * abs(line.rate):.2g} % a cycle over {line.residual.size} "
                "cycles, which is within their scatter: a longer run would clarify this"
            )
    if wide:
        notes.append(f"irregular: {' and '.join(wide)} (standard deviation)")
    verdict: Verdict = "steady"
    if wide or undecided:
        verdict = "irregular" if wide else "undecided"
    if pattern > 1 and not undecided:
        verdict = "subharmonic"
    return Cycles(starts, "; ".join(notes), verdict, pattern)


def _changing(starts: Floats, periods: Floats, amplitudes: Floats, unit: str) -> Cycles:
    """The last cycles of a vibration that changes, and how it does."""
    late = max(amplitudes.size // 2, min(2 * fewest, amplitudes.size))  # its present trend, not its start's
    growth = float(np.expm1(slope(np.log(amplitudes[-late:]))))
    left = float(amplitudes[-fewest:].mean() / amplitudes.max())
    overall = float(np.expm1(slope(np.log(amplitudes))))
    # Few cycles at the end may scatter too much to show alone what the whole record shows.
    falls = growth < 0 and (
        drifts(fit(amplitudes[-late:], of_amplitude), of_amplitude)
        or (growth < overall / 2 and drifts(fit(amplitudes, of_amplitude), of_amplitude))
    )
    used = f"the last {fewest} cycles are used"
    if falls and left < decayed:
        frequency = fewest / float(starts[-1] - starts[-fewest - 1])
        note = (
            f"free decay: the amplitude falls by {100 * abs(growth):.2g} % a cycle, to {left:.2g} of its "
            f"largest, at {frequency:.4g} {unit}; {used}"
        )
        return Cycles(starts[-fewest - 1 :], note, "decaying", growth=growth)
    trend = _trend(periods[-late:], amplitudes[-late:]) or _trend(periods, amplitudes)
    if not trend:
        trend = "periods or amplitudes scatter more in one part of the record than in another"
    return Cycles(starts[-fewest - 1 :], f"not settled: {trend}; {used}", "changing", growth=growth)


def _trend(periods: Floats, amplitudes: Floats) -> str:
    """The trends of frequency and amplitude, as text, from lines through the logarithms; empty without."""
    trends = []
    if drifts(fit(periods, of_period), of_period):
        rate = np.expm1(slope(-np.log(periods)))
        trends.append(f"the frequency {'rises' if rate > 0 else 'falls'} by {100 * abs(rate):.2g} %")
    if drifts(fit(amplitudes, of_amplitude), of_amplitude):
        rate = np.expm1(slope(np.log(amplitudes)))
        trends.append(f"the amplitude {'grows' if rate > 0 else 'falls'} by {100 * abs(rate):.2g} %")
    return f"{' and '.join(trends)} a cycle over the last {periods.size} cycles" if trends else ""


def _amplitude(time: Floats, signal: Floats, part: slice) -> float:
    """Peak to peak; the maximum by a parabola, since sampled maxima would alternate like a voice."""
    peak = part.start + int(np.argmax(signal[part]))
    return highest(time, signal, peak)[1] - float(signal[part].min())


def _slices(time: Floats, starts: Floats) -> list[slice]:
    edges = np.searchsorted(time, starts)
    return [slice(int(a), int(b)) for a, b in pairwise(edges)]
