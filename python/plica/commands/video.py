"""``plica video``, ``glottis``, ``modes`` and ``flow``: what is measured in pictures."""

from __future__ import annotations

import argparse
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from plica.commands.arguments import add_command, add_threads, numbers, whole
from plica.commands.table import measures_table

if TYPE_CHECKING:
    from plica.video.analysis import Analysis

__all__ = ["add_commands"]

_VIDEO_HELP = """\
Analyses a high-speed recording of the larynx: the endoscope's motion and the glottis, then the motion of the
tissue from frame to frame, its modes, and how far to trust all of it. Reads AVI, MP4, MOV, MKV, a TIFF stack,
a folder of images, HDF5 and NPY. Stores in DIR as it goes:

  results.h5     masks, flow, modes, paths, trust (HDF5)
  waveforms.csv  a row a frame: glottal area left and right, phase, flags, drift, mode coefficients
  measures.json  {name: {value, unit, spread, cycles}}
  report.html    pictures, waveforms, kymogram, modes, quality; a player

The frame rate that a file states is nearly always the speed of playing it, so it is not taken: give --fps, or
times are in frames and frequencies in cycles per frame. Without --mm-per-px lengths are in pixels. Left and
right are those of the image.

examples:
  plica video larynx.avi --fps 4000 --mm-per-px 0.05 -o analysis
  plica video larynx.avi --fps 4000 -o analysis        again after Ctrl-C: it goes on where it stopped
  plica video frames/ --region 40,60,200,240 --rotation -12 -o analysis
  plica video larynx.mp4 --preset fast --midline 120,40,118,210 -o quick
"""

_GLOTTIS_HELP = """\
The part of plica video that needs no flow: the endoscope's motion, the glottis in every frame, its area left
and right, a kymogram, measures. Writes results.h5, waveforms.csv and measures.json to DIR; plica video with
the same settings goes on from there.

examples:
  plica glottis larynx.avi --fps 4000 -o analysis
  plica video larynx.avi --fps 4000 -o analysis
"""

_MODES_HELP = """\
The principal modes of the tissue's motion: plica video without its report. Prints each mode's share of the
variance and its likeness to its mirror image, +1 where both folds move alike; results.h5 in DIR has the modes
and their coefficients.

examples:
  plica modes larynx.avi --fps 4000 --modes 8 -o analysis
"""

_FLOW_HELP = """\
Finds the motion of every pixel from picture A to picture B and says how far to trust it.

examples:
  plica flow frame10.png frame11.png -o ab.flo
  plica flow frame10.png frame11.png -o ab.flo --preset fast
  plica flow frame10.png frame11.png -o ab.flo --truth flow10.flo    the error against a known flow
  plica flow frame10.png frame11.png -o ab.flo --mask tissue.png     only where the mask is not black

ab.flo (Middlebury's format) holds u (to the right) and v (downwards) in pixels, for each pixel of A:
A(x, y) is seen again at B(x + u, y + v). What is printed:

  motion     length of the flow, median and largest
  residual   root mean square of B(x + u, y + v) - A(x, y), beside that without motion; grey levels
  mismatch   pixels missed by going from A to B and back again, median and 95th percentile: above 1 the flow
             is not to be trusted there (things hidden, highlights, no texture)
  error      with --truth: mean distance from the true flow

presets: robust (the default), video (lambda 0.5 instead of 0.045: smoother, for noisy recordings), reference
(Sun, Roth and Black, solved to rest), thesis (as reference, with lambda 0.5), fast (for a first look).
"""


def add_commands(commands: Any) -> None:
    """Add the four to the commands of ``plica``."""
    part = partial(add_command, commands)
    _add_recording(part("video", _video, "analyse a high-speed recording", _VIDEO_HELP))
    _add_recording(part("glottis", _glottis, "find the glottis in a high-speed recording", _GLOTTIS_HELP))
    _add_recording(part("modes", _modes, "find the modes of the tissue's motion in a recording", _MODES_HELP))
    flow = part("flow", _flow, "find the motion between two pictures", _FLOW_HELP)
    flow.add_argument("first", metavar="A", type=Path, help="picture (PNG, TIFF, JPEG, ...)")
    flow.add_argument("second", metavar="B", type=Path, help="the next one, of the same size")
    flow.add_argument(
        "-o", "--output", metavar="FILE", type=Path, required=True, help="the flow, e.g. ab.flo"
    )
    flow.add_argument(
        "--preset", metavar="NAME", default="robust", help="robust, video, reference, thesis or fast"
    )
    flow.add_argument("--truth", metavar="FILE", type=Path, help="true flow (.flo) to compare with")
    flow.add_argument(
        "--mask", metavar="FILE", type=Path, help="picture that is black where A and B are useless"
    )
    add_threads(flow)
    flow.add_argument("--quiet", action="store_true", help="print nothing; only what is wrong")


def _add_recording(video: argparse.ArgumentParser) -> None:
    video.add_argument("source", metavar="FILE", type=Path, help="video, TIFF stack, folder, HDF5 or NPY")
    video.add_argument(
        "-o", "--output", metavar="DIR", type=Path, required=True, help="directory of the results"
    )
    video.add_argument("--fps", metavar="N", type=float, help="true frames per second")
    video.add_argument("--mm-per-px", metavar="MM", type=float, help="size of a pixel")
    video.add_argument(
        "--rotation", metavar="DEG", type=float, default=0.0, help="turn frames, anticlockwise as seen"
    )
    video.add_argument(
        "--region", metavar="X,Y,W,H", type=numbers(int, 4), help="part of the turned frames, px"
    )
    video.add_argument(
        "--midline",
        metavar="X,Y,X,Y",
        type=numbers(float, 4),
        help="anterior and posterior end, px of the region (default: found, anterior end up)",
    )
    video.add_argument("--dataset", metavar="NAME", help="of an HDF5 file that holds several")
    video.add_argument(
        "--preset",
        metavar="NAME",
        default="video",
        help="of the flow: video, robust, reference, thesis or fast",
    )
    video.add_argument("--modes", metavar="N", type=whole, default=6, help="principal modes (default: 6)")
    video.add_argument("--no-drift", action="store_true", help="leave the endoscope's motion in")
    add_threads(video)
    video.add_argument("--quiet", action="store_true", help="no progress, no table; only what is wrong")


def _video(options: argparse.Namespace) -> int:
    from plica.phonation.storage import storage_errors
    from plica.video.report import write_report

    found = _analysed(options, "modes")
    with storage_errors(options.output):
        report = write_report(found, options.source)
    if not options.quiet:
        print(f"report: {report}")
    return 0


def _glottis(options: argparse.Namespace) -> int:
    _analysed(options, "glottis")
    return 0


def _modes(options: argparse.Namespace) -> int:
    import h5py

    found = _analysed(options, "modes")
    if not options.quiet:
        with h5py.File(found.file, "r") as file:
            rows = zip(file["modes/share"][:], file["modes/symmetry"][:], strict=True)
            print("mode   share  symmetry")
            for k, (share, symmetry) in enumerate(rows, start=1):
                print(f"{k:4d} {100 * share:6.2f} %  {symmetry:+8.3f}")
    return 0


def _analysed(options: argparse.Namespace, until: str) -> Analysis:
    """The analysis of a recording as far as `until`, its tables written and its measures printed."""
    import plica
    from plica.phonation.storage import storage_errors
    from plica.video.analysis import Settings, analyse, write_tables

    plica.set_threads(options.threads)
    settings = Settings(
        fps=options.fps,
        mm_per_px=options.mm_per_px,
        rotation=options.rotation,
        region=options.region,
        dataset=options.dataset,
        midline=options.midline,
        preset=options.preset,
        correct_drift=not options.no_drift,
        modes=options.modes,
    )
    with storage_errors(options.output):
        found = analyse(options.source, options.output, settings, until=until, progress=not options.quiet)
        write_tables(found)
    if not options.quiet:
        print(measures_table({name: item.as_json() for name, item in found.measures.items()}))
    return found


def _flow(options: argparse.Namespace) -> int:
    import plica
    from plica.video.flow_command import flow_of_files

    plica.set_threads(options.threads)
    said = flow_of_files(
        options.first,
        options.second,
        options.output,
        preset=options.preset,
        truth=options.truth,
        mask=options.mask,
    )
    if not options.quiet:
        print(said)
    return 0
