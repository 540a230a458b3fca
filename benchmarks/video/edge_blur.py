"""Blur at the edges of the glottis, and what is measured in spite of it, in films of known blur.

    python -m benchmarks.video.edge_blur

Synthetic glottises that differ in size, voice, texture, and left from right, taken through `plica video
--no-drift` up to the glottis; each blur with little noise and with 10 grey levels. The first, with the one
of limits.py, chose the limit of the doubt and the intervals; the others judge them. Blur found has the width
of a pixel in it (0.3 px, as variances). Mean area, open quotient: found less true, the larger error of both.
Held: of the intervals of mean area, amplitudes, frequency, phase and open quotient, how many hold the truth;
half of their widths as in limits.py. Said: in how many films it is doubted that edges are sharp.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.harness.study import record, script_parser
from benchmarks.video.limits import COLUMNS, FPS, WIDTHS, against, exactly, widths
from plica.synthetic.glottis import Synthetic, SyntheticGlottis
from plica.video.analysis import analyse
from plica.video.settings import Settings

SMALL = {"height": 128, "width": 128, "highlights": 2, "frames": 90, "frequency": 0.0473}


def film(left: float, right: float, open_left: float, open_right: float, **others: Any) -> Synthetic:
    """By amplitudes and openings (px)."""
    return Synthetic(
        **SMALL | {"noise": 3.0} | others, amplitude=(left, right), opening=(open_left, open_right)
    )


CHOSE = {
    "chose: small": film(5, 5, 2, 2, noise=Synthetic.noise),
    "chose: smaller": film(4, 4, 2, 2, height=96, width=96, noise=Synthetic.noise),
    "chose: one side": film(3, 9, 1, 4, phase=(0, 0.8), seed=5),
    "chose: touching": film(6, 6, 5.8, 5.8, seed=6),
    "chose: narrow gap": film(5, 5, 5.5, 5.5, seed=7),
    "chose: one after the other": film(7, 7, 3, 3, lag=1.2, seed=9),
    "chose: closed for long": film(8, 8, -3, -3, seed=11),
}
JUDGE = {
    "judges: folds late": film(
        6, 8, 3, 1, height=144, frequency=0.06, frames=70, phase=(0, -0.5), lag=0.5, seed=51
    ),
    "judges: coarse texture": film(8, 8, 1, 1, frequency=0.0531, frames=80, texture=12.0, grain=4.0, seed=52),
    "judges: wide": film(16, 14, 5, 5, height=192, width=192, frequency=0.05, seed=53),
    "judges: unlike folds": film(
        4, 7, 2, 3, width=112, frequency=0.0571, phase=(0.4, 0), texture=18.0, grain=3.0, noise=4.0, seed=61
    ),
    "judges: open for long": film(7, 7, 6, 6, height=160, frequency=0.0455, noise=4.0, seed=62),
    "judges: open for short": film(
        7, 6, -1, -1.5, height=112, width=112, frequency=0.0513, noise=4.0, seed=63
    ),
    "judges: shimmer": film(
        7,
        7,
        2,
        2,
        height=144,
        width=120,
        frequency=0.0489,
        frames=110,
        shimmer=0.03,
        lag=-0.4,
        noise=4.0,
        seed=64,
    ),
}
BLURS = {"chose": (0.0, 0.8, 1.1, 1.5), "judges": (0.0, 0.5, 0.8, 1.1, 1.4, 1.8)}  # px
NOISY = 10.0  # grey levels
FAIR = 1.1  # px, up to which blur is not doubted


@dataclass
class Found:
    """In one film: the errors of limits.COLUMNS, how many intervals hold the truth, half of their widths,
    these over the errors, and the blur found; whether a caution says so."""

    error: np.ndarray
    held: int
    halves: np.ndarray
    ratios: np.ndarray
    blur: float
    warned: bool


def found_in(options: Synthetic) -> Found:
    glottis = SyntheticGlottis(options)
    with tempfile.TemporaryDirectory() as folder:
        np.save(Path(folder) / "film.npy", glottis.stack())
        settings = Settings(fps=FPS, correct_drift=False)
        path = Path(folder) / "film.npy", Path(folder) / "found"
        found = analyse(*path, settings, until="glottis", progress=False)
        values, doubts, blur = found.measures, found.doubts, float(found["sides/blur"])
    truth = np.array([glottis.area(t) for t in range(options.frames)])
    warned = any("edges of the glottis are blurred" in doubt for doubt in doubts)
    return Found(*against(values, exactly(glottis, truth)), blur, warned)


def row(name: str, films: list[Found], blur: float) -> list[str]:
    worst = max((one.error for one in films), key=lambda error: abs(error[0]))[0]
    quotient = max((one.error for one in films), key=lambda error: abs(error[-1]))[-1]
    cells = [name, f"{blur:g}", f"{np.mean([one.blur for one in films]):.2f}"]
    cells += [f"{worst:+.1f}", f"{quotient:+.3f}"]
    cells.append(f"{sum(one.held for one in films)} of {len(COLUMNS) * len(films)}")
    cells += widths([one.halves for one in films], [one.ratios for one in films])
    return [*cells, f"{sum(one.warned for one in films)} of {len(films)}"]


def rows() -> Iterator[list[str]]:
    kept: dict[str, list[Found]] = {}
    for name, options in (CHOSE | JUDGE).items():
        part = name.split(":")[0]
        for blur in BLURS[part]:
            films = [found_in(replace(options, blur=blur, noise=noise)) for noise in (options.noise, NOISY)]
            yield row(name, films, blur)
            if blur <= FAIR:
                kept.setdefault(part, []).extend(films)
    for part, films in kept.items():
        cells = row(f"{part}: all to {FAIR:g} px", films, 0.0)
        yield [cells[0], "", "", *cells[3:]]


def main() -> None:
    script_parser(__doc__).parse_args()
    columns = ["film", "blur (px)", "blur found (px)", "mean area (%)", "open quotient", "intervals held"]
    record("video_blur", [*columns, *WIDTHS, "said"], rows())


if __name__ == "__main__":
    main()
