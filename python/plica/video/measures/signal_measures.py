"""Measures of the sound and of the electroglottogram beside a recording, and of their agreement with it.

The sound's first period is that of the autocorrelation of 50 ms, the median over all that are not silent
(less than 0.3 of the loudest). From mark to mark a period is the lag, within a fifth of the one before, at
which the sound from the mark on, a period long, has the largest correlation with the sound later by it (by a
parabola through three lags); the longest run of periods with a correlation of 0.5 or more counts. So all
harmonics tell the period, as a fundamental may be weak.

Two frequencies are compared over the time that both have, to half a period; they disagree where they differ
by more than 2 %, and by more than both intervals.

The lag of the electroglottogram is from the instant at which the glottal area closes to the nearest closing
peak: the area closes where it falls to the level of the closed quotient, without closure to a tenth of its
range. Lags are averaged as angles of the cycle, and are known up to whole periods.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from plica.measures.catalogue import names
from plica.measures.circular import circular_mean
from plica.measures.cycles import Cycles, too_few
from plica.measures.electroglottogram import Contact, contact_of
from plica.measures.instants import highest
from plica.measures.interval import of_ratio
from plica.measures.measure import Measure, absent, average, cycle_frequency, per_period, whole
from plica.measures.perturbation import jitter_of
from plica.measures.pulses import autocorrelation_frequency
from plica.measures.quotients import closed_intervals, leak_level
from plica.measures.sound_quality import sound_measures
from plica.measures.stationary import fewest
from plica.measures.thresholds import closed_share
from plica.video.files.signal_file import Signal
from plica.video.measures.wave_cautions import cautioned

__all__ = ["SignalMeasures", "closing_instants", "signal_measures", "sound_cycles"]

Floats = npt.NDArray[np.float64]

_NEAR = 0.2  # of the period before, within which the next one is
_WINDOW = 0.05  # s: three periods of the lowest voice
_SILENT = 0.3  # of the loudest window
_ALIKE = 0.5  # correlation of a period with the next, below which a sound has none
_AGREES = 0.02  # relative, of two frequencies
_FEWEST = 4.0  # samples a cycle
_ENOUGH = 50  # samples a cycle, with which a quotient is known to 2 %
_SKEWED = 0.25  # skewness of a slope that is clearly of one sign
_APART = 0.15  # of the period: a lag that no larynx has
_SCATTERED = 0.05  # of the period, besides a frame
_CLIPPED = 0.01  # % of the samples
_CALLED = {"sound": "sound", "egg": "electroglottogram"}


@dataclass(frozen=True)
class SignalMeasures:
    """Measures of the signals, and what speaks against them and against the recording's times.

    Attributes
    ----------
    measures : list of Measure
    doubts : list of str
        A sentence each.
    of_rate : list of str
        Those of them that speak against the frame rate.
    """

    measures: list[Measure]
    doubts: list[str]
    of_rate: list[str]


def signal_measures(
    sound: Signal | None, egg: Signal | None, area: Floats, cycles: Cycles, fps: float
) -> SignalMeasures:
    """Measure the signals that there are.

    Parameters
    ----------
    sound, egg : Signal or None
        On the time of the area; the electroglottogram grows with contact.
    area : (frames) finite
        Glottal area, in any unit.
    cycles : Cycles
        Of the area, s.
    fps : float
        Frames per second.
    """
    found: list[Measure] = []
    doubts: list[str] = []
    of_rate: list[str] = []
    for name, signal in (("sound", sound), ("egg", egg)):
        if signal is None:
            continue
        if cycles.count and signal.rate < _FEWEST * cycles.frequency:
            said = (
                f"{signal.rate:g} samples/s for a voice of {cycles.frequency:.4g} Hz; must be "
                f"{_FEWEST:g} times as many or more"
            )
            found += [absent(one, said) for one in _names_of(name)]
            continue
        frame_time = np.arange(area.size) / fps
        measured, apart, further = (
            _of_sound(signal, cycles) if name == "sound" else _of_egg(signal, frame_time, area, cycles, fps)
        )
        clipped = _clipped(signal)
        found += cautioned(measured, clipped)
        of_rate += apart
        doubts += [*apart, *further, *(f"the {_CALLED[name]} is bad: {text}" for text in clipped)]
    return SignalMeasures(found, doubts, of_rate)


def _names_of(signal: str) -> list[str]:
    return sorted(names(recorded_from="signal", signal=signal))


def _clipped(signal: Signal) -> list[str]:
    """A caution of samples at full scale."""
    share = 100 * signal.clipped
    return [f"{share:.2g} % of its samples are clipped: record at a lower level"] if share > _CLIPPED else []


def sound_cycles(signal: Signal) -> Cycles:
    """Cycles of a sound, each as long as the lag at which it is most like what follows it (see the module
    docstring); none where the sound has no frequency."""
    values = signal.values - signal.values.mean()
    near = _usual_frequency(values, signal.rate)
    if not np.isfinite(near):
        return Cycles(np.empty(0), "the sound has no fundamental frequency", "none", recorded=True)
    first = period = signal.rate / near
    marks, likeness = [0.0], []
    while (found := _next_period(values, marks[-1], period)) is not None:
        lag, like = found
        marks.append(marks[-1] + lag)
        likeness.append(like)
        period = lag if like >= _ALIKE else first
    begin, end = _longest([like >= _ALIKE for like in likeness])
    if end - begin < fewest:
        return Cycles(np.empty(0), too_few(end - begin, "sound", fewest), "none", recorded=True)
    return Cycles(signal.begin + np.array(marks[begin : end + 1]) / signal.rate, "", "regular", recorded=True)


def _usual_frequency(values: Floats, rate: float) -> float:
    """Median (Hz) of the autocorrelation's frequencies over windows of 50 ms that are not silent."""
    length = min(int(_WINDOW * rate), values.size)
    windows = values[: values.size // length * length].reshape(-1, length)
    loud = np.std(windows, axis=1)
    found = [autocorrelation_frequency(one, 1 / rate) for one in windows[loud > _SILENT * loud.max()]]
    known = [frequency for frequency in found if np.isfinite(frequency)]
    return float(np.median(known)) if known else float("nan")


def _next_period(values: Floats, mark: float, period: float) -> tuple[float, float] | None:
    """Lag (samples) within a fifth of the period at which the period from the mark on is most like what
    follows, and the correlation there; None where the signal ends before."""
    begin, length = round(mark), round(period)
    lags = np.arange(int((1 - _NEAR) * period), int((1 + _NEAR) * period) + 2)
    if begin + length + int(lags[-1]) > values.size or lags.size < 3 or lags[0] < 1:
        return None
    window = values[begin : begin + length]
    later = np.lib.stride_tricks.sliding_window_view(values[begin : begin + length + int(lags[-1])], length)[
        lags
    ]
    size = np.linalg.norm(window) * np.linalg.norm(later, axis=1)
    likeness = np.divide(later @ window, size, out=np.zeros(lags.size), where=size > 0)
    return highest(lags.astype(float), likeness, int(np.argmax(likeness)))


def _longest(kept: list[bool]) -> tuple[int, int]:
    """Begin and end of the longest run of those that are kept."""
    best, begin = (0, 0), 0
    for k, keep in enumerate([*kept, False]):
        if not keep:
            best = max(best, (begin, k), key=lambda run: run[1] - run[0])
            begin = k + 1
    return best


def _of_sound(signal: Signal, area_cycles: Cycles) -> tuple[list[Measure], list[str], list[str]]:
    cycles = sound_cycles(signal)
    frequency = replace(cycle_frequency(cycles), name="sound_frequency")
    agreement, apart = _agreement("sound_frequency_difference", "sound", cycles, area_cycles)
    quality = sound_measures(signal.time, signal.values, cycles)
    return [*cautioned([frequency], apart), agreement, *quality], apart, []


def _of_egg(
    signal: Signal, time: Floats, area: Floats, area_cycles: Cycles, fps: float
) -> tuple[list[Measure], list[str], list[str]]:
    contact = contact_of(signal.time, signal.values)
    cycles = contact.cycles
    frequency = replace(cycle_frequency(cycles), name="egg_frequency")
    agreement, apart = _agreement("egg_frequency_difference", "electroglottogram", cycles, area_cycles)
    found = [*cautioned([frequency], apart), agreement, jitter_of("egg_jitter", cycles)]
    if cycles.count and contact.skewness < -_SKEWED:
        said = (
            f"the electroglottogram seems upside down: the skewness of its slope is {contact.skewness:.2g}; "
            "must be > 0, as folds meet faster than they part. Invert it: FILE.wav:-CHANNEL"
        )
        known = {item.name for item in found}
        rest = [absent(name, said) for name in _names_of("egg") if name not in known]
        return [*found, *rest], apart, [said]
    found += _quotients(contact, signal)
    lag, doubts = _lag(contact, time, area, area_cycles, fps)
    return [*found, lag], apart, doubts


def _quotients(contact: Contact, signal: Signal) -> list[Measure]:
    cycles, cautions = contact.cycles, []
    if cycles.count:
        if contact.skewness < _SKEWED:
            cautions.append(
                f"the skewness of the slope is {contact.skewness:.2g}, of little contact or an inverted "
                "signal: check that more contact is up"
            )
        samples = float(np.median(cycles.periods)) * signal.rate
        if samples < _ENOUGH:
            cautions.append(
                f"{samples:.3g} samples a cycle: contact is known to about {100 / samples:.2g} % of it"
            )
    by_level = per_period("egg_contact_quotient_level", cycles, contact.by_level, cautions=cautions)
    return [by_level, _by_peaks(contact, cautions)]


def _by_peaks(contact: Contact, cautions: list[str]) -> Measure:
    name, cycles, values = "egg_contact_quotient_peaks", contact.cycles, contact.by_peaks
    single = int(np.isfinite(values).sum())
    if cycles.count and 2 * single < cycles.count:
        closing, opening = (
            int((~kept).sum()) for kept in (contact.single_closing[:-1], contact.single_opening)
        )
        return absent(
            name,
            f"peaks of the slope are single in {single} of {cycles.count} cycles; must be in half of them "
            f"(closing peaks not single: {closing}, opening peaks: {opening})",
        )
    if single < cycles.count:
        cautions = [*cautions, f"peaks are not single in {cycles.count - single} of {cycles.count} cycles"]
    return per_period(name, cycles, values, cautions=cautions)


def _agreement(name: str, called: str, cycles: Cycles, of_area: Cycles) -> tuple[Measure, list[str]]:
    """How far two frequencies differ over the time that both have, and what that speaks against."""
    if not (cycles.count and of_area.count):
        return absent(name, cycles.note if not cycles.count else of_area.note), []
    both, half = (cycles.starts, of_area.starts), 0.5 / of_area.frequency  # cycles begin at other phases
    low, high = max(starts[0] for starts in both) - half, min(starts[-1] for starts in both) + half
    kept = [starts[(starts >= low) & (starts <= high)] for starts in both]
    if min(starts.size for starts in kept) < 4:
        return absent(name, f"the {called} and the glottal area share fewer than three cycles"), []
    periods = [np.diff(starts) for starts in kept]
    frequencies = [1 / float(part.mean()) for part in periods]
    halves = []
    for part in periods:
        resampled = of_ratio(np.ones(part.size), part)
        halves.append(0.5 * float(np.ptp(resampled.interval)) if resampled else 0.0)
    apart = frequencies[0] / frequencies[1] - 1
    doubt = float(np.linalg.norm(halves)) / frequencies[1]
    note = f"{frequencies[0]:.5g} against {frequencies[1]:.5g} Hz; chance explains {100 * doubt:.2g} %"
    if abs(apart) <= max(_AGREES, doubt):
        return whole(name, apart, note), []
    said = (
        f"the {called} has {frequencies[0]:.4g} Hz, the glottal area {frequencies[1]:.4g} Hz over the same "
        f"time, {100 * abs(apart):.2g} % {'less' if apart > 0 else 'more'}: the frame rate may be wrong, or "
        "the start of the signal"
    )
    return whole(name, apart, note, [said]), [said]


def closing_instants(time: Floats, area: Floats, cycles: Cycles) -> Floats:
    """(c) instants (s) at which the glottal area closes (see the module docstring); NaN where it does not."""
    found = []
    for (start, end), part in zip(pairwise(cycles.starts.tolist()), cycles.samples(time), strict=True):
        least, largest = float(area[part].min()), float(area[part].max())
        level = closed_share
        if least > level * largest:
            level = (least + leak_level * (largest - least)) / largest
        peak = float(time[part.start + int(np.argmax(area[part]))])
        after = [begin for begin, _ in closed_intervals(time, area, start, end, level) if begin > peak]
        found.append(after[0] if after else float("nan"))
    return np.array(found)


def _lag(
    contact: Contact, time: Floats, area: Floats, of_area: Cycles, fps: float
) -> tuple[Measure, list[str]]:
    """How far the closing peaks are behind the closing of the area."""
    name, peaks = "egg_closing_lag", contact.cycles.starts
    if not (contact.cycles.count and of_area.count):
        return absent(name, contact.cycles.note if not contact.cycles.count else of_area.note), []
    closing = of_area.used(closing_instants(time, area, of_area))
    inside = (closing >= peaks[0] - 0.5 / of_area.frequency) & (
        closing <= peaks[-1] + 0.5 / of_area.frequency
    )
    closing, period = closing[inside], 1 / of_area.frequency
    if closing.size < 3:
        return absent(name, "the electroglottogram and the glottal area share fewer than three cycles"), []
    nearest = peaks[np.argmin(np.abs(peaks - closing[:, None]), axis=1)]
    angles = 2 * np.pi * (nearest - closing) / period
    mean, _ = circular_mean(angles)
    if not np.isfinite(mean):
        return absent(name, "closing peaks follow the closing of the area by no one lag: clocks differ"), []
    lags = period / (2 * np.pi) * (mean + (angles - mean + np.pi) % (2 * np.pi) - np.pi)
    found = average(name, lags)
    value, spread = float(found.value or 0.0), float(found.spread or 0.0)
    note = (
        f"{value * fps:.2f} frames, scatter {spread * fps:.2f}; known up to whole periods of "
        f"{1e3 * period:.3g} ms"
    )
    doubts = []
    if abs(value) > _APART * period + 1 / fps:
        doubts.append(
            f"the electroglottogram's closing peaks are {1e3 * abs(value):.3g} ms ({abs(value) * fps:.1f} "
            f"frames) {'behind' if value > 0 else 'before'} the closing of the glottal area: the start of "
            "the signal may be wrong by that and any number of periods (--sound-start)"
        )
    if spread > _SCATTERED * period + 1 / fps:
        doubts.append(
            f"the electroglottogram's closing peaks scatter by {1e3 * spread:.3g} ms about the closing of "
            "the glottal area: the clocks of camera and signal may differ"
        )
    return replace(found, note=note, cautions=tuple(doubts)), doubts
