"""The data of a run for its report: waveforms, cycles, measures, and the ranges to show."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from plica.measures.cycles import Cycles
from plica.measures.measure import Measure
from plica.measures.record import Array, Floats
from plica.measures.run.folds import glottal_canal, half_widths, midline, rest_width
from plica.measures.run.run_data import MeasuredRun, RunData, reached


@dataclass(frozen=True)
class Reading:
    """The data that figures and tables use."""

    run: RunData
    time: Floats
    waveforms: Mapping[str, Array]
    cycles: Cycles
    measures: Mapping[str, Measure]

    def wave(self, name: str) -> Floats:
        """A waveform as floating-point numbers."""
        return np.asarray(self.waveforms[name], dtype=float)

    def has(self, *names: str) -> bool:
        """Whether all these waveforms are there, with at least two steps."""
        return self.time.size > 1 and all(name in self.waveforms for name in names)

    @cached_property
    def coronal(self) -> tuple[Floats, Floats]:
        """Mid-coronal points (k, s, 2) m of both folds: from the midline, right > 0, and z."""
        right, left = half_widths(self.waveforms)
        return (
            np.stack((right, self.wave("coronal_right")[:, :, 2]), axis=2),
            np.stack((-left, self.wave("coronal_left")[:, :, 2]), axis=2),
        )

    def midline(self) -> tuple[float, float]:
        """x (m) of the midline, and 1 if x increases towards the right fold, else -1."""
        return midline(self.waveforms) if "coronal_right" in self.waveforms else (0.0, 1.0)

    def last_cycles(self, count: int) -> slice:
        """Samples of the last `count` steady cycles, or of a whole run without cycles."""
        if self.cycles.count:
            starts = self.cycles.starts[-min(count, self.cycles.count) - 1 :]
            first, last = np.searchsorted(self.time, (starts[0], starts[-1]))
            return slice(int(first), int(last) + 1)
        return slice(0, self.time.size)

    def canal(self) -> slice:
        """Sections of the glottal canal."""
        return glottal_canal(rest_width(self.run))

    def height_range(self) -> tuple[float, float]:
        """Range of heights (m) to show: the glottal canal with some of the airway below and above it."""
        height = np.asarray(self.run.section_height, dtype=float)
        canal = self.canal()
        low, high = float(height[canal.start]), float(height[canal.stop - 1])
        length = max(high - low, 0.1 * float(np.ptp(height)))
        return max(low - 0.6 * length, float(height[0])), min(high + 0.4 * length, float(height[-1]))


def read(run: MeasuredRun) -> Reading:
    """Read a run for the report."""
    time, waveforms = reached(run)
    return Reading(run, time, waveforms, run.cycles, run.measures)
