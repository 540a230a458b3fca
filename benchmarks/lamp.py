"""Left against right under lamps that stand to one side, and whether the area's band holds the truth.

Films runs that have stored fields under four lights, finds the glottis in each film, and gives a row a film:

    plica run scene.toml -o runs/one && python benchmarks/lamp.py runs/one --mm-per-px 0.08

Truth: the glottis of the film about the larynx's own plane. "Halfway": by the outline halfway from the dark
to the tissue; "found": what `plica video` says, its interval in brackets, bold where that does not hold the
truth. "Told": the caution on left and right; that on the area. "Frames in the band": in which the true area
lies between the outlines.
"""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from record import record

import plica
from plica import video
from plica.film import Clip
from plica.measures.sides import side_measures
from plica.video.midline import Midline
from plica.video.waveforms import GlottalArea, areas

LAMPS = {
    "right": {"light": (0.25, -0.1, 1.0), "ambient": 0.25},
    "left": {"light": (-0.12, 0.0, 1.0)},
    "above": {"light": (0.0, 0.0, 1.0), "brightness": 180.0},
    "diffuse": {"light": (0.3, 0.0, 1.0), "ambient": 0.7},
}
COMPARED = ("amplitude_ratio", "left_right_phase")


def row(clip: Clip, name: str) -> list[str]:
    """What is found in one film, beside its truth about the larynx's own plane."""
    with tempfile.TemporaryDirectory() as directory:
        path = clip.write(Path(directory) / "clip.npy")[0]
        settings = video.Settings(fps=clip.fps, correct_drift=False)
        found = video.analyse(path, Path(directory) / "a", settings, until="glottis", progress=False)
        waves, measured, half = found.waveforms, found.measures, found.area
    truth = true_area(clip, found.midline)
    of_truth, halfway = (
        {item.name: item.value for item in side_measures(found.time, *edges, found.cycles)}
        for edges in ((truth.left_edge, truth.right_edge), (half.left_edge, half.right_edge))
    )
    held = np.mean((waves["area_least"] <= truth.total) & (truth.total <= waves["area_largest"]))
    cells = [name]
    for what in COMPARED:
        turn = np.degrees(1) if what == "left_right_phase" else 1.0
        item = measured[what]
        low, high = item.interval
        cells += [f"{turn * of_truth[what]:.3g}", f"{turn * halfway[what]:.3g}"]
        outside = "" if low <= of_truth[what] <= high else "**"
        cells.append(f"{outside}{turn * item.value:.3g} ({turn * low:.3g} to {turn * high:.3g}){outside}")
    warned = any("light from one side" in said for said in measured["amplitude_ratio"].cautions)
    wide = any("outline is not sharp" in said for said in measured["glottal_area_mean"].cautions)
    cells += ["yes" if warned else "no", "yes" if wide else "no"]
    cells += [f"{100 * (found.area.total.mean() / truth.total.mean() - 1):+.0f} %"]
    return [*cells, f"{100 * held:.0f} %"]


def true_area(clip: Clip, line: Midline) -> GlottalArea:
    """About the larynx's own plane, as far along it as the midline found."""
    height, width = clip.camera.shape
    plane = Midline(((width - 1) / 2, 0.0), ((width - 1) / 2, height - 1.0))
    ends = (plane.points(plane.place(np.array(end)) * [1, 0]) for end in (line.upper, line.lower))
    middle = Midline.between([float(part) for end in ends for part in end])
    return areas((clip.glottis(k) for k in range(clip.count)), middle)


def films(given: argparse.Namespace) -> Iterator[list[str]]:
    size = given.mm_per_px
    camera = plica.Camera(mm_per_px=size, width=round(9 / size), height=round(15.2 / size), tilt=given.tilt)
    for run in given.runs:
        for lamp in given.lamps:
            film = plica.film(plica.Run.load(run), camera, end=given.end, samples=2, **LAMPS[lamp])
            yield row(film, f"{run.name}, {lamp}")


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    options.add_argument("runs", nargs="+", type=Path, help="directories of runs with stored fields")
    options.add_argument("--mm-per-px", type=float, default=0.08)
    options.add_argument("--tilt", type=float, default=4.0, help="degrees")
    options.add_argument("--lamps", nargs="+", choices=LAMPS, default=list(LAMPS))
    options.add_argument("--end", help="of the films, as 36 ms")
    options.add_argument("--record", default="video_lamp", help="name of the table")
    given = options.parse_args()
    columns = ["folds, lamp"]
    for what in ("amplitude ratio", "phase (deg)"):
        columns += [f"{what}: true", "halfway", "found"]
    columns += ["told: sides", "area", "mean area", "frames in the band"]
    record(given.record, columns, films(given))


if __name__ == "__main__":
    main()
