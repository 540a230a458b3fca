"""Measures of the glottal area and flow waveforms."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from plica.measures.cycles import Cycles
from plica.measures.measure import Measure, absent, average, per_cycle, whole
from plica.measures.pulses import autocorrelation_frequency
from plica.measures.record import Array, Floats, time_step

open_level = 0.01  # of the cycle's largest area: below it the glottis counts as closed
growth_note = "relative change of the peak-to-peak amplitude from cycle to cycle; 0 once settled"
open_note = "open: glottal area above 1 % of the cycle's maximum and the flow not stopped by contact"


def open_area(waveforms: Mapping[str, Array]) -> Floats:
    """Glottal area (k) m^2: the smallest section area, zero where negative or where contact stops flow."""
    area = np.maximum(np.asarray(waveforms["minimum_area"], dtype=float), 0.0)
    return np.where(np.asarray(waveforms["flow_stopped"]) != 0, 0.0, area)


def frequency_measures(time: Floats, signal: Floats, cycles: Cycles) -> dict[str, Measure]:
    """Fundamental frequency, period, growth, and the frequency once more by autocorrelation."""
    if not cycles.count:
        return {
            "fundamental_frequency": absent("Hz", cycles.note),
            "period": absent("s", cycles.note),
            "amplitude_growth": absent("1", cycles.note),
            "fundamental_frequency_autocorrelation": absent("Hz", cycles.note),
        }
    part = cycles.extent(time)
    step = time_step(time)
    other = autocorrelation_frequency(signal[part], step)
    note = cycles.note
    if not abs(other * float(cycles.periods.mean()) - 1.0) < 0.02:
        apart = f"the autocorrelation gives {other:.4g} Hz: the cycles are not all alike"
        note = "; ".join(text for text in (note, apart) if text)
    return {
        "fundamental_frequency": per_cycle(cycles, 1.0 / cycles.periods, "Hz", note),
        "period": per_cycle(cycles, cycles.periods, "s"),
        "amplitude_growth": Measure(_growth(time, signal, cycles), "1", None, cycles.count, growth_note),
        "fundamental_frequency_autocorrelation": whole(other, "Hz", "first high peak of the autocorrelation"),
    }


def flow_measures(time: Floats, waveforms: Mapping[str, Array], cycles: Cycles) -> dict[str, Measure]:
    """Peak, mean and least flow; largest and mean glottal area.

    Without cycles these are taken over the last third of the record, and the note says so.
    """
    flow, area = np.asarray(waveforms["flow"], dtype=float), open_area(waveforms)
    parts = cycles.samples(time) if cycles.count else [cycles.extent(time)]
    table = (
        ("peak_flow", flow, np.max, "m^3/s"),
        ("mean_flow", flow, np.mean, "m^3/s"),
        ("minimum_flow", flow, np.min, "m^3/s"),
        ("glottal_area_max", area, np.max, "m^2"),
        ("glottal_area_mean", area, np.mean, "m^2"),
    )
    found = {}
    for name, signal, function, unit in table:
        values = np.array([function(signal[part]) for part in parts])
        if cycles.count:
            found[name] = average(values, unit)
        else:
            found[name] = whole(values[0], unit, f"over the last third of the record; {cycles.note}")
    return found


def quotient_measures(time: Floats, waveforms: Mapping[str, Array], cycles: Cycles) -> dict[str, Measure]:
    """Open quotient (open time / period), speed quotient (opening / closing time), closing quotient."""
    notes = {
        "open_quotient": open_note,
        "speed_quotient": "opening over closing time; without closure from the least to the largest area",
        "closing_quotient": "closing time over period",
    }
    if not cycles.count:
        return {name: absent("1", cycles.note) for name in notes}
    area = open_area(waveforms)
    parts = enumerate(cycles.samples(time))
    values = np.array([_quotients(time, area, cycles.starts[i : i + 2], part) for i, part in parts])
    return {name: per_cycle(cycles, values[:, i], "1", note) for i, (name, note) in enumerate(notes.items())}


def _growth(time: Floats, signal: Floats, cycles: Cycles) -> float:
    amplitudes = np.array([np.ptp(signal[part]) for part in cycles.samples(time)])
    if amplitudes.size < 2:
        return float("nan")
    slope = np.polyfit(np.arange(amplitudes.size), amplitudes, 1)[0]
    return float(slope / amplitudes.mean())


def _quotients(time: Floats, area: Floats, ends: Floats, part: slice) -> tuple[float, float, float]:
    """Open, speed and closing quotient of the cycle between two instants."""
    period = float(ends[1] - ends[0])
    peak = part.start + int(np.argmax(area[part]))
    level = open_level * area[peak]
    closed = area <= level
    first, last = max(part.start - 1, 0), min(part.stop + 1, time.size)
    instants, open_time = _open_time(time[first:last], area[first:last], level)
    open_quotient = float(np.diff(np.interp(ends, instants, open_time))[0]) / period
    top = _vertex(time, area, peak)
    reach = round(period / time_step(time))
    before, after = slice(max(peak - reach, 0), peak), slice(peak + 1, min(peak + 1 + reach, time.size))
    if closed[before].any():
        k = before.start + int(np.flatnonzero(closed[before])[-1])
        opens = _edge(time, area, k, k + 1, level)
    else:
        opens = float(time[before.start + int(np.argmin(area[before]))]) if peak else float("nan")
    if closed[after].any():
        k = after.start + int(np.flatnonzero(closed[after])[0])
        closes = _edge(time, area, k, k - 1, level)
    else:
        closes = float(time[after.start + int(np.argmin(area[after]))]) if area[after].size else float("nan")
    return open_quotient, (top - opens) / (closes - top), (closes - top) / period


def _open_time(time: Floats, area: Floats, level: float) -> tuple[Floats, Floats]:
    """Cumulative open time at the samples (s); a step from or to a closed sample counts by its crossing."""
    steps = np.diff(time)
    low, high = np.minimum(area[:-1], area[1:]), np.maximum(area[:-1], area[1:])
    mixed = (low <= level) & (high > level)
    part = np.where(low > level, 1.0, 0.0)
    # A jump to exactly zero is contact that stopped the flow somewhere within the step: half of it.
    part[mixed] = np.where(low[mixed] == 0.0, 0.5, (high[mixed] - level) / (high[mixed] - low[mixed]))
    return time, np.concatenate(([0.0], np.cumsum(part * steps)))


def _edge(time: Floats, area: Floats, closed: int, opened: int, level: float) -> float:
    """Instant between a closed and a neighbouring open sample at which the area passes the level."""
    part = 0.5 if area[closed] == 0.0 else (level - area[closed]) / (area[opened] - area[closed])
    return float(time[closed] + part * (time[opened] - time[closed]))


def _vertex(time: Floats, area: Floats, peak: int) -> float:
    """Instant of the maximum, by a parabola through three samples."""
    if peak == 0 or peak == time.size - 1:
        return float(time[peak])
    before, at, after = area[peak - 1 : peak + 2]
    curvature = before - 2 * at + after
    shift = 0.5 * (before - after) / curvature if curvature < 0 else 0.0
    return float(time[peak] + shift * (time[peak + 1] - time[peak]))
