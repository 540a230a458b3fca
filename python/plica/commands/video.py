"""``plica video``, ``glottis``, ``modes`` and ``flow``: analysis of recordings and images."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from plica.commands.analysis_files import add_dicom, outdated, require_libraries, untaken, write_files
from plica.commands.arguments import add_command, add_pdf, add_threads, numbers, whole
from plica.commands.masks import add_masks
from plica.commands.output import measures_table
from plica.commands.recordings import analyse_each
from plica.commands.signals import add_signals, require_one_recording
from plica.errors import InvalidInput

if TYPE_CHECKING:
    from plica.video.analysis import Analysis

__all__ = ["add_commands", "is_analysis", "redraw", "remeasure"]

_VIDEO_HELP = """\
Analyses a high-speed recording of the larynx: the endoscope's motion and the glottis, then the motion of the
tissue from frame to frame, its modes, and the reliability of each. Reads a folder of images, HDF5, NPY; AVI,
MP4, MOV, MKV and a TIFF stack (pip install "plica[video]"), DICOM (pip install "plica[dicom]"), and camera
formats: Phantom .cine (pip install "plica[cine]"), Photron .mraw with its .cih or .cihx. Stores in DIR:

  results.h5     masks, flow, modes, paths, strain and waves at the voice's frequency, trust (HDF5)
  flow.h5        the motion from each frame to the next, and back
  waveforms.csv  one row per frame: glottal area left and right, phase, flags, drift, mode coefficients
  cycles.csv     one row per cycle: times, frequency, open quotient, area, amplitudes, phase
  folds.csv      one row per place along the midline: amplitude and phase of either fold, share of time open
  measures.csv   one row per measure: value, unit, 95 % interval, spread, cycles, note, cautions, light, why
  measures.json  {name: {value, unit, spread, cycles, definition}}
  light.json     the light, its reasons, and what was analysed; the tables have the light as a column
  report.html    images, waveforms, kymograms of images and flow, modes, strain, quality; a player
  report.pdf     with --pdf: the same on A4 (pip install 'plica[pdf]')
  report.dcm     with --dicom: the PDF in DICOM, in the recording's study (pip install 'plica[dicom,pdf]')
  recording.xlsx with --xlsx: light, measures and tables, a sheet each (pip install 'plica[xlsx]')
  recording.mat  with --matlab: the same as structs, and the settings (MATLAB 7.6 or later)

The frame rate stored in a video file is nearly always the playback rate, so it is not used: give --fps, or
times are in frames and frequencies in cycles per frame. .cine, .cih and DICOM (from 200 frames/s on) contain
the rate of the camera, which is used unless --fps is given. Without --mm-per-px lengths are in pixels and
relative to the glottal length. Left and right are those of the image; the patient's side and the anterior end
are never guessed: give --patient-left and --anterior. --label and --recorded set the name and date of the
recording in the report.
These six are stored with the results and may be given later, in the same directory; so may --midline,
--kymogram and --modes, which need little computation, and the signals beside the picture: --audio and --egg
(WAV) on the time of the frames, in the report, measures.csv and signals.csv; docs/recordings.md. To compare
two analyses, e.g. before and after a treatment: plica compare.

If an outline in the report is wrong, correct it: plica masks --page writes a page on which outlines, midline,
region and scale are corrected in a browser, and --corrections reads what it saves; plica masks -o writes
frames and their masks as pictures, and --masks reads those. The other frames are then segmented using them.
--segmenter uses your own network (ONNX; pip install "plica[onnx]"), whose outlines are used unchanged except
in frames with hand-drawn masks; docs/recording_files.md describes its input and output.

Several recordings are analysed one after the other with the same options, each in a folder of its name in
DIR; DIR/recordings.csv has a row for each: its light and why, every measure with its interval, or the error
(with --xlsx recordings.xlsx too).
Repeat the command to continue; what is done is not done again.

Measures need three complete cycles. All frames must have the same size and depth (8 or 16 bits, or floats).
In HDF5 and NPY frames are (frames, height, width); MATLAB .mat files since version 7.3 are read with the
axes of MATLAB: give an HDF5 file written by MATLAB the suffix .mat too.

Presets of the flow: video (default, for recordings), gradient (for sharp ones), robust, fast (a preview),
reference, thesis; see plica flow --help. --lambda-report adds the smoothness lambda according to three
criteria that need no ground truth (discrepancy, L-curve, cross-validation): lambda.json, and as text. It
computes about 90 additional flows and changes nothing else: docs/verification/recorded_flow.md shows the
accuracy of each criterion.

examples:
  plica video larynx.avi --fps 4000 --mm-per-px 0.05 -o analysis
  plica video larynx.avi --fps 4000 -o analysis        after Ctrl-C: continues where it stopped
  plica video larynx.avi --from 1200 --to 2399 -o vowel      a part; frames and times count from its first
  plica video day/*.avi --fps 4000 -o day                    day/NAME/ for each, and one table of all
  plica video frames/ --region 40,60,200,240 --rotation -12 -o analysis
  plica video larynx.avi --fps 4000 -o before --label "patient 12, before" --recorded 2026-03-01 --pdf
  plica video larynx.avi --fps 4000 --audio voice.wav:1 --egg voice.wav:2 --sound-start 0.35 -o analysis
  plica video larynx.cine --segmenter glottis.onnx -o analysis
  plica video larynx.mp4 --preset fast --midline 120,40,118,210 -o quick
  plica masks analysis --page correct.html
  plica video larynx.avi --fps 4000 -o analysis --corrections corrections.json
  plica masks analysis --frames 57,120 -o drawn && gimp drawn/mask_00057.png ...
  plica video larynx.avi --fps 4000 -o analysis --masks drawn
"""

_GLOTTIS_HELP = """\
The part of plica video without flow: the endoscope's motion, the glottis in every frame, its area left and
right, kymograms, measures. Writes results.h5, all tables of plica video and report.html to DIR; plica video
with the same settings continues from there.

examples:
  plica glottis larynx.avi --fps 4000 -o analysis
  plica video larynx.avi --fps 4000 -o analysis
"""

_MODES_HELP = """\
The principal modes of the tissue's motion: plica video without its report. Prints each mode's share of the
variance and its symmetry, +1 if both folds move alike; results.h5 in DIR has the modes and their
coefficients.

examples:
  plica modes larynx.avi --fps 4000 --modes 8 -o analysis
"""

_FLOW_HELP = """\
Computes the motion of every pixel from image A to image B and its reliability.

examples:
  plica flow frame10.png frame11.png -o ab.flo
  plica flow frame10.png frame11.png -o ab.flo --preset fast
  plica flow frame10.png frame11.png -o ab.flo --truth flow10.flo    the error against a known flow
  plica flow frame10.png frame11.png -o ab.flo --mask tissue.png     only where the mask is not black

ab.flo (Middlebury format) holds u (to the right) and v (downwards) in pixels, for each pixel of A: A(x, y)
is seen at B(x + u, y + v). A and B are single images of the same size and depth (8 or 16 bits, or floats).
Printed values, with a caution if most pixels have a forward-backward error above one pixel:

  motion     length of the flow, median and largest
  residual   root mean square of B(x + u, y + v) - A(x, y), and that without motion; grey levels
  mismatch   forward-backward error from A to B and back (px), median and 95th percentile: above 1 the flow is
             not reliable there (occlusion, highlights, no texture)
  error      with --truth: mean distance from the true flow

presets: robust (default), gradient (for sharp images: assumes constant gradient instead of constant
brightness; less error in smooth motion, more at its edges), video (as gradient, less sensitive to noise: for
recordings of the larynx, the default of plica video), reference (Sun, Roth and Black, fully converged),
thesis (as reference, with lambda 0.5), fast (a preview).
"""


def add_commands(commands: Any) -> None:
    """Add the five commands to ``plica``."""
    part = partial(add_command, commands)
    for name, command, summary, text in (
        ("video", _video, "analyse a high-speed recording", _VIDEO_HELP),
        ("glottis", _glottis, "find the glottis in a high-speed recording", _GLOTTIS_HELP),
    ):
        with_page = part(name, command, summary, text)
        _add_recording(with_page)
        add_pdf(with_page)
        add_dicom(with_page)
        if name == "video":
            with_page.add_argument(
                "--lambda-report",
                action="store_true",
                help="also compute the flow's lambda by three criteria (lambda.json); not used otherwise",
            )
    _add_recording(part("modes", _modes, "find the modes of the tissue's motion in a recording", _MODES_HELP))
    add_masks(commands)
    flow = part("flow", _flow, "compute the motion between two images", _FLOW_HELP)
    flow.add_argument("first", metavar="A", type=Path, help="image (PNG, TIFF, JPEG, ...)")
    flow.add_argument("second", metavar="B", type=Path, help="the next image, of the same size")
    flow.add_argument(
        "-o", "--output", metavar="FILE", type=Path, required=True, help="the flow, e.g. ab.flo"
    )
    flow.add_argument(
        "--preset",
        metavar="NAME",
        default="robust",
        help="robust, gradient, video, reference, thesis or fast",
    )
    flow.add_argument("--truth", metavar="FILE", type=Path, help="true flow (.flo) to compare with")
    flow.add_argument(
        "--mask", metavar="FILE", type=Path, help="image that is black where A and B are not usable"
    )
    add_threads(flow)
    flow.add_argument("--quiet", action="store_true", help="print only errors and cautions")


def _add_recording(video: argparse.ArgumentParser) -> None:
    video.add_argument(
        "source",
        metavar="FILE",
        type=Path,
        nargs="+",
        help="video, TIFF stack, folder, HDF5, NPY or DICOM; several are analysed one after the other",
    )
    video.add_argument(
        "--table",
        action="store_true",
        help="also for one recording: its results in a folder of their own, and DIR/recordings.csv",
    )
    video.add_argument(
        "-o", "--output", metavar="DIR", type=Path, required=True, help="directory of the results"
    )
    video.add_argument("--fps", metavar="N", type=float, help="frames per second of the recording")
    video.add_argument("--mm-per-px", metavar="MM", type=float, help="size of a pixel")
    video.add_argument("--from", dest="first", metavar="FRAME", type=int, help="first frame (default: 0)")
    video.add_argument(
        "--to", dest="last", metavar="FRAME", type=whole, help="last frame (default: the last)"
    )
    video.add_argument(
        "--rotation", metavar="DEG", type=float, default=0.0, help="rotation of the frames, anticlockwise"
    )
    video.add_argument(
        "--region", metavar="X,Y,W,H", type=numbers(int, 4), help="part of the rotated frames, px"
    )
    video.add_argument(
        "--midline",
        metavar="X,Y,X,Y",
        type=numbers(float, 4),
        help="its ends, px of the region (default: detected)",
    )
    video.add_argument("--anterior", metavar="END", help="anterior end of the midline: upper or lower")
    video.add_argument(
        "--patient-left",
        metavar="SIDE",
        help="side of the image with the patient's left fold: left or right; sides stay those of the image, "
        "and notes and reports say whose they are",
    )
    video.add_argument(
        "--kymogram",
        metavar="P,P,...",
        type=numbers(float),
        help="positions along the midline, 0 at its upper end, 1 at its lower (default: 0.25,0.5,0.75)",
    )
    video.add_argument("--label", metavar="TEXT", help='name of the recording: "patient 12, before"')
    video.add_argument(
        "--recorded", metavar="DATE", help="date of the recording, 2026-03-01 (default: from its file)"
    )
    add_signals(video)
    drawn = video.add_mutually_exclusive_group()
    drawn.add_argument(
        "--masks", metavar="FOLDER", type=Path, help="hand-drawn masks (plica masks), added to earlier ones"
    )
    drawn.add_argument(
        "--corrections", metavar="FILE", type=Path, help="corrections.json of the page of plica masks --page"
    )
    drawn.add_argument("--no-masks", action="store_true", help="remove all hand-drawn masks")
    video.add_argument(
        "--segmenter",
        metavar="MODEL",
        help="an ONNX model that segments the glottis (default: built-in method)",
    )
    video.add_argument("--dataset", metavar="NAME", help="data set of an HDF5 file that holds several")
    video.add_argument(
        "--preset",
        metavar="NAME",
        default="video",
        help="preset of the flow: video, robust, gradient, reference, thesis or fast",
    )
    video.add_argument(
        "--modes", metavar="N", type=whole, help="principal modes (default: 6), fewer than the flows"
    )
    video.add_argument("--no-drift", action="store_true", help="do not remove the endoscope's motion")
    video.add_argument(
        "--praat", action="store_true", help="also area.wav and area.TextGrid, cycles and phases, for Praat"
    )
    video.add_argument(
        "--xlsx", action="store_true", help="also recording.xlsx, all tables (pip install 'plica[xlsx]')"
    )
    video.add_argument("--matlab", action="store_true", help="also recording.mat, all tables as structs")
    add_threads(video)
    video.add_argument("--quiet", action="store_true", help="no progress, no table; only errors and cautions")
    video.set_defaults(resumable=True)


def is_analysis(directory: Path) -> bool:
    """Whether a directory holds an analysis of a recording, not a run."""
    from plica.storage.stored import Stored

    path = directory / "results.h5"
    if not path.is_file():
        return False
    with Stored(path) as file:
        return file.attribute("/", "recording") is not None


def redraw(directory: Path) -> Path:
    """``plica report`` for an analysis: write the page."""
    from plica.storage.files import storage_errors
    from plica.video.analysis import load
    from plica.video.report.page import write_report

    with storage_errors(directory):
        return write_report(load(directory))


def remeasure(directory: Path) -> int:
    """``plica measures`` for an analysis."""
    from plica.storage.files import storage_errors
    from plica.video.analysis import load
    from plica.video.tables import write_tables

    found = load(directory)
    with storage_errors(directory):
        write_tables(found)
    print(_table(found))
    return 0


def _video(options: argparse.Namespace) -> int:
    def lambda_said(found: Analysis) -> None:
        from plica.commands.smoothness import report_lambda

        text = report_lambda(found)
        if not options.quiet:
            print(f"{text}\nwritten: {found.directory / 'lambda.json'}")

    return _all(options, "modes", shown=lambda_said if options.lambda_report else None)


def _glottis(options: argparse.Namespace) -> int:
    return _all(options, "glottis")


def _modes(options: argparse.Namespace) -> int:
    def table(found: Analysis) -> None:
        print("mode   share  symmetry")
        for k, (share, symmetry) in enumerate(
            zip(found.modes.share, found["modes/symmetry"], strict=True), 1
        ):
            print(f"{k:4d} {100 * share:6.2f} %  {symmetry:+8.3f}")

    return _all(options, "modes", report=False, shown=None if options.quiet else table)


def _all(
    options: argparse.Namespace,
    until: str,
    *,
    report: bool = True,
    shown: Callable[[Analysis], None] | None = None,
) -> int:
    """Analyse the recordings: one in its directory, several in folders of it. What is `shown` of one at the
    end is shown of each."""
    for what, drawn in (("Corrections", options.corrections), ("Masks", options.masks)):
        if drawn is not None and len(options.source) > 1:
            raise InvalidInput(
                f"{what}: {drawn} for {len(options.source)} recordings; must be for one. "
                "Give the recording that was corrected alone."
            )
    require_one_recording(options)
    if len(options.source) == 1 and not options.table:
        found = _analysed(options, until, options.source[0], options.output, report=report)
        if shown is not None:
            shown(found)
        return 0

    def analysed(source: Path, folder: Path) -> Analysis:
        found = _analysed(options, until, source, folder, report=report, printed=False)
        if shown is not None:
            shown(found)
        return found

    return analyse_each(options.source, options.output, analysed, quiet=options.quiet, workbook=options.xlsx)


def _analysed(
    options: argparse.Namespace,
    until: str,
    source: Path,
    output: Path,
    *,
    report: bool,
    printed: bool = True,
) -> Analysis:
    """Analyse a recording as far as `until`, write its tables and print its measures.

    One of several (not `printed`) has no table of measures on the screen, and what is there already of all
    that is wanted where nothing has changed since.
    """
    import plica
    from plica.storage.files import storage_errors
    from plica.video.analysis import analyse
    from plica.video.files.corrections import read_corrections
    from plica.video.light import light_of
    from plica.video.settings import Settings

    require_libraries(options, report=report)
    plica.set_threads(options.threads)
    settings = Settings(
        fps=options.fps,
        mm_per_px=options.mm_per_px,
        rotation=options.rotation,
        first=options.first,
        last=options.last,
        region=options.region,
        dataset=options.dataset,
        segmenter=options.segmenter,
        midline=options.midline,
        anterior=options.anterior,
        patient_left=options.patient_left,
        preset=options.preset,
        correct_drift=not options.no_drift,
        modes=options.modes,
        kymogram=options.kymogram,
        label=options.label,
        recorded=options.recorded,
        audio=options.audio,
        egg=options.egg,
        sound_start=options.sound_start,
        sync=options.sync,
    )
    drawn = options.masks if options.corrections is None else read_corrections(options.corrections)
    with storage_errors(output):
        found = analyse(
            source,
            output,
            settings,
            masks={} if options.no_masks else drawn,
            until=until,
            progress=not options.quiet,
        )
        page = write_files(found, options, report=report, again=printed)
    for caution in [*untaken(found), *outdated(found)]:
        print(f"plica: Caution: {caution}", file=sys.stderr)
    if printed and not options.quiet:
        print(_table(found))
        if report:
            print(f"report: {page}")
    if printed and report and (light := light_of(found)).colour != "good":
        print(f"plica: Caution: the recording's light is {light.shown}. {light.said}", file=sys.stderr)
    return found


def _table(found: Analysis) -> str:
    """The measures, and which folds their left and right are."""
    sides = f"left: {found.side('left')}; right: {found.side('right')}"
    return f"{measures_table(found.measures)}\n{sides}"


def _flow(options: argparse.Namespace) -> int:
    import plica
    from plica.commands.flow import flow_of_files

    plica.set_threads(options.threads)
    text, caution = flow_of_files(
        options.first,
        options.second,
        options.output,
        preset=options.preset,
        truth=options.truth,
        mask=options.mask,
    )
    if not options.quiet:
        print(text)
    if caution:
        print(f"plica: {caution}", file=sys.stderr)
    return 0
