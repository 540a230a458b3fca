"""A synthetic recording, whose motion is known, analysed: python recording.py [DIR] [FRAMES]

Writes DIR/glottis.tif (default: runs/recording) and beside it what `plica video glottis.tif --fps 4000
--mm-per-px 0.05 -o DIR` would: open report.html.
"""

from __future__ import annotations

import sys
from pathlib import Path

import tifffile

from plica import synthetic, video
from plica.video.report.page import write_report

FPS, MM_PER_PX = 4000, 0.05


def main(directory: Path, frames: int) -> None:
    glottis = synthetic.SyntheticGlottis(
        synthetic.Synthetic(
            height=160, width=160, frames=frames, frequency=0.0473, amplitude=(7, 5), phase=(0.0, 0.6)
        )
    )
    directory.mkdir(parents=True, exist_ok=True)
    recording = directory / "glottis.tif"
    tifffile.imwrite(recording, glottis.stack())

    found = video.analyse(recording, directory, video.Settings(fps=FPS, mm_per_px=MM_PER_PX))
    video.write_tables(found)
    page = write_report(found)

    measured = range(frames)[found.cycles.extent(found.time)]
    areas = [(1e-3 * MM_PER_PX) ** 2 * sum(glottis.area(t)) for t in measured]
    true = {
        "fundamental_frequency": FPS * glottis.options.frequency,
        "left_right_phase": glottis.options.phase[0] - glottis.options.phase[1],
        "glottal_area_mean": sum(areas) / len(areas),
    }
    for name, value in true.items():
        measure = found.measures[name]
        if measure.value is None:  # of fewer than three cycles, for example
            print(f"{name:22s} not found: {measure.note}")
        else:
            print(f"{name:22s} found {measure.value:8.4g} {measure.unit:5s} true {value:8.4g}")
    print(f"report: {page}")


if __name__ == "__main__":
    main(
        Path(sys.argv[1] if len(sys.argv) > 1 else "runs/recording"),
        int(sys.argv[2]) if len(sys.argv) > 2 else 120,
    )
