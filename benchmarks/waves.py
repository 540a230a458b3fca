"""Speed of a wave and strain found in films of known waves, by wavelength and by frames a cycle.

    python benchmarks/waves.py
    python benchmarks/waves.py --preset fast

Films of textured tissue in which a wave of known length runs outward (`plica.video.synthetic_wave`): 96 x 112
px, 1.5 px at most, less where a shorter wave would fold the tissue, noise of 2 grey levels, three cycles. The
flow of every pair is found, and from it what `plica video` says. "True motion": the same from the exact flow.
"""

from __future__ import annotations

import argparse
from itertools import pairwise

import numpy as np

from plica.measures.cycles import Cycles
from plica.video.flow import PRESETS, flow
from plica.video.synthetic_wave import SyntheticWave
from plica.video.waves import fundamental, wave_numbers

LENGTHS = (80.0, 40.0, 24.0, 16.0, 10.0, 6.0)  # px
PERIODS = (3.0, 4.0, 6.0, 8.0, 12.0, 24.0)  # frames
CYCLES = 3
STEEPEST = 0.7  # px per px


def film(wavelength: float, period: float) -> SyntheticWave:
    most = STEEPEST / (2 * np.pi / wavelength + 1 / 40 + 1 / 4)
    return SyntheticWave(wavelength=wavelength, period=period, amplitude=min(1.5, most), seed=5)


def found(wave: SyntheticWave, preset: str | None) -> tuple[float, float, int]:
    """Speed over the true one, 95th percentile of the strain amplitude across, and bands; of both sides."""
    count = int(CYCLES * wave.period) + 2
    if preset is None:
        flows = [wave.flow(float(t)) for t in range(count - 1)]
    else:
        pairs = pairwise(wave.frames(count))
        flows = [flow(*pair, preset=preset, intensity=(0.0, 255.0)).flow for pair in pairs]
    cycles = Cycles(wave.period * np.arange(CYCLES + 1.0), recorded=True)
    known = fundamental(
        flows, cycles, np.arange(float(count)), np.ones(flows[0].shape[:2], bool), wave.midline
    )
    if known is None:
        return float("nan"), float("nan"), 0
    numbers = np.concatenate([wave_numbers(known.displacement, wave.midline, side) for side in (-1, 1)])
    strain = float(np.percentile(np.abs(known.strain[8:-8, 8:-8, 0]), 95))
    return (wave.wave_number / numbers.mean() if numbers.size else float("nan")), strain, numbers.size


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--preset", choices=tuple(PRESETS), default="video")
    options = parser.parse_args()
    print(
        "| wavelength (px) | frames a cycle | speed over the true one: true motion | flow | strain, 95th",
        end="",
    )
    print(" percentile: true motion (%) | flow (%) | bands of 12 |\n" + "|---" * 7 + "|")
    for wavelength, period in [(one, 12.0) for one in LENGTHS] + [(40.0, one) for one in PERIODS]:
        wave = film(wavelength, period)
        exact, seen = found(wave, None), found(wave, options.preset)
        print(
            f"| {wavelength:g} | {period:g} | {exact[0]:.2f} | {seen[0]:.2f} | {100 * exact[1]:.1f} | "
            f"{100 * seen[1]:.1f} | {seen[2]} |",
            flush=True,
        )


if __name__ == "__main__":
    main()
