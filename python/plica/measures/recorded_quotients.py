"""Measures of the glottal area that only recordings have: further quotients, levels, gaps."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from plica.measures.cycles import Cycles
from plica.measures.glottal import cycle_quotients, few_samples
from plica.measures.measure import Measure, per_cycle, per_period, whole
from plica.measures.quotients import Quotients, open_quotient
from plica.measures.record import Floats
from plica.measures.thresholds import open_levels


def count_measures(cycles: Cycles) -> list[Measure]:
    """Number of cycles, and number of cycles used for measures."""
    return [
        whole("cycles_found", cycles.count, cycles.note if not cycles.count else ""),
        whole("cycles_used", cycles.count - len(cycles.left_out), cycles.note),
    ]


def recorded_quotient_measures(
    time: Floats, area: Floats, cycles: Cycles, of_cycles: Sequence[Quotients] | None = None
) -> list[Measure]:
    """Closed and rate quotient, speed index, open quotients at the levels of the catalogue; from the
    quotients of each cycle where they are known."""
    found = cycle_quotients(time, area, cycles) if of_cycles is None else of_cycles
    closed = np.array([1.0 - one.open for one in found])
    speed = np.array([one.speed for one in found])
    rate = np.array([1.0 / one.closing - 1.0 if one.closing > 0 else np.nan for one in found])
    values = {
        "closed_quotient": closed,
        "speed_index": (speed - 1.0) / (speed + 1.0),
        "rate_quotient": rate,
    }
    for level in open_levels:
        values[f"open_quotient_{100 * level:g}_percent"] = np.array(
            [_open_above(time, area, *ends, level) for ends in pairwise(cycles.starts)]
        )
    cautions = few_samples(time, cycles)
    return [per_period(name, cycles, of_cycle, cautions=cautions) for name, of_cycle in values.items()]


def gap_measures(time: Floats, area: Floats, cycles: Cycles, length: float | None) -> list[Measure]:
    """Glottal gap index, and with the glottal length the relative gap."""
    parts = [area[part] for part in cycles.samples(time)]
    least = np.array([part.min() for part in parts])
    largest = np.array([part.max() for part in parts])
    found = [per_cycle("glottal_gap_index", cycles, least / np.where(largest > 0, largest, np.nan))]
    if length:
        found.append(per_cycle("glottal_gap_relative", cycles, least / length**2))
    return found


def _open_above(time: Floats, area: Floats, start: float, end: float, share: float) -> float:
    """The open quotient at a level given as a share of the range of the cycle's area."""
    first, last = (int(k) for k in np.searchsorted(time, (start, end)))
    low, high = float(area[first:last].min()), float(area[first:last].max())
    if not high > low:
        return float("nan")
    return open_quotient(time, area, start, end, (low + share * (high - low)) / high)
