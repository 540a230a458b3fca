"""Shadows beside the glottis, and irregular voices, against the synthetic glottis whose every cycle is known.

    python benchmarks/cycles.py

Shadows: 160 x 160 px, 130 frames, 21 a cycle; crease and shadow as in plica.video.synthetic. Irregular
voices: 128 x 96 px, 60 cycles of 20.3 frames whose periods and amplitudes scatter; "settled" is how many of
them the rule for simulations (plica.measures.cycles) would use. Jitter and shimmer are local; the true ones
are those of the planted periods and of the exact largest areas.
"""

from __future__ import annotations

import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np

from plica.measures.cycles import find_cycles
from plica.video.analysis import analyse
from plica.video.glottis import masks
from plica.video.midline import find_midline
from plica.video.recording import Recording
from plica.video.settings import Settings
from plica.video.synthetic import Synthetic, SyntheticGlottis
from plica.video.waveforms import GlottalArea, areas, measures

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
    height=128, width=96, frames=1210, frequency=1 / 20.3, amplitude=(7, 7), opening=(2, 2), highlights=2
)
VOICES = ((0, 0), (0.005, 0.01), (0.01, 0.02), (0.03, 0.05), (0.05, 0.05))


def local(values: np.ndarray) -> float:
    return float(100 * np.abs(np.diff(values)).mean() / values.mean())


def shadows(folder: Path) -> None:
    print("| shadow | mean area (%) | open quotient | true | doubts |\n|---|---|---|---|---|")
    for name, change in SHADOWS.items():
        glottis = SyntheticGlottis(replace(SHADED, **change))
        np.save(folder / "shaded.npy", glottis.stack())
        where = folder / str(len(list(folder.iterdir())))
        found = analyse(folder / "shaded.npy", where, Settings(), until="glottis", progress=False)
        truth = np.array([glottis.area(t) for t in range(SHADED.frames)]).T
        true, _ = measures(GlottalArea(*truth, *truth / 50))
        area = 100 * (found.area.total.mean() / truth.sum(axis=0).mean() - 1)
        opened = [table["open_quotient"].value for table in (found.measures, true)]
        said = "; ".join(found.doubts)
        print(f"| {name.strip()} | {area:+.1f} | {opened[0]:.3f} | {opened[1]:.3f} | {said} |", flush=True)


def irregular(folder: Path) -> None:
    print(
        "\n| planted jitter, shimmer (%) | cycles found, used | settled | jitter (%), interval | true "
        "| shimmer (%), interval | true |\n|---|---|---|---|---|---|---|"
    )
    for jitter, shimmer in VOICES:
        glottis = SyntheticGlottis(replace(IRREGULAR, jitter=jitter, shimmer=shimmer))
        np.save(folder / "voice.npy", glottis.stack())
        found = list(masks(Recording.open(folder / "voice.npy")))
        area = areas(found, find_midline(found))
        told, cycles = measures(area)
        begins, count = glottis.begins, cycles.count
        first = int(np.argmin(np.abs(begins - cycles.starts[0])))
        periods = np.diff(begins[first : first + count + 1])
        tops = np.array(
            [
                max(sum(glottis.area(t)) for t in begin + period * np.linspace(0.15, 0.35, 9))
                for begin, period in zip(begins[first : first + count], periods, strict=True)
            ]
        )
        settled = find_cycles(np.arange(float(area.total.size)), area.total).count
        cells = []
        for name, true in (("jitter", periods), ("shimmer", tops)):
            item = told[name]
            low, high = item.interval
            cells.append(f"{100 * item.value:.2f}, {100 * low:.2f} to {100 * high:.2f} | {local(true):.2f}")
        used = told["cycles_used"].value
        print(
            f"| {100 * jitter:g}, {100 * shimmer:g} | {count}, {used:g} | {settled} | {' | '.join(cells)} |",
            flush=True,
        )


def main() -> None:
    with tempfile.TemporaryDirectory() as name:
        shadows(Path(name))
        irregular(Path(name))


if __name__ == "__main__":
    main()
