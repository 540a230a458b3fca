"""Left against right under lamps that stand to one side, and whether the area's band holds the truth.

    python -m benchmarks.video.lamp -o runs/lamp

Runs two voices of the coarse larynx that DIR does not hold yet, goes on with those that were stopped, films
them under four lights, finds the glottis in each film, and gives a row a film. Both have 1.2 kPa; the folds
are alike, or the right cover is half as stiff along the fibre. A film has the 65 frames from 20 to 36 ms.

Truth: the glottis of the film about the larynx's own plane. "Halfway": by the outline halfway from the dark
to the tissue; "found": what `plica video` says, its interval in brackets, bold where that does not hold the
truth. "Told": the caution on left and right; that on the area. "Frames in the band": in which the true area
lies between the outlines.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np

import plica
from benchmarks.harness.study import of_this_engine, record, script_parser
from plica import video
from plica.films import Clip
from plica.measures.glottal import area_measures, quotient_measures
from plica.measures.sides import side_measures
from plica.video.glottis.glottal_area import GlottalArea, areas
from plica.video.glottis.midline import Midline

ROOT = Path(__file__).resolve().parents[2]
VOICE = {
    "mesh.larynx": "coarse",
    "symmetry": None,
    "airflow.subglottal_pressure": "1.2 kPa",
    "time.duration": "36 ms",
    "output": {"every": "0.25 ms", "start": "20 ms"},
}
FOLDS = {"alike": {}, "unlike": {"tissue.cover.right": plica.TissueSide(E_fibre="5 kPa")}}
CAMERA = plica.Camera(mm_per_px=0.08, width=112, height=190, tilt=4.0)
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
        path = plica.write_film(clip, Path(directory) / "clip.npy")[0]
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
        text = f"{turn * item.value:.3g} ({turn * low:.3g} to {turn * high:.3g})"
        cells.append(_outside(low <= of_truth[what] <= high, text))
    warned = any("light from one side" in caution for caution in measured["amplitude_ratio"].cautions)
    wide = any("outline is not sharp" in caution for caution in measured["glottal_area_mean"].cautions)
    cells += ["yes" if warned else "no", "yes" if wide else "no"]
    of_truth = {
        item.name: item.value
        for item in (
            *area_measures(found.time, truth.total, found.cycles),
            *quotient_measures(found.time, truth.total, found.cycles),
        )
    }
    area, quotient = measured["glottal_area_mean"], measured["open_quotient"]
    value, low, high = (100 * (part / of_truth[area.name] - 1) for part in (area.value, *area.interval))
    cells.append(_outside(low <= 0 <= high, f"{value:+.0f} % ({low:+.0f} to {high:+.0f} %)"))
    low, high = quotient.interval
    true = of_truth[quotient.name]
    cells += [f"{true:.3f}", _outside(low <= true <= high, f"{quotient.value:.3f} ({low:.3f} to {high:.3f})")]
    return [*cells, f"{100 * held:.0f} %"]


def _outside(held: bool, text: str) -> str:
    return text if held else f"**{text}**"


def true_area(clip: Clip, line: Midline) -> GlottalArea:
    """About the larynx's own plane, as far along it as the midline found."""
    height, width = clip.camera.shape
    plane = Midline(((width - 1) / 2, 0.0), ((width - 1) / 2, height - 1.0))
    ends = (plane.points(plane.place(np.array(end)) * [1, 0]) for end in (line.upper, line.lower))
    middle = Midline.between([float(part) for end in ends for part in end])
    return areas((clip.glottis(k) for k in range(clip.count)), middle)


def voice(folds: str, directory: Path) -> plica.Run:
    """The run of these folds, computed as far as it is not there."""
    scene = plica.Scene.load(ROOT / "examples" / "first.toml").replace(VOICE).replace(FOLDS[folds])
    return plica.run(scene, of_this_engine(directory) / folds, resume="if_there")


def films(directory: Path) -> Iterator[list[str]]:
    for folds in FOLDS:
        run = voice(folds, directory)
        for lamp, light in LAMPS.items():
            yield row(plica.film(run, CAMERA, samples=2, **light), f"{folds}, {lamp}")


def main() -> None:
    parser = script_parser(__doc__)
    parser.add_argument("-o", "--output", metavar="DIR", type=Path, required=True, help="of the runs")
    options = parser.parse_args()
    columns = ["folds, lamp"]
    for what in ("amplitude ratio", "phase (deg)"):
        columns += [f"{what}: true", "halfway", "found"]
    columns += ["told: sides", "area", "mean area: off by"]
    columns += ["open quotient: true", "found", "frames in the band"]
    record("video_lamp", columns, films(options.output))


if __name__ == "__main__":
    main()
