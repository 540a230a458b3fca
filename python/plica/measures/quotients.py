"""Open, speed and closing quotient of one cycle of a simulated or recorded glottal area.

The glottis is open where its area is above a level, a given share of the cycle's largest area. Between two
samples the area is linear, with one exception: an area of exactly zero means contact, which ended the
opening somewhere within the step. The instant is that at which the line through the two open samples before
reaches the level, if that is within the step; else the area has jumped, and the middle of the step is used.

The speed quotient is opening time over closing time, the closing quotient closing time over the period; the
opening ends and the closing starts at the maximum of the pulse. They start and end at the crossing of the
level nearest to it on each side. If the area stays above the level on one side (incomplete closure), a level
that both sides cross is used: 10 % of the range from the larger of the minimum areas of the two sides to the
largest area. (The instant of the minimum itself is undefined in a flat closure.)
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from plica.measures.instants import crossing, summit
from plica.measures.record import Floats

leak_level = 0.10  # of the range of the area: level at which flanks end without closure


@dataclass(frozen=True)
class Quotients:
    """Quotients of one cycle; NaN if a flank is not in the record.

    Attributes
    ----------
    open : float
        Open time over period.
    speed : float
        Opening time over closing time.
    closing : float
        Closing time over period.
    """

    open: float
    speed: float
    closing: float


def quotients(time: Floats, area: Floats, start: float, end: float, level: float) -> Quotients:
    """The quotients of the cycle from `start` to `end` (see the module docstring).

    Parameters
    ----------
    time : (k) s, ascending, equidistant
    area : (k) >= 0, finite, in any unit
        0 where contact stopped the flow.
    start, end : float
        s, of the cycle, one pulse.
    level : float
        Share of the cycle's largest area, in [0, 1): above it the glottis is open.

    Returns
    -------
    Quotients
    """
    first, last = (int(k) for k in np.searchsorted(time, (start, end)))
    if last <= first or not area[first:last].max() > 0:
        return Quotients(0.0 if last > first else float("nan"), float("nan"), float("nan"))
    peak = first + int(np.argmax(area[first:last]))
    opened = open_quotient(time, area, start, end, level)
    if area[peak] < area[max(peak - 1, 0) : peak + 2].max():  # maximum at its end: not a pulse
        return Quotients(opened, float("nan"), float("nan"))
    opens, closes, floor = _flanks(time, area, peak, end - start, level)
    top = summit(time, area, peak, floor)
    if top <= opens or top >= closes:  # for flanks shorter than a step, use the largest sample
        top = float(time[peak])
    return Quotients(opened, float((top - opens) / (closes - top)), float((closes - top) / (end - start)))


def open_quotient(time: Floats, area: Floats, start: float, end: float, level: float) -> float:
    """Open time over period of the cycle from `start` to `end`; parameters as of :func:`quotients`."""
    first, last = np.searchsorted(time, (start, end))
    if last <= first:
        return float("nan")
    instants, state = _turns(time, area, start, end, level)
    total = sum(b - a for a, b in zip(instants[1 - state :: 2], instants[2 - state :: 2], strict=False))
    return float(total / (end - start))


def closed_intervals(
    time: Floats, area: Floats, start: float, end: float, level: float
) -> list[tuple[float, float]]:
    """Beginning and end (s) of each time at which the glottis is closed, those that the open quotient leaves
    out; parameters as of :func:`quotients`."""
    first, last = np.searchsorted(time, (start, end))
    if last <= first:
        return []
    instants, state = _turns(time, area, start, end, level)
    return [(a, b) for a, b in zip(instants[state::2], instants[state + 1 :: 2], strict=False) if b > a]


def _turns(time: Floats, area: Floats, start: float, end: float, level: float) -> tuple[list[float], bool]:
    """Start, instants at which the glottis opens or closes in turn, and end; whether it is open at first."""
    first, last = (int(k) for k in np.searchsorted(time, (start, end)))
    limit = level * float(area[first:last].max())
    before = max(first, 1) - 1
    opened = area[before : min(last, time.size - 1) + 1] > limit
    turns = [before + k for k in (np.flatnonzero(opened[1:] != opened[:-1]) + 1).tolist()]
    instants = [start, *(min(max(_edge(time, area, k, limit), start), end) for k in turns), end]
    # Open and closed intervals alternate; the state of the first is that of the sample before the first
    # change.
    return instants, bool(area[turns[0] - 1 if turns else first] > limit)


def _flanks(time: Floats, area: Floats, peak: int, period: float, level: float) -> tuple[float, float, float]:
    """Start of the opening, end of the closing, and the base area of the pulse."""
    reach = max(round(period / float(time[1] - time[0])), 1)
    before, after = area[max(peak - reach, 0) : peak], area[peak + 1 : peak + 1 + reach]
    if not (before.size and after.size):
        return float("nan"), float("nan"), 0.0
    largest, foot = float(area[peak]), max(float(before.min()), float(after.min()))
    limit, floor = level * largest, 0.0
    if foot > limit:
        floor = foot
        limit = floor + leak_level * (largest - floor)
        cut = peak - reach < 0 or peak + 1 + reach > area.size
        if cut and foot > min(before.min(), after.min()) + leak_level * (largest - foot):
            return float("nan"), float("nan"), floor  # the record has only a part of that flank
    opened = peak - int(np.argmax(before[::-1] <= limit))
    closed = peak + 1 + int(np.argmax(after <= limit))
    return _edge(time, area, opened, limit), _edge(time, area, closed, limit), floor


def _edge(time: Floats, area: Floats, k: int, level: float) -> float:
    """Instant between samples k - 1 and k, one open and one closed, at which the area crosses the level."""
    inward = -1 if area[k] <= level else 1  # from the closed sample to the open ones
    shut, opened = (k, k - 1) if inward < 0 else (k - 1, k)
    if area[shut] > 0.0:
        return crossing(time, area, k, level)
    part, further = 0.5, opened + inward  # of the step, from the open sample
    if 0 <= further < area.size and area[further] > area[opened]:
        down = float((area[opened] - level) / (area[further] - area[opened]))
        part = down if down <= 1.0 else 0.5
    return float(time[opened] + part * (time[shut] - time[opened]))
