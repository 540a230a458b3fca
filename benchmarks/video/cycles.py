"""Shadows beside the glottis, and irregular voices, against the synthetic glottis whose every cycle is known.

    python -m benchmarks.video.cycles

Shadows: 160 x 160 px, 130 frames, 21 a cycle; crease and shadow as in plica.synthetic.glottis. Irregular
voices: 128 x 96 px, 40 cycles of 20.3 frames whose periods and amplitudes scatter, one whose every second
amplitude is less, one without a rhythm; "voice" is what it is said to be, "settled" how many cycles the rule
for simulations (plica.measures.cycles) would use. Jitter and shimmer are local; the true ones are those of
the planted periods and of the exact largest areas.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from benchmarks.harness.study import record, script_parser
from plica.measures.cycles import Cycles, find_cycles
from plica.synthetic.glottis import Synthetic, SyntheticGlottis
from plica.video.analysis import analyse
from plica.video.glottis.glottal_area import GlottalArea
from plica.video.measures.waveforms import measures
from plica.video.settings import Settings

SHADED = Synthetic(height=160, width=160, frames=130, frequency=0.0473)
SHADOWS = {
    "none": {},
    "crease of 4 px": {"crease": 4.0},
    "crease of 8 px": {"crease": 8.0},
    "shadow of 0.3 of the light": {"shadow": 0.3},
    "the same, moving by 0.05 px a frame": {"shadow": 0.3, "shadow_speed": 0.05},
    "shadow as dark as the glottis": {"shadow": 0.08},
    "the same, moving by 0.05 px a frame ": {"shadow": 0.08, "shadow_speed": 0.05},
    "gap that never closes, crease of 4 px": {"opening": (11.0, 11.0), "crease": 4.0},
}
IRREGULAR = Synthetic(
    height=128, width=96, frames=810, frequency=1 / 20.3, amplitude=(7, 7), opening=(2, 2), highlights=2
)
VOICES = {
    "0, 0": {},
    "1, 2": {"jitter": 0.01, "shimmer": 0.02},
    "3, 5": {"jitter": 0.03, "shimmer": 0.05},
    "5, 5": {"jitter": 0.05, "shimmer": 0.05},
    "0, every second amplitude less by 25": {"alternation": 0.25},
    "25, 30": {"jitter": 0.25, "shimmer": 0.3},
}


def local(values: np.ndarray) -> float:
    return float(100 * np.abs(np.diff(values)).mean() / values.mean())


def shadows(folder: Path) -> Iterator[list[str]]:
    for name, change in SHADOWS.items():
        glottis = SyntheticGlottis(replace(SHADED, **change))
        np.save(folder / "shaded.npy", glottis.stack())
        where = folder / str(len(list(folder.iterdir())))
        found = analyse(folder / "shaded.npy", where, Settings(), until="glottis", progress=False)
        truth = np.array([glottis.area(t) for t in range(SHADED.frames)]).T
        true, _ = measures(GlottalArea(*truth, *truth / 50))
        area = 100 * (found.area.total.mean() / truth.sum(axis=0).mean() - 1)
        opened = [f"{table['open_quotient'].value:.3f}" for table in (found.measures, true)]
        yield [name, f"{area:+.1f}", *opened, "; ".join(found.doubts)]


def irregular(folder: Path) -> Iterator[list[str]]:
    for name, change in VOICES.items():
        glottis = SyntheticGlottis(replace(IRREGULAR, **change))
        np.save(folder / "voice.npy", glottis.stack())
        settings, where = Settings(correct_drift=False), folder / f"voice {name}"
        found = analyse(folder / "voice.npy", where, settings, until="glottis", progress=False)
        values, cycles = found.measures, found.cycles_in_frames
        settled = find_cycles(np.arange(float(found.count)), found.area.total).count
        cells = [name, cycles.verdict, f"{cycles.count}, {values['cycles_used'].value:g}", f"{settled}"]
        regular = cycles.verdict == "regular"  # else the cycles found need not be those planted
        true = [f"{local(series):.2f}" for series in planted(glottis, cycles)] if regular else ["", ""]
        for measure, exact in zip(("jitter", "shimmer"), true, strict=True):
            item = values[measure]
            low, high = item.interval or (np.nan, np.nan)
            value = np.nan if item.value is None else item.value
            cells += [f"{100 * value:.2f}, {100 * low:.2f} to {100 * high:.2f}", exact]
        yield cells


def planted(glottis: SyntheticGlottis, cycles: Cycles) -> tuple[np.ndarray, np.ndarray]:
    """(c) periods and largest areas of the planted cycles that begin nearest to those found."""
    first = int(np.argmin(np.abs(glottis.begins - cycles.starts[0])))
    begins = glottis.begins[first : first + cycles.count + 1]
    periods = np.diff(begins)
    tops = [
        max(sum(glottis.area(t)) for t in begin + period * np.linspace(0.15, 0.35, 9))
        for begin, period in zip(begins, periods, strict=False)
    ]
    return periods, np.array(tops)


def main() -> None:
    script_parser(__doc__).parse_args()
    with tempfile.TemporaryDirectory() as name:
        columns = ["shadow", "mean area (%)", "open quotient", "true", "doubts"]
        record("video_shadows", columns, shadows(Path(name)))
        columns = ["planted jitter, shimmer (%)", "voice", "cycles found, used", "settled"]
        columns += ["jitter (%), interval", "true", "shimmer (%), interval", "true"]
        record("video_irregular", columns, irregular(Path(name)))


if __name__ == "__main__":
    main()
