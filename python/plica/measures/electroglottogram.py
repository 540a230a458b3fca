"""Cycles of an electroglottogram, and for which share of them the folds are in contact.

The signal grows with contact; its drift, the mean over a period of its mean over a period, is taken off. Its
slope (dEGG) has a positive peak where the folds meet and a negative one where they part. The slope is that
of a cubic through the samples of a twelfth of the period (five or more), so that noise of 1 % makes no
peaks. A cycle goes from closing peak to closing peak; each is the largest slope within a quarter of a period
of the instant at which the signal rises (:mod:`plica.measures.recorded`), the opening peak the least slope
between two of them, both by a parabola through three samples.

Contact quotient, of a cycle of the period T from the closing peak at c:

    by peaks       (o - c) / T, o the opening peak (Henrich, d'Alessandro, Doval and Castellengo, J. Acoust.
                   Soc. Am. 115, 2004): not known where a peak is not single
    by 3/7         (f - c) / T, f where the signal falls through 3/7 of the way from the cycle's least to its
                   largest value (Howard, J. Voice 9, 1995)

A peak is not single where the cycle has another half as high, with a valley of a quarter of its height
between. (Henrich et al. find double peaks by correlation over four periods; this is of each cycle.)
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from plica.measures.cycles import Cycles
from plica.measures.instants import crossing, highest
from plica.measures.pulses import autocorrelation_frequency
from plica.measures.record import Floats, time_step
from plica.measures.recorded import recorded_cycles

__all__ = ["Contact", "contact_of"]

fall_level = 3 / 7  # of a cycle's range
_OF_PERIOD, _OTHERWISE = 1 / 12, 0.5e-3  # of the period, and s without cycles: samples that tell a slope
_FEWEST = 5  # samples of it
_REACH = 0.25  # of the period about a rise, in which its closing peak lies
_SECOND, _VALLEY = 0.5, 0.25  # of a peak's height


@dataclass(frozen=True)
class Contact:
    """The cycles of an electroglottogram.

    Attributes
    ----------
    cycles : Cycles
        From closing peak to closing peak.
    slope : (k) 1/s
        Of the signal.
    opening : (c) s
        The opening peak of each cycle.
    fall : (c) s
        Where the signal falls through 3/7; NaN where it does not.
    single_closing : (c + 1) bool
    single_opening : (c) bool
    """

    cycles: Cycles
    slope: Floats
    opening: Floats
    fall: Floats
    single_closing: np.ndarray[tuple[int], np.dtype[np.bool_]]
    single_opening: np.ndarray[tuple[int], np.dtype[np.bool_]]

    @property
    def by_peaks(self) -> Floats:
        """(c) contact quotient from peak to peak; NaN where one of the three is not single."""
        closing = self.single_closing
        single = self.single_opening & closing[:-1] & closing[1:]
        return np.where(single, (self.opening - self.cycles.starts[:-1]) / self.cycles.periods, np.nan)

    @property
    def by_level(self) -> Floats:
        """(c) contact quotient from the closing peak to the fall through 3/7."""
        return np.asarray((self.fall - self.cycles.starts[:-1]) / self.cycles.periods)

    @property
    def skewness(self) -> float:
        """Of the slope over the cycles: > 0 where folds meet faster than they part; NaN without cycles."""
        from scipy import stats

        return float(stats.skew(self.slope)) if self.cycles.count else float("nan")


def contact_of(time: Floats, signal: Floats) -> Contact:
    """Cycles and instants of contact of an electroglottogram (see the module docstring).

    Parameters
    ----------
    time : (k) s, ascending, equidistant
    signal : (k), finite
        Larger with more contact, in any unit.

    Returns
    -------
    Contact
        Of at least three cycles, or of none; then the note of its cycles has the reason.
    """
    signal = _without_drift(time, signal)
    cycles = recorded_cycles(time, signal, name="electroglottogram")
    width = _OF_PERIOD * float(np.median(cycles.periods)) if cycles.count else _OTHERWISE
    slope = _slope(signal, time_step(time), width)
    none = np.zeros(0, dtype=bool)
    if not cycles.count:
        return Contact(cycles, slope, np.zeros(0), np.zeros(0), none, none)
    half = _REACH * np.append(cycles.periods, cycles.periods[-1])
    closing = [
        _peak(time, slope, start - way, start + way) for start, way in zip(cycles.starts, half, strict=True)
    ]
    starts = np.array([instant for instant, _ in closing])
    if not (np.diff(starts) > 0).all():
        said = "the peaks of its slope are in no order of cycles: too much noise for its rises"
        return Contact(
            Cycles(np.empty(0), said, "none", recorded=True), slope, np.zeros(0), np.zeros(0), none, none
        )
    cycles = replace(cycles, starts=starts)
    opening = [_peak(time, -slope, *ends) for ends in pairwise(starts.tolist())]
    return Contact(
        cycles,
        slope,
        np.array([instant for instant, _ in opening]),
        np.array([_fall(time, signal, part) for part in cycles.samples(time)]),
        np.array([single for _, single in closing]),
        np.array([single for _, single in opening]),
    )


def _without_drift(time: Floats, signal: Floats) -> Floats:
    """The signal less the mean, over a period, of its mean over a period: constant for a periodic signal.

    (Of the first mean alone a whole number of samples would leave a ripple of a sample over the period.)
    """
    from scipy import ndimage

    step = time_step(time)
    frequency = autocorrelation_frequency(_slope(signal, step, _OTHERWISE), step)
    reach = round(1 / (frequency * step)) if np.isfinite(frequency) else signal.size
    if 2 * reach >= signal.size - 1:
        return np.asarray(signal - signal.mean())
    drift = ndimage.uniform_filter1d(ndimage.uniform_filter1d(signal, reach), reach)
    drift[: reach + 1], drift[-reach - 1 :] = drift[reach + 1], drift[-reach - 2]
    return np.asarray(signal - drift)


def _slope(signal: Floats, step: float, width: float) -> Floats:
    """Slope (1/s) of a cubic through the samples of this width (s) about each."""
    from scipy import signal as filters

    samples = max(2 * int(width / step / 2) + 1, _FEWEST)
    if signal.size < samples:
        return np.gradient(signal, step) if signal.size > 1 else np.zeros(signal.size)
    return np.asarray(filters.savgol_filter(signal, samples, 3, deriv=1, delta=step))


def _peak(time: Floats, slope: Floats, low: float, high: float) -> tuple[float, bool]:
    """Instant (s) of the largest slope between two instants, and whether it is the only peak."""
    from scipy import signal as filters

    first, last = (int(k) for k in np.searchsorted(time, (low, high)))
    part = slope[first:last]
    if part.size < 3:
        return 0.5 * (low + high), False
    top = int(np.argmax(part))
    height = float(part[top])
    peaks, _ = filters.find_peaks(part, height=_SECOND * height, prominence=_VALLEY * height)
    return highest(time, slope, first + top)[0], height > 0 and peaks.tolist() == [top]


def _fall(time: Floats, signal: Floats, part: slice) -> float:
    """Instant (s) at which the signal first falls through 3/7 of its range after the cycle's largest."""
    values = signal[part]
    top, low = int(np.argmax(values)), float(values.min())
    level = low + fall_level * (float(values[top]) - low)
    below = np.flatnonzero(values[top:] < level)
    return crossing(time, signal, part.start + top + int(below[0]), level) if below.size else float("nan")
