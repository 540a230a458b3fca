"""The command ``plica``."""

from __future__ import annotations

import argparse
import shlex
import sys
from collections.abc import Callable, Sequence
from functools import partial
from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING

from plica import __version__
from plica.commands import bench, compare, examples, film, identify, keys, larynx, uncertainty, verify, video
from plica.commands.arguments import Parser, add_command, add_pdf, add_threads, as_options, joined
from plica.commands.table import measures_table
from plica.errors import InvalidInput, SolveFailed, StorageFailed

if TYPE_CHECKING:
    from plica.measures.measure import Measures
    from plica.phonation.run.results import Run

__all__ = ["main"]

_FAILED, _BAD_INPUT, _INTERRUPTED = 1, 2, 130

_MAIN_HELP = """\
Simulates vibrating vocal folds from a scene file, measures them in high-speed video, and estimates their
tissue from it.

A first session:
  plica examples scenes                                 scenes to start from, copied to scenes/
  plica run scenes/first.toml -o runs/first             compute; ends with a report
  xdg-open runs/first/report.html                       look at it
  paraview runs/first/fields.xdmf                       look at it in 3D
  plica uncertainty runs/first                          how far its numbers are from those of finer levels
  plica film runs/first -o clip.avi                     film it, with the true motion of every pixel
  plica video larynx.avi --fps 4000 -o analysis         measure a high-speed recording
  plica compare before after -o change                  two such analyses beside each other
  plica identify analysis --scene my.toml -o tissue     estimate the tissue from it

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

Every key with its unit and default: plica keys
What this installation is proved to compute, row by row: plica verify

Exit codes: 0 done, 1 the computation or the storage failed, 2 bad input, 130 stopped by Ctrl-C.
"""

_RUN_HELP = """\
Computes SCENE and stores the results in DIR as they come:

  scene.toml     the scene with every default filled in
  results.h5     waveforms of every step and fields of some (HDF5; can be read at any moment): plica.Run.load
                 in Python, h5read("results.h5", "/waveforms/flow") in MATLAB, which turns the axes round
  fields.xdmf    the fields for ParaView
  waveforms.csv  a row a step, in SI; what there is of every section is in results.h5 alone
  measures.json  {name: {value, unit, spread, cycles, definition}} in SI
  cautions.json  [{name, seen, advice}]: what is to be doubted, and what to do about it
  report.html    pictures and numbers

examples:
  plica run scene.toml -o runs/one
  plica run scene.toml -o runs/one --resume     continue after Ctrl-C, a kill or a power failure;
                                                the results are those of a run without a stop
  plica run scene.toml -o runs/one --uncertainty
                                                then say how far its numbers are from those of finer steps
                                                and meshes (plica uncertainty --help); five times as long

A run that has come to its end before its voice settled is continued in the same way: give SCENE a longer
duration (and change nothing else), then --resume. The results are those of a run that had it from the start.
"""

_MEASURES_HELP = """\
Measures what is in DIR, a run or an analysis of a recording, prints the measures and writes DIR/measures.json
and DIR/waveforms.csv. With --from and --to, a part of a run is measured and printed; nothing is written.

examples:
  plica measures runs/one
  plica measures runs/one --from 0.1s --to 0.3s     that part of the run alone
  plica measures runs/one --from 100ms              from there to its end
"""

_REPORT_HELP = """\
Draws the page of DIR, a run or an analysis of a recording, anew from what is stored there, and prints its
name: DIR/report.html, with --pdf DIR/report.pdf. Of a run that was killed it shows the part it came to.

examples:
  plica report runs/one
  plica report analysis --pdf
"""

_MESH_HELP = """\
Builds or reads the mesh of SCENE, checks it, and prints its counts, quality and the volume of each layer.

examples:
  plica mesh scene.toml
  plica mesh scene.toml -o mesh.vtu             any format that meshio writes, by the suffix

-o writes nodes and tetrahedra, each of these with the number of its layer (from 0, in the order printed) and
of its side (1 left, 2 right); no surfaces, no node sets, no names of layers.
"""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; returns its exit code."""
    typed = sys.argv[1:] if arguments is None else list(arguments)
    options = _parser().parse_args(joined(typed))
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
        return _say(f"{str(stop) or 'stopped'}.{_way_on(options, typed)}", _INTERRUPTED)
    except BrokenPipeError:
        sys.stderr.close()
        return _FAILED


def _way_on(options: argparse.Namespace, typed: Sequence[str]) -> str:
    """How to continue what has begun; nothing where there is nothing."""
    if getattr(options, "goes_on", False):
        return " The same command goes on from there."
    begun = getattr(options, "begun_file", None)
    if begun is None or not (options.directory / begun).exists():
        return ""
    command, *rest = typed
    again = shlex.join(["plica", command, *["--resume"] * (not options.resume), *rest])
    return f" Continue with --resume: {again}"


def _say(text: str, code: int) -> int:
    for line in text.splitlines():
        print(f"plica: {line}", file=sys.stderr)
    return code


def _parser() -> argparse.ArgumentParser:
    parser = Parser("plica", description=_MAIN_HELP, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument(
        "--version", action="version", version=f"plica {__version__}", help="print it and end"
    )
    commands = parser.add_subparsers(title="commands", metavar="COMMAND", required=True)
    part = partial(add_command, commands)
    run = part("run", _run, "compute a scene", _RUN_HELP)
    run.add_argument("scene", metavar="SCENE", type=Path, help="scene file (TOML)")
    run.add_argument(
        "-o", "--output", dest="directory", metavar="DIR", type=Path, required=True, help="results"
    )
    run.add_argument(
        "--resume", action="store_true", help="continue the run in DIR, also to a longer duration"
    )
    run.add_argument(
        "--uncertainty", action="store_true", help="then estimate the numerical error (plica uncertainty)"
    )
    add_threads(run)
    run.add_argument("--quiet", action="store_true", help="no progress, no table; only what is wrong")
    run.set_defaults(begun_file="scene.toml")
    mesh = part("mesh", _mesh, "show or write the mesh of a scene", _MESH_HELP)
    mesh.add_argument("scene", metavar="SCENE", type=Path, help="scene file (TOML)")
    mesh.add_argument("-o", "--output", metavar="FILE", type=Path, help="write the mesh, e.g. mesh.vtu")
    examples.add_commands(commands)
    keys.add_commands(commands)
    video.add_commands(commands)
    film.add_commands(commands)
    larynx.add_commands(commands)
    identify.add_commands(commands)
    uncertainty.add_commands(commands)
    part("info", _info, "show versions, what this build contains, and its licence")
    compare.add_commands(commands)
    report = part("report", _report, "write DIR/report.html anew", _REPORT_HELP)
    add_pdf(report)
    measures = part("measures", _measures, "measure what is in DIR, all of it or a part", _MEASURES_HELP)
    for sub in (report, measures):
        sub.add_argument(
            "directory", metavar="DIR", type=Path, help="directory of a run, or of an analysis of a recording"
        )
    measures.add_argument("--from", dest="start", metavar="TIME", help='of a run, e.g. "0.1s" or 0.1')
    measures.add_argument("--to", dest="end", metavar="TIME", help="likewise (default: the end)")
    verify.add_commands(commands)
    bench.add_commands(commands)
    return parser


def _run(options: argparse.Namespace) -> int:
    import plica

    scene = plica.Scene.load(options.scene)
    plica.set_threads(options.threads)
    try:
        run = plica.run(scene, options.directory, resume=options.resume, progress=not options.quiet)
    except SolveFailed:
        if (options.directory / "results.h5").exists():
            run = plica.Run.load(options.directory)
            _concluded(run, shown=not options.quiet)
            _say_cautions([one for one in run.cautions if one not in run.scene_cautions])  # the error does
        raise
    measures, report = _concluded(run, shown=not options.quiet)
    if not options.quiet:
        print(measures_table(measures, short=True))
        print(f"\nreport: {report}")
    _say_cautions(run.cautions)
    return uncertainty.estimated(options.directory, quiet=options.quiet) if options.uncertainty else 0


def _say_cautions(cautions: Sequence[object]) -> int:
    return _say("\n".join(f"Caution: {caution}" for caution in cautions), 0)


def _concluded(run: Run, *, shown: bool) -> tuple[Measures, Path]:
    """Measures, cautions, table and report of what a run has computed, or of the part before it failed."""
    from plica.phonation.report import write_report
    from plica.report.progress import figures_shown
    from plica.storage.files import storage_errors

    measures = _measured(run)
    with storage_errors(run.directory), figures_shown(shown):
        return measures, write_report(run, run.directory / "report.html", run.uncertainty)


def _measured(run: Run) -> Measures:
    """The measures of a run, written to its directory with its cautions and its table."""
    from plica.measures.caution import write_cautions
    from plica.measures.file import write_measures
    from plica.phonation.measures.measure import measure
    from plica.phonation.run.table import write_waveforms
    from plica.storage.files import storage_errors

    measures = measure(run)
    with storage_errors(run.directory):
        write_measures(measures, run.directory / "measures.json")
        write_cautions(run.cautions, run.directory / "cautions.json")
        write_waveforms(run)
    return measures


def _mesh(options: argparse.Namespace) -> int:
    import plica
    from plica.phonation.scene.mesh_summary import mesh_summary, write_mesh
    from plica.phonation.scene.plausibility import scene_cautions

    scene = plica.Scene.load(options.scene)
    mesh = plica.build_mesh(scene.mesh, scene.source)
    print(mesh_summary(mesh))
    _say_cautions(scene_cautions(scene, mesh))
    if options.output is not None:
        write_mesh(mesh, options.output)
        print(f"written: {options.output} (without surfaces, node sets and names of layers)")
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
    for name in (
        "numpy",
        "scipy",
        "h5py",
        "meshio",
        "pydantic",
        "pint",
        "xarray",
        "matplotlib",
        "pillow",
        "av",
        "weasyprint",
    ):
        try:
            rows[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            rows[name] = "not installed"
    width = max(map(len, rows))
    print("\n".join(f"{name:<{width}}  {value}" for name, value in rows.items()))
    return 0


def _plain(value: object) -> str:
    return ", ".join(map(str, value)) if isinstance(value, (list, tuple)) else str(value)


def _report(options: argparse.Namespace) -> int:
    import plica
    from plica.phonation.report import write_report
    from plica.report.page import pdf_of, require_pdf
    from plica.report.progress import figures_shown
    from plica.storage.files import storage_errors

    if options.pdf:
        require_pdf()
    with storage_errors(options.directory), figures_shown():
        if video.is_analysis(options.directory):
            page = video.redraw(options.directory)
        else:
            run = plica.Run.load(options.directory)
            page = write_report(run, options.directory / "report.html", run.uncertainty)
        print(pdf_of(page) if options.pdf else page)
    return 0


def _measures(options: argparse.Namespace) -> int:
    import plica
    from plica.phonation.measures.cautions import cautions
    from plica.phonation.measures.measure import measure

    asked = options.start is not None or options.end is not None
    if video.is_analysis(options.directory):
        if asked:
            raise InvalidInput(f"{options.directory}: --from and --to are for runs; it is of a recording.")
        return video.remeasure(options.directory)
    run = plica.Run.load(options.directory)
    with as_options(("Run.between",), {"start": "--from", "end": "--to"}):
        chosen = run.between(_time(options.start), _time(options.end)) if asked else run
    measures = measure(chosen) if asked else _measured(run)
    print(measures_table(measures))
    if run.steps < run.steps_asked:
        _say(f"{options.directory}: {run.status}; {run.steps} of {run.steps_asked} steps were measured.", 0)
    return _say_cautions(cautions(chosen))


def _time(text: str | None) -> float | str | None:
    """A time as it is typed: a number, in s, or a number with its unit."""
    try:
        return text if text is None else float(text)
    except ValueError:
        return text


if __name__ == "__main__":
    sys.exit(main())
