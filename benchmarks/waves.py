"""Speed of a wave and strain found in films of known waves, by wavelength and by frames a cycle.

    python benchmarks/waves.py

Films of textured tissue in which a wave of known length runs outward (`plica.video.synthetic_wave`): 96 x 112
px, 1.5 px at most, less where a shorter wave would fold the tissue, noise of 2 grey levels, three cycles. The
flow of every pair is found with two presets, and from it what `plica video` says ("said": with a caution).
"Exact": the same of the exact flow.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

import numpy as np
from record import record

from plica.measures.cycles import Cycles
from plica.video.flow import flow
from plica.video.synthetic_wave import SyntheticWave
from plica.video.wave_measures import wave_measures
from plica.video.waves import fundamental

LENGTHS = (80.0, 40.0, 24.0, 16.0, 12.0, 10.0, 6.0)  # px
PERIODS = (3.0, 4.0, 6.0, 8.0, 12.0, 24.0)  # frames
CYCLES = 3
STEEPEST = 0.7  # px per px
COLUMNS = (
    *("wavelength (px)", "frames a cycle", "speed over the true one: exact", "`video`", "`fast`"),
    *("strain, 95th percentile: exact (%)", "`video` (%)", "`fast` (%)"),
)


def film(wavelength: float, period: float) -> SyntheticWave:
    most = STEEPEST / (2 * np.pi / wavelength + 1 / 40 + 1 / 4)
    return SyntheticWave(wavelength=wavelength, period=period, amplitude=min(1.5, most), seed=5)


def found(wave: SyntheticWave, preset: str | None) -> tuple[str, str]:
    """Mean speed of both sides over the true one, as it would be said, and strain across (%)."""
    count = int(CYCLES * wave.period) + 2
    if preset is None:
        flows = [wave.flow(float(t)) for t in range(count - 1)]
    else:
        pairs = pairwise(wave.frames(count))
        flows = [flow(*pair, preset=preset, intensity=(0.0, 255.0)).flow for pair in pairs]
    tissue = np.ones((wave.height, wave.width), bool)
    cycles = Cycles(wave.period * np.arange(CYCLES + 1.0), recorded=True)
    known = fundamental(flows, cycles, np.arange(float(count)), tissue, wave.midline)
    if known is None:
        return "none", "none"
    measured = wave_measures(known, wave.midline, tissue, wave.period, 1.0, 1.0)
    speeds = [item.value for item in measured if item.name.startswith("mucosal_wave_speed")]
    there = [value for value in speeds if value is not None]
    speed = f"{np.mean(there) * wave.period / wave.wavelength:.2f}" if there else "refused"
    if len(there) == 1:
        speed += " on one side, refused on the other"
    if measured[0].cautions:
        speed += " (said)"
    return speed, f"{100 * np.percentile(np.abs(known.strain[8:-8, 8:-8, 0]), 95):.1f}"


def rows() -> Iterator[list[str]]:
    """A row for each wave."""
    for wavelength, period in [(one, 12.0) for one in LENGTHS] + [(40.0, one) for one in PERIODS]:
        wave = film(wavelength, period)
        speeds, strains = zip(*(found(wave, preset) for preset in (None, "video", "fast")), strict=True)
        yield [f"{wavelength:g}", f"{period:g}", *speeds, *strains]


if __name__ == "__main__":
    record("waves", COLUMNS, rows())
