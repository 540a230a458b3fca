"""Speed of a wave and strain found in films of known waves, by wavelength and by frames a cycle.

    python -m benchmarks.video.waves

Films of textured tissue in which a wave of known length runs outward (`plica.synthetic.wave`): 96 x 112
px, 1.5 px at most, less where a shorter wave would fold the tissue, noise of 2 grey levels, three cycles. The
flow of every pair is found, and from it what `plica video` says ("said": with a caution), and in how many of
its intervals the true speed is. "Exact": the same of the exact flow.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

import numpy as np

from benchmarks.harness.study import record, script_parser
from plica.measures.cycles import Cycles
from plica.synthetic.wave import SyntheticWave
from plica.video.measures.wave_measures import wave_measures
from plica.video.motion.flow import flow
from plica.video.motion.mucosal_wave import fundamental

PRESETS = ("video", "fast")
LENGTHS = (80.0, 40.0, 24.0, 16.0, 12.0, 10.0, 6.0)  # px
PERIODS = (3.0, 4.0, 6.0, 8.0, 12.0, 24.0)  # frames
CYCLES = 3
STEEPEST = 0.7  # px per px


def film(wavelength: float, period: float) -> SyntheticWave:
    most = STEEPEST / (2 * np.pi / wavelength + 1 / 40 + 1 / 4)
    return SyntheticWave(wavelength=wavelength, period=period, amplitude=min(1.5, most), seed=5)


def found(wave: SyntheticWave, preset: str | None) -> tuple[str, str, str]:
    """Mean speed of both sides over the true one, as it would be said; intervals held; strain across (%)."""
    count = int(CYCLES * wave.period) + 2
    if preset is None:
        flows = [wave.flow(float(t)) for t in range(count - 1)]
    else:
        pairs = pairwise(wave.frames(count))
        flows = [flow(*pair, preset=preset, intensity=(0.0, 255.0)).flow for pair in pairs]
    tissue = np.ones((wave.height, wave.width), bool)
    cycles = Cycles(wave.period * np.arange(CYCLES + 1.0), recorded=True)
    known = fundamental(flows, cycles, np.arange(float(count)), tissue, wave.midline)
    assert known is not None
    measured = wave_measures(known, wave.midline, tissue, wave.period, 1.0, 1.0)
    there = [item for item in measured if item.name.startswith("mucosal") and item.value is not None]
    true = wave.wavelength / wave.period
    speed = f"{np.mean([item.value for item in there]) / true:.2f}" if there else "refused"
    if len(there) == 1:
        speed += " on one side, refused on the other"
    if there and measured[0].cautions:
        speed += ", said"
    held = sum(item.interval[0] <= true <= item.interval[1] for item in there)
    strain = np.percentile(np.abs(known.strain[8:-8, 8:-8, 0]), 95)
    return speed, f"{held} of {len(there)}" if there else "", f"{100 * strain:.1f}"


def rows() -> Iterator[list[str]]:
    for wavelength, period in [(one, 12.0) for one in LENGTHS] + [(40.0, one) for one in PERIODS]:
        wave = film(wavelength, period)
        exact, *seen = (found(wave, preset) for preset in (None, *PRESETS))
        cells = [f"{wavelength:g}", f"{period:g}", exact[0]]
        for speed, held, _ in seen:
            cells += [speed, held]
        yield [*cells, exact[2], *(strain for *_, strain in seen)]


def main() -> None:
    script_parser(__doc__).parse_args()
    columns = ["wavelength (px)", "frames a cycle", "speed over the true one: exact"]
    for preset in PRESETS:
        columns += [preset, "held"]
    columns += ["strain (%), 95th percentile: exact", *PRESETS]
    record("waves", columns, rows())


if __name__ == "__main__":
    main()
