"""The blur found at the edges of the glottis, and how far its area is off, in films of known blur.

    python -m benchmarks.video.edge_blur

Synthetic glottises that differ in size, voice and texture, taken through `plica video --no-drift` up to the
glottis. The first two, with the one of limits.py, chose the limit of the doubt; the others judge it. Blur
found has the width of a pixel in it (0.3 px, as variances). Mean area: found over true, less 1. Held: of the
intervals of mean area, amplitudes, frequency, phase and open quotient, how many hold the truth.
"""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from benchmarks.record import record
from benchmarks.video.limits import FPS, exactly
from plica.video.analysis import analyse
from plica.video.settings import Settings
from plica.video.synthetic import Synthetic, SyntheticGlottis

SMALL = {"height": 128, "width": 128, "highlights": 2, "frames": 90, "frequency": 0.0473}
CHOSE = {
    "chose: small": Synthetic(**SMALL, amplitude=(5, 5), opening=(2, 2)),
    "chose: smaller": Synthetic(**SMALL | {"height": 96, "width": 96}, amplitude=(4, 4), opening=(2, 2)),
}
JUDGE = {
    "judges: folds late": Synthetic(
        **SMALL | {"height": 144, "frequency": 0.06, "frames": 70},
        amplitude=(6, 8),
        opening=(3, 1),
        phase=(0, -0.5),
        lag=0.5,
        noise=3.0,
        seed=51,
    ),
    "judges: coarse texture": Synthetic(
        **SMALL | {"frequency": 0.0531, "frames": 80},
        amplitude=(8, 8),
        opening=(1, 1),
        texture=12.0,
        grain=4.0,
        noise=3.0,
        seed=52,
    ),
    "judges: wide": Synthetic(
        **SMALL | {"height": 192, "width": 192, "frequency": 0.05},
        amplitude=(16, 14),
        opening=(5, 5),
        noise=3.0,
        seed=53,
    ),
}
BLURS = {"chose": (0.0, 0.8, 1.2, 1.5, 2.5), "judges": (0.6, 0.9, 1.3, 1.8)}  # px


def row(name: str, options: Synthetic) -> list[str]:
    glottis = SyntheticGlottis(options)
    with tempfile.TemporaryDirectory() as folder:
        np.save(Path(folder) / "film.npy", glottis.stack())
        settings = Settings(fps=FPS, correct_drift=False)
        path = Path(folder) / "film.npy", Path(folder) / "found"
        found = analyse(*path, settings, until="glottis", progress=False)
        values, doubts, total = found.measures, found.doubts, found.area.total
        blur = float(found["sides/blur"])
    truth = np.array([glottis.area(t) for t in range(options.frames)])
    intervals = {key: (values[key].interval, value) for key, value in exactly(glottis, truth).items()}
    held = sum(ends is not None and ends[0] <= value <= ends[1] for ends, value in intervals.values())
    warned = any("edges of the glottis are blurred" in doubt for doubt in doubts)
    area = 100 * (total.mean() / truth.sum(axis=1).mean() - 1)
    cells = [name, f"{options.blur:g}", f"{blur:.2f}", f"{area:+.1f}", f"{held} of {len(intervals)}"]
    return [*cells, "yes" if warned else "no"]


def rows() -> Iterator[list[str]]:
    for name, options in (CHOSE | JUDGE).items():
        for blur in BLURS[name.split(":")[0]]:
            yield row(name, replace(options, blur=blur))


def main() -> None:
    argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    ).parse_args()
    columns = ["film", "blur (px)", "blur found (px)", "mean area (%)", "intervals held", "said"]
    record("video_blur", columns, rows())


if __name__ == "__main__":
    main()
