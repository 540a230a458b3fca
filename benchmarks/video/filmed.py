"""What `plica video` finds in a run that was filmed, beside the run and the film's truth.

    python -m benchmarks.video.filmed -o runs/filmed

The voice of examples/first.toml in the coarse larynx, to 44 ms, computed as far as DIR does not hold it;
filmed from 20 ms on, 4000 frames a second, 128 x 192 px of 0.08 mm, in the light of a lamp to one side (as
plica film sets it) and in diffuse light; each film taken through `plica video --no-drift`. Area and open
quotient are held against those of the film's own glottis. Flow: pixels seen again in the next frame, of all
pairs. Motion at the fundamental: root mean square of its complex amplitude, and of the error against that of
the true flow, at the pixels that count in the modes and whose true flow is known in all pairs; gauge of 8 px.
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
from plica.video.analysis import Analysis
from plica.video.glottis.glottal_area import areas
from plica.video.measures.waveforms import measures
from plica.video.motion.mucosal_wave import fundamental

ROOT = Path(__file__).resolve().parents[2]
VOICE = {
    "mesh.larynx": "coarse",
    "time.duration": "44 ms",
    "output": {"every": "0.25 ms", "start": "20 ms"},
}
CAMERA = plica.Camera(mm_per_px=0.08, width=128, height=192)
LIGHTS = {"lamp to one side": {}, "diffuse light": {"ambient": 0.8}}
FAST = 0.5  # px from frame to frame
STRAINS = ("across the midline", "along it", "shear")


def compared(clip: Clip, found: Analysis, run: plica.Run) -> Iterator[tuple[str, str, str]]:
    """Quantity, truth, what is found in one film."""
    glottis = [clip.glottis(k) for k in range(clip.count)]
    true, _ = measures(areas(glottis, found.midline), clip.fps)
    values, size = found.measures, CAMERA.mm_per_px
    pitch = run.measures["fundamental_frequency"].value
    yield "fundamental frequency (Hz)", f"{pitch:.1f}", f"{values['fundamental_frequency'].value:.1f}"
    area = size**2 * np.mean([mask.sum() for mask in glottis])
    yield "mean glottal area (mm²)", f"{area:.2f}", f"{size**2 * found.area.total.mean():.2f}"
    quotients = (f"{table['open_quotient'].value:.3f}" for table in (true, values))
    yield "open quotient", *quotients
    masks = [(found.mask(k), one) for k, one in enumerate(glottis)]
    alike = [2 * (a & b).sum() / (a.sum() + b.sum()) for a, b in masks if (a | b).any()]
    yield "masks, Dice's coefficient, median frame", "1", f"{np.median(alike):.2f}"
    yield from of_flow(clip, found)
    yield from of_fundamental(clip, found)


def of_flow(clip: Clip, found: Analysis) -> Iterator[tuple[str, str, str]]:
    way, off = [], []
    for k in range(clip.count - 1):
        truth, visible = clip.flow(k)
        way.append(np.hypot(*truth[visible].T))
        off.append(np.hypot(*(found.flow(k) - truth)[visible].T))
    moved, missed = np.concatenate(way), np.concatenate(off)
    fast = moved > FAST
    yield (
        f"flow, pixels that move by over {FAST:g} px: median (px)",
        f"{np.median(moved[fast]):.2f}",
        f"off by {np.median(missed[fast]):.3f}",
    )
    root = (np.sqrt(np.mean(values**2)) for values in (moved, missed))
    yield "flow, all pixels: root mean square (px)", f"{next(root):.2f}", f"off by {next(root):.2f}"


def of_fundamental(clip: Clip, found: Analysis) -> Iterator[tuple[str, str, str]]:
    """Displacement and strain at the voice's fundamental."""
    flows = [clip.flow(k)[0] for k in range(clip.count - 1)]
    known = (found["modes/used"] > 0) & np.isfinite(flows).all(axis=(0, 3))
    time = np.arange(float(clip.count))
    sides = (
        fundamental(given, found.cycles_in_frames, time, known, found.midline)
        for given in (flows, [found.flow(k) for k in range(clip.count - 1)])
    )
    truth, seen = sides
    assert truth is not None
    assert seen is not None
    fields = [("displacement, root mean square (px)", truth.displacement, seen.displacement)]
    for k, name in enumerate(STRAINS):
        fields.append((f"strain, {name}, root mean square", truth.strain[..., k], seen.strain[..., k]))
    for name, one, other in fields:
        inside = np.isfinite(one) & np.isfinite(other)
        one, other = one[inside], other[inside]
        root = (np.sqrt(np.mean(np.abs(values) ** 2)) for values in (one, other - one))
        alike = np.corrcoef(np.abs(one).ravel(), np.abs(other).ravel())[0, 1]
        yield name, f"{next(root):.3f}", f"off by {next(root):.3f}; correlation of the maps {alike:.2f}"


def filmed(run: plica.Run, light: dict[str, float]) -> list[tuple[str, str, str]]:
    clip = plica.film(run, CAMERA, **light)
    with tempfile.TemporaryDirectory() as directory:
        path = plica.write_film(clip, Path(directory) / "clip.npy")[0]
        settings = video.Settings(fps=clip.fps, correct_drift=False)
        return list(compared(clip, video.analyse(path, Path(directory) / "a", settings, progress=False), run))


def main() -> None:
    parser = script_parser(__doc__)
    parser.add_argument("-o", "--output", metavar="DIR", type=Path, required=True, help="of the run")
    options = parser.parse_args()
    scene = plica.Scene.load(ROOT / "examples" / "first.toml").replace(VOICE)
    run = plica.run(scene, of_this_engine(options.output) / "run", resume="if_there")
    found = [filmed(run, light) for light in LIGHTS.values()]
    rows = ([*rows[0], *(cells for *_, cells in rows[1:])] for rows in zip(*found, strict=True))
    record("film_video", ["", "run or film", *LIGHTS], rows)


if __name__ == "__main__":
    main()
