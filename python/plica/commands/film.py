"""``plica film``: render a run as high-speed video."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

from plica.commands.arguments import add_command, add_threads, as_options, number_or_text, numbers, whole

__all__ = ["add_commands"]

_HELP = """\
Renders the run in DIR from above, like a camera on an endoscope: textured tissue lit by a lamp, specular
highlights, the dark glottis, noise. With the clip it writes the ground truth, the true motion of every pixel:

  clip.avi        8-bit grey, lossless; or clip.npy (frames, height, width)
  clip.truth.h5   flow (px from each frame to the next, right and down), visible (seen in the next frame too),
                  glottis, glottal_area, time, projection, and the fields of camera and film (HDF5)

or everything in one clip.h5, with the frames in the data set "frames". The run must have stored fields
(output.every in its scene). The frame rate is at most that of the stored fields; between stored fields, and
during an exposure, the motion is interpolated, which is refused if the interpolation error exceeds 0.25 px.
A film with fewer than three complete cycles is written with a caution.

The image shows x to the right and y upwards, z towards the camera: of a larynx with its right fold at larger
x the patient's right at the right and the front (anterior) at the top; --roll 180 turns it as most endoscopes
show it. docs/film.md describes the method;
plica.film, plica.Camera and plica.Film do the same in Python, with options for light, texture and noise.

examples:
  plica film runs/first -o clip.avi
  plica video clip.avi --fps 2000 --mm-per-px 0.06 -o analysis     printed by plica film at its end
  plica film runs/first -o clip.avi --from 20ms --tilt 5           camera inclined by 5 degrees towards +y
  plica film runs/first -o clip.h5 --size 320,256 --mm-per-px 0.05 --exposure 100us --noise 3
"""


def add_commands(commands: Any) -> None:
    """Add ``film`` to the commands of ``plica``."""
    film = add_command(
        commands, "film", _film, "render a run as high-speed video, with its true motion", _HELP
    )
    film.add_argument("directory", metavar="DIR", type=Path, help="of a run with fields")
    film.add_argument(
        "-o", "--output", metavar="FILE", type=Path, required=True, help="the clip: .avi, .npy, .h5 or .hdf5"
    )
    film.add_argument(
        "--fps", metavar="N", type=float, help="frames per second (default: as fields were stored)"
    )
    film.add_argument(
        "--from", dest="start", metavar="TIME", type=number_or_text, help='of the first frame, e.g. "20ms"'
    )
    film.add_argument(
        "--to", dest="end", metavar="TIME", type=number_or_text, help="no frame is later (default: the end)"
    )
    film.add_argument(
        "--exposure",
        metavar="TIME",
        type=number_or_text,
        default=0.0,
        help='e.g. "100us" (default: an instant)',
    )
    film.add_argument(
        "--mm-per-px", metavar="MM", type=float, default=0.06, help="size of a pixel (default: 0.06)"
    )
    film.add_argument(
        "--size", metavar="W,H", type=numbers(int, 2), default=(256, 256), help="px (default: 256,256)"
    )
    film.add_argument(
        "--centre",
        metavar="X,Y,Z",
        type=numbers(float, 3),
        default=(0.0, 0.0, 0.0),
        help="mm, the point at the centre of the image (default: 0,0,0)",
    )
    film.add_argument(
        "--tilt", metavar="DEG", type=float, default=0.0, help="inclination of the camera towards +y"
    )
    film.add_argument(
        "--lean", metavar="DEG", type=float, default=0.0, help="inclination of the camera towards +x"
    )
    film.add_argument(
        "--roll", metavar="DEG", type=float, default=0.0, help="rotation of the image, anticlockwise"
    )
    film.add_argument(
        "--samples", metavar="N", type=whole, default=4, help="images averaged for each frame (default: 4)"
    )
    film.add_argument(
        "--noise",
        metavar="GREY",
        type=float,
        help="standard deviation in grey levels, instead of the camera's noise",
    )
    film.add_argument(
        "--ambient",
        metavar="SHARE",
        type=float,
        default=0.35,
        help="share of ambient light, 0 to 1 (default: 0.35)",
    )
    film.add_argument("--seed", metavar="N", type=int, default=1, help="of texture and noise (default: 1)")
    add_threads(film)
    film.add_argument("--overwrite", action="store_true", help="replace an existing clip and its truth")
    film.add_argument("--quiet", action="store_true", help="print only errors and cautions")


_OPTIONS = {
    "start": "--from",
    "end": "--to",
    "width": "--size",
    "height": "--size",
    "read_noise": "--noise",
    "fields": "fields",  # that are stored, no option
}


def _film(options: argparse.Namespace) -> int:
    with as_options(("Film", "Camera"), _OPTIONS):
        return _filmed(options)


def _filmed(options: argparse.Namespace) -> int:
    import plica

    centre = tuple(1e-3 * value for value in options.centre)
    camera = plica.Camera(
        mm_per_px=options.mm_per_px,
        width=options.size[0],
        height=options.size[1],
        centre=(centre[0], centre[1], centre[2]),
        tilt=options.tilt,
        lean=options.lean,
        roll=options.roll,
    )
    noise = {} if options.noise is None else {"read_noise": options.noise, "photon_noise": 0.0}
    chosen = plica.Film(
        fps=options.fps,
        start=options.start,
        end=options.end,
        exposure=options.exposure,
        samples=options.samples,
        ambient=options.ambient,
        seed=options.seed,
        **noise,
    )
    plica.set_threads(options.threads)
    clip = plica.film(plica.Run.load(options.directory), camera, chosen)
    written = plica.write_film(clip, options.output, overwrite=options.overwrite, progress=not options.quiet)
    if not options.quiet:
        size = f"{clip.count} frames of {camera.width} x {camera.height} px, {clip.fps:.6g} per second"
        print(f"written: {', '.join(map(str, written))}: {size}")
        dataset = " --dataset frames" if len(written) == 1 else ""
        print(
            f"plica video {written[0]}{dataset} --fps {clip.fps:.6g} --mm-per-px {camera.mm_per_px:g} "
            "-o analysis"
        )
    if missing := _missing_cycles(written[-1]):
        more = " Five periods always contain three complete cycles: film more of the run, or run it longer."
        caution = f"plica: Caution: plica video will find no cycles in this film: {missing}."
        print(caution + ("" if missing.startswith("no oscillation") else more), file=sys.stderr)
    if cut := _cut_frames(written[-1]):
        print(
            f"plica: Caution: the border of the image cuts the glottis in {cut} of {clip.count} frames, so "
            "that plica video will measure only a part of it: use a larger --size or --mm-per-px.",
            file=sys.stderr,
        )
    return 0


def _missing_cycles(truth: Path) -> str:
    """Why the true glottal area of a film has no cycles by the rule for recordings; empty if it has."""
    from plica.measures.recorded import recorded_cycles
    from plica.storage.stored import Stored

    with Stored(truth) as file:
        cycles = recorded_cycles(file.read("time"), file.read("glottal_area"), name="glottal area")
    return "" if cycles.count else cycles.note


def _cut_frames(truth: Path) -> int:
    """Number of frames in which the true glottis of a film touches the border of the image."""
    from plica.storage.stored import Stored

    with Stored(truth) as file:
        glottis = file.rows("glottis")
        return sum(bool(k[[0, -1]].any() or k[:, [0, -1]].any()) for k in glottis)
