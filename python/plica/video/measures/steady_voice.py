"""Onset and offset of a voice that begins or ends within the recording, kept apart from the steady voice.

A voice begins within a recording where there is more than a period and a half without voice before its first
cycle, and ends within it likewise. Its first and last cycles are onset and offset as long as they are unlike
the others: with M the median over the middle half of all cycles, and s the standard deviation that their
median deviation has in a Gaussian, a cycle is like them whose period is within max(0.05 M, 3 s) of M, whose
range is within max(0.1 M, 3 s), and whose least area is within a tenth of the range's M, or 3 s, of its own.
At most a half is taken off, and three cycles are left.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from plica.measures.cycles import Cycles
from plica.measures.recorded import heights
from plica.measures.scale import Scale, shown_unit

__all__ = ["steady_voice"]

Floats = npt.NDArray[np.float64]

_SILENT = 1.5  # periods without voice, before or after it
_FEWEST = 6  # cycles; of fewer none is taken off
_LEFT = 3  # at least
_PERIOD, _RANGE, _LEAST = 0.05, 0.1, 0.1
_SCATTER = 3 * 1.4826  # median deviations


def steady_voice(cycles: Cycles, time: npt.NDArray[Any], area: Floats, scale: Scale) -> Cycles:
    """The cycles without those of onset and offset; the note says when the voice begins and ends."""
    if not cycles.count:
        return cycles
    period = float(np.median(cycles.periods))
    begins = cycles.starts[0] - float(time[0]) > _SILENT * period
    ends = float(time[-1]) - cycles.starts[-1] > _SILENT * period
    if not (begins or ends):
        return cycles
    alike = _alike(cycles, time, area) if cycles.count >= _FEWEST else np.ones(cycles.count, dtype=bool)
    most = min(cycles.count // 2, (cycles.count - _LEFT) // (begins + ends))
    first = min(int(np.argmax(alike)), most) if begins else 0
    last = min(int(np.argmax(alike[::-1])), most) if ends else 0
    factor, unit = shown_unit(scale.unit("s"))
    said = [
        f"the voice {how} at {factor * instant:.4g} {unit}" + (f", {_counted(count, what)}" if count else "")
        for there, how, instant, count, what in (
            (begins, "begins", cycles.starts[0], first, "onset"),
            (ends, "ends", cycles.starts[-1], last, "offset"),
        )
        if there
    ]
    kept = cycles.starts[first : cycles.starts.size - last]
    return replace(cycles, starts=kept, note="; ".join(filter(None, (cycles.note, *said))))


def _alike(cycles: Cycles, time: npt.NDArray[Any], area: Floats) -> npt.NDArray[np.bool_]:
    """(c) whether a cycle is like those of the middle half."""
    ranges = heights(time, area, cycles)
    least = np.array([float(area[part].min()) for part in cycles.samples(time)])
    quarter = cycles.count // 4
    middle = slice(quarter, cycles.count - quarter)
    usual = float(np.median(ranges[middle]))
    found = np.ones(cycles.count, dtype=bool)
    for values, allowed in (
        (cycles.periods, _PERIOD * float(np.median(cycles.periods[middle]))),
        (ranges, _RANGE * usual),
        (least, _LEAST * usual),
    ):
        off = np.abs(values - np.median(values[middle]))
        found &= off <= max(allowed, _SCATTER * float(np.median(off[middle])))
    return found


def _counted(count: int, what: str) -> str:
    return f"{count} {'cycle' if count == 1 else 'cycles'} of its {what} kept apart"
