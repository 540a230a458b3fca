"""The command ``plica``."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Callable, Mapping, Sequence
from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING, Any

from plica.errors import InvalidInput, SolveFailed, StorageFailed

if TYPE_CHECKING:
    from plica.video.analysis import Analysis

__all__ = ["main"]

_MAX_THREADS = 1024  # the engine's
_DEFAULT_THREADS = 8  # at most
_FAILED, _BAD_INPUT, _INTERRUPTED = 1, 2, 130

_MAIN_HELP = """\
Simulates vibrating vocal folds from a scene file.

A first session:
  plica run examples/normal_phonation.toml -o runs/normal    compute; ends with a report
  xdg-open runs/normal/report.html                           look at it
  paraview runs/normal/fields.xdmf                           look at it in 3D
  plica video larynx.avi --fps 4000 -o analysis              measure a high-speed recording

A scene is a text file (TOML). It names a mesh and its tissue, and then only what it needs: without an
[airflow] table there is no airflow, without [contact] no contact. Quantities are SI numbers or texts with
a unit:

  [mesh]
  larynx = "coarse"
  [tissue.body]
  E = "20 kPa"
  nu = 0.45
  ...
  [airflow]
  subglottal_pressure = "0.8 kPa"
  [contact.multipliers]
  [time]
  step = "50 us"
  duration = "0.1 s"

Every key, waveform and measure, with its unit: docs/scene.md of the sources.

Exit codes: 0 done, 1 the computation or the storage failed, 2 bad input, 130 stopped by Ctrl-C.
"""

_RUN_HELP = """\
Computes SCENE and stores the results in DIR as they come:

  scene.toml     the scene with every default filled in
  results.h5     waveforms of every step and fields of some (HDF5; can be read at any moment)
  fields.xdmf    the fields for ParaView
  measures.json  {name: {value, unit, spread, cycles}} in SI
  report.html    pictures and numbers

examples:
  plica run scene.toml -o runs/one
  plica run scene.toml -o runs/one --resume     continue after Ctrl-C, a kill or a power failure;
                                                the results are those of a run without a stop
"""

_MESH_HELP = """\
Builds or reads the mesh of SCENE, checks it, and prints its counts, quality and the volume of each layer.

examples:
  plica mesh scene.toml
  plica mesh scene.toml -o mesh.vtu             any format that meshio writes, by the suffix

-o writes nodes and tetrahedra, each of these with the number of its layer (from 0, in the order printed) and
of its side (1 left, 2 right); no surfaces, no node sets, no names of layers.
"""

_BENCH_HELP = """\
Holds the engine of this installation against closed forms and conservation laws. A table goes to standard
output, progress to standard error.

examples:
  plica bench impact --problems R3 --elements 50
  plica bench free --steps 2000 --contacts multipliers penalty
"""

_IMPACT_HELP = """\
Elastic bars that strike a wall or each other, by every enforcement of contact, time scheme and mass of the
contact surfaces, against the exact motion:

  R1        periodic bar on a rigid obstacle (Dabaghi et al.)
  R2        bouncing bar under gravity (Doyen, Ern, Piperno)
  R3        two equal bars that meet at 1 m/s
  bars      two bars of 2.7 m, 2 GPa, 1000 kg/m^3, 7 mm apart, at +-35 m/s: 49.4975 MPa for 3.81838 ms
  bars-0.3  the same with Poisson's ratio 0.3 between rollers: 57.4289 MPa for 3.29103 ms

Columns. Relative errors (root mean square): displacement since first touch, force around the impact. Over
the exact value: impulse, duration from the first to the last step in contact, plateau (median pressure
while touching), peak, rebound (mean velocity afterwards). duty: share of the duration in contact; below 1
it chatters. energy: at the end, and its maximum, over that at the start. penetration: in edges. ledger:
what the energy balance leaves unexplained, over the largest energy. ms/step: processor time on this
machine, to compare rows. A run that fails has its message in the row. The last lines name the combination
for which the table speaks, and the rule.

examples:
  plica bench impact -o impact.csv                      everything, on 100 elements: some five minutes
  plica bench impact --problems R1 R3 --elements 50
  plica bench impact --problems R1 --periods 4 --contacts multipliers penalty
  plica bench impact --problems R3 --elements 50 100 200 400 --contacts multipliers \\
      --schemes "HHT(-0.3)" trapezoidal
"""

_FREE_HELP = """\
What free bodies must keep through collisions, by every enforcement of contact, time scheme and mass:

  box       a body that rattles in a frame, both free along x, kept going by an alternating force between
            them, over --steps steps
  blocks    two blocks without supports that turn and meet askew, 200 steps

Columns. momentum: largest change of the total, over that of one body. angular (about reference positions):
change in a step without contact; what the couples of the contact forces leave unexplained of it; its change
in all. force sum: of both sides, over the largest force. gain: the most by which energy and viscous loss
have outgrown the work done since first touch, over the largest energy; above zero, contact makes energy.
ledger, penetration: as in plica bench impact. s, ms/step: processor time
on this machine.

examples:
  plica bench free -o free.csv                          everything, 1e5 steps: some 20 minutes
  plica bench free --problems blocks
  plica bench free --contacts multipliers --schemes trapezoidal --masses redistributed
"""

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

presets: robust (the default), reference (Sun, Roth and Black, solved to rest), thesis (as reference, with
lambda 0.5 instead of 0.045: smoother), fast (for a first look).
"""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; returns its exit code."""
    options = _parser().parse_args(arguments)
    command: Callable[[argparse.Namespace], int] = options.command
    try:
        return command(options)
    except InvalidInput as error:
        return _say(str(error), _BAD_INPUT)
    except (SolveFailed, StorageFailed) as error:
        return _say(str(error), _FAILED)
    except MemoryError:
        return _say("there is not enough memory. Take a coarser mesh.", _FAILED)
    except KeyboardInterrupt as stop:
        return _say(f"{str(stop) or 'stopped'}.{_way_on(options)}", _INTERRUPTED)
    except BrokenPipeError:
        sys.stderr.close()
        return _FAILED


def _way_on(options: argparse.Namespace) -> str:
    """How to continue a run that has begun; nothing where there is none."""
    if options.command is not _run or not (options.directory / "scene.toml").exists():
        return ""
    return f" Continue with --resume: plica run {options.scene} -o {options.directory} --resume"


def _say(text: str, code: int) -> int:
    for line in text.splitlines():
        print(f"plica: {line}", file=sys.stderr)
    return code


def _parser() -> argparse.ArgumentParser:
    def part(
        name: str,
        command: Callable[[argparse.Namespace], int] | None,
        summary: str,
        text: str = "",
        among: Any = None,
    ) -> Any:
        sub = (among or commands).add_parser(
            name,
            help=summary,
            description=text or summary,
            formatter_class=argparse.RawDescriptionHelpFormatter,
        )
        sub.set_defaults(command=command)
        return sub

    parser = argparse.ArgumentParser(
        "plica", description=_MAIN_HELP, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    commands = parser.add_subparsers(title="commands", metavar="COMMAND", required=True)
    run = part("run", _run, "compute a scene", _RUN_HELP)
    run.add_argument("scene", metavar="SCENE", type=Path, help="scene file (TOML)")
    run.add_argument(
        "-o", "--output", dest="directory", metavar="DIR", type=Path, required=True, help="results"
    )
    run.add_argument(
        "--resume", action="store_true", help="continue the run in DIR from its newest checkpoint"
    )
    _add_threads(run)
    run.add_argument("--quiet", action="store_true", help="no progress, no table; only what is wrong")
    mesh = part("mesh", _mesh, "show or write the mesh of a scene", _MESH_HELP)
    mesh.add_argument("scene", metavar="SCENE", type=Path, help="scene file (TOML)")
    mesh.add_argument("-o", "--output", metavar="FILE", type=Path, help="write the mesh, e.g. mesh.vtu")
    _add_video(part("video", _video, "analyse a high-speed recording", _VIDEO_HELP))
    _add_video(part("glottis", _glottis, "find the glottis in a high-speed recording", _GLOTTIS_HELP))
    _add_video(part("modes", _modes, "find the modes of the tissue's motion in a recording", _MODES_HELP))
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
    _add_threads(flow)
    flow.add_argument("--quiet", action="store_true", help="print nothing; only what is wrong")
    part("info", _info, "show versions, what this build contains, and its licence")
    for name, command, summary in (
        ("report", _report, "write DIR/report.html anew"),
        ("measures", _measures, "measure the run in DIR, print the measures and write DIR/measures.json"),
    ):
        sub = part(name, command, summary)
        sub.add_argument("directory", metavar="DIR", type=Path, help="directory of a run")
    bench = part("bench", None, "hold the engine against closed forms and laws", _BENCH_HELP)
    benches = bench.add_subparsers(title="benchmarks", metavar="BENCHMARK", required=True)
    impact = part("impact", _impact, "bars that collide, against closed forms", _IMPACT_HELP, benches)
    free = part("free", _free, "what free bodies keep through collisions", _FREE_HELP, benches)
    impact.add_argument(
        "--elements", metavar="N", nargs="+", type=_whole, default=[100], help="along a bar (default: 100)"
    )
    impact.add_argument(
        "--periods", metavar="N", type=_whole, default=1, help="of R1 to compute (default: 1)"
    )
    free.add_argument(
        "--steps", metavar="N", type=_whole, default=100_000, help="of the box (default: 100000)"
    )
    for sub in (impact, free):
        sub.add_argument("--problems", metavar="NAME", nargs="+", help="default: all")
        for option in ("--contacts", "--schemes", "--masses"):
            sub.add_argument(option, metavar="NAME", nargs="+", help="default: all; a wrong one lists them")
        sub.add_argument(
            "--tolerance", metavar="T", type=_tolerance, default=1e-8, help="of linear solves (default: 1e-8)"
        )
        sub.add_argument(
            "-o",
            "--output",
            dest="csv",
            metavar="FILE",
            type=Path,
            help="also write all figures as CSV",
        )
        sub.add_argument("--quiet", action="store_true", help="no progress")
    return parser


def _add_threads(part: argparse.ArgumentParser) -> None:
    part.add_argument(
        "--threads",
        metavar="N",
        type=_threads,
        default=min(len(os.sched_getaffinity(0)), _DEFAULT_THREADS),
        help=f"default: the CPUs available, at most {_DEFAULT_THREADS}; results do not depend on it",
    )


def _add_video(video: argparse.ArgumentParser) -> None:
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
        "--region", metavar="X,Y,W,H", type=_numbers(int, 4), help="part of the turned frames, px"
    )
    video.add_argument(
        "--midline",
        metavar="X,Y,X,Y",
        type=_numbers(float, 4),
        help="anterior and posterior end, px of the region (default: found, anterior end up)",
    )
    video.add_argument("--dataset", metavar="NAME", help="of an HDF5 file that holds several")
    video.add_argument(
        "--preset",
        metavar="NAME",
        default="video",
        help="of the flow: video, robust, reference, thesis or fast",
    )
    video.add_argument("--modes", metavar="N", type=_whole, default=6, help="principal modes (default: 6)")
    video.add_argument("--no-drift", action="store_true", help="leave the endoscope's motion in")
    _add_threads(video)
    video.add_argument("--quiet", action="store_true", help="no progress, no table; only what is wrong")


def _numbers(kind: Callable[[str], Any], count: int) -> Callable[[str], tuple[Any, ...]]:
    def read(text: str) -> tuple[Any, ...]:
        try:
            values = tuple(kind(part) for part in text.split(","))
        except ValueError:
            values = ()
        if len(values) != count:
            raise argparse.ArgumentTypeError(f"{text}; must be {count} numbers with commas between them.")
        return values

    return read


def _whole(text: str, most: int | None = None) -> int:
    try:
        number = int(text)
    except ValueError:
        number = 0
    if number < 1 or (most is not None and number > most):
        to = "" if most is None else f" to {most}"
        raise argparse.ArgumentTypeError(f"{text}; must be a whole number from 1{to}.")
    return number


def _threads(text: str) -> int:
    return _whole(text, _MAX_THREADS)


def _tolerance(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not 0 < value < 1:
        raise argparse.ArgumentTypeError(f"{text}; must be a number between 0 and 1.")
    return value


def _run(options: argparse.Namespace) -> int:
    import plica
    from plica.phonation.measures import measure, write_measures
    from plica.phonation.solver_measures import doubts
    from plica.phonation.storage import storage_errors
    from plica.report import write_report

    scene = plica.Scene.load(options.scene)
    plica.set_threads(options.threads)
    try:
        run = plica.run(scene, options.directory, resume=options.resume, progress=not options.quiet)
    except SolveFailed:
        _conclude(options.directory)
        raise
    measures = measure(run)
    with storage_errors(options.directory):
        write_measures(measures, options.directory / "measures.json")
        report = write_report(run, options.directory / "report.html")
    if not options.quiet:
        print(_table({name: item.as_json() for name, item in measures.items()}, short=True))
        print(f"\nreport: {report}")
    return _say(doubts(run), 0)


def _conclude(directory: Path) -> None:
    """Measures and report of what a failed run has computed, so that one can look at it."""
    import plica
    from plica.phonation.measures import measure, write_measures
    from plica.phonation.storage import storage_errors
    from plica.report import write_report

    if not (directory / "results.h5").exists():
        return
    run = plica.Run.load(directory)
    with storage_errors(directory):
        write_measures(measure(run), directory / "measures.json")
        write_report(run, directory / "report.html")


def _mesh(options: argparse.Namespace) -> int:
    import plica
    from plica.phonation.mesh_summary import mesh_summary, write_mesh

    scene = plica.Scene.load(options.scene)
    mesh = plica.build_mesh(scene.mesh, scene.source)
    print(mesh_summary(mesh))
    if options.output is not None:
        write_mesh(mesh, options.output)
        print(f"written: {options.output} (without surfaces, node sets and names of layers)")
    return 0


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


def _info(options: argparse.Namespace) -> int:
    import plica

    info = plica.build_info()
    licence = "GPL-3.0-or-later (it contains parts under the GPL)" if info["gpl"] else "BSD-3-Clause"
    rows = {"plica": info["version"], "licence of this build": licence}
    rows |= {name: _plain(value) for name, value in info.items() if name not in {"version", "gpl"}}
    if "meshing" in info["absent"]:
        rows["meshing is for"] = "contact between any two meshes; built by PLICA_GPL=ON pip install ."
    rows["python"] = sys.version.split()[0]
    for name in ("numpy", "scipy", "h5py", "meshio", "pydantic", "pint", "xarray", "matplotlib", "pillow"):
        try:
            rows[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            rows[name] = "not installed"
    width = max(map(len, rows))
    print("\n".join(f"{name:<{width}}  {value}" for name, value in rows.items()))
    return 0


def _plain(value: object) -> str:
    return ", ".join(map(str, value)) if isinstance(value, (list, tuple)) else str(value)


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
        print(_table({name: item.as_json() for name, item in found.measures.items()}))
    return found


def _report(options: argparse.Namespace) -> int:
    import plica
    from plica.phonation.storage import storage_errors
    from plica.report import write_report

    run = plica.Run.load(options.directory)
    with storage_errors(options.directory):
        print(write_report(run, options.directory / "report.html"))
    return 0


def _measures(options: argparse.Namespace) -> int:
    import plica
    from plica.phonation.measures import measure, write_measures
    from plica.phonation.storage import storage_errors

    measures = measure(plica.Run.load(options.directory))
    with storage_errors(options.directory):
        write_measures(measures, options.directory / "measures.json")
    print(_table({name: item.as_json() for name, item in measures.items()}))
    return 0


def _impact(options: argparse.Namespace) -> int:
    from plica.bench import bars, impact
    from plica.bench.combinations import chosen, combinations
    from plica.bench.table import show

    names = chosen(options.problems, list(bars.PROBLEMS), "--problems")
    asked = combinations(options.contacts, options.schemes, options.masses)
    made = show(
        impact.rows(names, options.elements, asked, options.tolerance, options.periods),
        ("problem", "elements", "contact", "scheme", "mass", *impact.COLUMNS),
        total=len(names) * len(options.elements) * len(asked),
        csv=options.csv,
        progress=not options.quiet,
    )
    print(f"\n{impact.recommendation(made)}\n\n{impact.RULE}")
    return 0


def _free(options: argparse.Namespace) -> int:
    from plica.bench import free
    from plica.bench.combinations import chosen, combinations
    from plica.bench.table import show

    names = chosen(options.problems, free.PROBLEMS, "--problems")
    asked = combinations(options.contacts, options.schemes, options.masses)
    show(
        free.rows(names, asked, options.steps, options.tolerance),
        ("problem", "contact", "scheme", "mass", *free.COLUMNS),
        total=len(names) * len(asked),
        csv=options.csv,
        progress=not options.quiet,
    )
    return 0


_MAIN_MEASURES = (
    "fundamental_frequency",
    "open_quotient",
    "speed_quotient",
    "peak_flow",
    "mean_flow",
    "glottal_area_max",
    "amplitude_left",
    "amplitude_right",
    "peak_contact_pressure",
    "contact_impulse",
    "contact_duration",
    "contact_length_fraction",
    "ledger_error",
)
_DISPLAYED = {
    "m": (1e3, "mm"),
    "m^2": (1e6, "mm^2"),
    "m^3/s": (1e6, "cm^3/s"),
    "s": (1e3, "ms"),
    "Pa": (1e-3, "kPa"),
}


def _table(measures: Mapping[str, Mapping[str, Any]], *, short: bool = False) -> str:
    """The measures with their units, in the units that the field reads; `short`: the main ones."""
    names = [name for name in _MAIN_MEASURES if name in measures] if short else list(measures)
    lines = []
    for name in names or list(measures):
        entry = measures[name]
        if entry["value"] is None:
            if not short:
                lines.append(f"{name:<32} -            {entry.get('note', '')}")
            continue
        factor, unit = _DISPLAYED.get(entry["unit"], (1.0, entry["unit"]))
        unit = "" if unit == "1" else unit
        spread = f"+- {entry['spread'] * factor:.2g}" if entry["spread"] is not None else ""
        cycles = f"({entry['cycles']} cycles)" if entry["cycles"] else ""
        lines.append(f"{name:<32} {entry['value'] * factor:<12.6g} {unit:<8} {spread:<11} {cycles}".rstrip())
    return "\n".join(lines)


if __name__ == "__main__":
    sys.exit(main())
