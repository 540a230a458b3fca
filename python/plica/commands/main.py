"""The ``plica`` command."""

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
from plica.commands.output import measures_table
from plica.errors import InvalidInput, SolveFailed, StorageFailed

if TYPE_CHECKING:
    from plica.measures.caution import Caution
    from plica.measures.measure import Measures
    from plica.runs.results import Run

__all__ = ["main"]

_FAILED, _BAD_INPUT, _INTERRUPTED = 1, 2, 130

_MAIN_HELP = """\
Simulates vibrating vocal folds from a scene file, measures them in high-speed video, and estimates their
tissue from it.

A first session:
  plica examples scenes                                 copy example scenes to scenes/
  plica run scenes/first.toml -o runs/first             run a scene; ends with a report
  xdg-open runs/first/report.html                       open the report
  paraview runs/first/fields.xdmf                       view the fields in 3D
  plica uncertainty runs/first                          estimate the numerical uncertainty
  plica film runs/first -o clip.avi                     render it as video, with the true motion
  plica video larynx.avi --fps 4000 -o analysis         analyse a high-speed recording
  plica compare before after -o change                  compare two such analyses
  plica identify analysis --scene my.toml -o tissue     estimate the tissue from it

A scene is a text file (TOML) with a mesh, its tissue, and optional parts: without an [airflow] table there
is no airflow, without [contact] no contact. Quantities are SI numbers or texts with a unit:

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

All keys with units and defaults: plica keys
Verification of this installation: plica verify

Exit codes: 0 success, 1 the computation or the storage failed, 2 bad input, 130 stopped by Ctrl-C.
"""

_RUN_HELP = """\
Runs SCENE and stores the results in DIR as they are computed:

  scene.toml     the scene with every default filled in
  results.h5     waveforms of every step and fields of some (HDF5; can be read at any time): plica.Run.load
                 in Python, h5read("results.h5", "/waveforms/flow") in MATLAB, which reverses the axes
  fields.xdmf    the fields for ParaView
  waveforms.csv  one row per step, in SI; waveforms of every section are only in results.h5
  measures.json  {name: {value, unit, spread, cycles, uncertainty, definition}} in SI; the
                 spread is that between cycles, the uncertainty numerical, where it is known
  cautions.json  [{name, seen, advice}]: possible problems, with advice
  report.html    figures and tables

examples:
  plica run scene.toml -o runs/one
  plica run scene.toml -o runs/one --resume     continue after Ctrl-C, a kill or a power failure;
                                                the results are those of an uninterrupted run
  plica run scene.toml -o runs/one --uncertainty
                                                also estimate the numerical uncertainty (plica uncertainty
                                                --help); takes five times as long

A run that finished before the vibration was steady is continued in the same way: give SCENE a longer
duration (and change nothing else), then --resume. The results are those of a run with that duration from the
start.
"""

_MEASURES_HELP = """\
Measures the run or the analysis of a recording in DIR, prints the measures and writes DIR/measures.json and
DIR/waveforms.csv. With --from and --to, a part of a run is measured and printed; nothing is written.

examples:
  plica measures runs/one
  plica measures runs/one --from 0.1s --to 0.3s     only that part of the run
  plica measures runs/one --from 100ms              from there to the end
"""

_REPORT_HELP = """\
Writes the report of the run or the analysis of a recording in DIR again from the stored results, and prints
its path: DIR/report.html, with --pdf DIR/report.pdf. For a run that was killed it shows the computed part.

examples:
  plica report runs/one
  plica report analysis --pdf
"""

_MESH_HELP = """\
Builds or reads the mesh of SCENE, checks it, and prints its counts, quality and the volume of each layer.

examples:
  plica mesh scene.toml
  plica mesh scene.toml -o mesh.vtu             any format that meshio writes, by the suffix

-o writes nodes and tetrahedra, with the number of the layer (from 0, in the order printed) and of the side
(1 left, 2 right) of each tetrahedron; no surfaces, node sets or names of layers.
"""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; returns its exit code."""
    typed = sys.argv[1:] if arguments is None else list(arguments)
    options = _parser().parse_args(joined(typed))
    command: Callable[[argparse.Namespace], int] = options.command
    try:
        return command(options)
    except InvalidInput as error:
        return _print_error(str(error), _BAD_INPUT)
    except (SolveFailed, StorageFailed) as error:
        return _print_error(str(error), _FAILED)
    except MemoryError:
        return _print_error("there is not enough memory. Use a coarser mesh.", _FAILED)
    except KeyboardInterrupt as stop:
        return _print_error(f"{str(stop) or 'stopped'}.{_how_to_continue(options, typed)}", _INTERRUPTED)
    except BrokenPipeError:
        sys.stderr.close()
        return _FAILED


def _how_to_continue(options: argparse.Namespace, typed: Sequence[str]) -> str:
    """How to continue an interrupted command; empty if there is nothing to continue."""
    if getattr(options, "resumable", False):
        return " Repeat the same command to continue."
    resumable_file = getattr(options, "resumable_file", None)
    if resumable_file is None or not (options.directory / resumable_file).exists():
        return ""
    command, *rest = typed
    again = shlex.join(["plica", command, *["--resume"] * (not options.resume), *rest])
    return f" Continue with --resume: {again}"


def _print_error(text: str, code: int) -> int:
    for line in text.splitlines():
        print(f"plica: {line}", file=sys.stderr)
    return code


def _parser() -> argparse.ArgumentParser:
    parser = Parser("plica", description=_MAIN_HELP, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument(
        "--version", action="version", version=f"plica {__version__}", help="print the version and exit"
    )
    commands = parser.add_subparsers(title="commands", metavar="COMMAND", required=True)
    part = partial(add_command, commands)
    run = part("run", _run, "run a scene", _RUN_HELP)
    run.add_argument("scene", metavar="SCENE", type=Path, help="scene file (TOML)")
    run.add_argument(
        "-o", "--output", dest="directory", metavar="DIR", type=Path, required=True, help="results"
    )
    run.add_argument("--resume", action="store_true", help="continue the run in DIR, or extend its duration")
    run.add_argument(
        "--uncertainty", action="store_true", help="also estimate the numerical error (plica uncertainty)"
    )
    add_threads(run)
    run.add_argument("--quiet", action="store_true", help="no progress, no table; only errors and cautions")
    run.set_defaults(resumable_file="scene.toml")
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
    part("info", _info, "show versions, contents and licence of this build")
    compare.add_commands(commands)
    report = part("report", _report, "write DIR/report.html again", _REPORT_HELP)
    add_pdf(report)
    measures = part("measures", _measures, "measure the run or analysis in DIR", _MEASURES_HELP)
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
    from plica.runs.run import run_telling

    scene = plica.Scene.load(options.scene)
    plica.set_threads(options.threads)
    told: list[Caution] = []

    def tell(caution: Caution) -> None:
        told.append(caution)
        _print_cautions([caution])

    try:
        run = run_telling(scene, options.directory, tell, resume=options.resume, progress=not options.quiet)
    except SolveFailed:
        if (options.directory / "results.h5").exists():
            run = plica.Run.load(options.directory)
            _concluded(run, shown=not options.quiet)
            _print_cautions(
                [one for one in run.cautions if one not in run.scene_cautions]
            )  # those are in the error
        raise
    measures, report = _concluded(run, shown=not options.quiet)
    if not options.quiet:
        print(measures_table(measures, short=True))
        print(f"\nreport: {report}")
    _print_cautions([caution for caution in run.cautions if caution not in told])
    return uncertainty.estimated(options.directory, quiet=options.quiet) if options.uncertainty else 0


def _print_cautions(cautions: Sequence[object]) -> int:
    return _print_error("\n".join(f"Caution: {caution}" for caution in cautions), 0)


def _concluded(run: Run, *, shown: bool) -> tuple[Measures, Path]:
    """Write measures, cautions, table and report of the computed steps of a run."""
    from plica.report.progress import figures_shown
    from plica.report.run import write_report
    from plica.storage.files import storage_errors

    measures = _measured(run)
    with storage_errors(run.directory), figures_shown(shown):
        return measures, write_report(run, run.directory / "report.html", run.uncertainty)


def _measured(run: Run) -> Measures:
    """The measures of a run, after writing them with its cautions and waveforms to its directory."""
    from plica.measures.caution import write_cautions
    from plica.measures.file import write_measures
    from plica.runs.table import write_waveforms
    from plica.storage.files import storage_errors

    measures = run.measures
    with storage_errors(run.directory):
        write_measures(measures, run.directory / "measures.json")
        write_cautions(run.cautions, run.directory / "cautions.json")
        write_waveforms(run)
    return measures


def _mesh(options: argparse.Namespace) -> int:
    import plica
    from plica.scene.mesh.summary import mesh_summary, write_mesh
    from plica.scene.plausibility import scene_cautions

    scene = plica.Scene.load(options.scene)
    mesh = plica.build_mesh(scene.mesh, scene.source)
    print(mesh_summary(mesh))
    _print_cautions(scene_cautions(scene, mesh))
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
    from plica.report.page import pdf_of, require_pdf
    from plica.report.progress import figures_shown
    from plica.report.run import write_report
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

    asked = options.start is not None or options.end is not None
    if video.is_analysis(options.directory):
        if asked:
            raise InvalidInput(f"{options.directory}: --from and --to are for runs; this is a recording.")
        return video.remeasure(options.directory)
    run = plica.Run.load(options.directory)
    with as_options(("Run.between",), {"start": "--from", "end": "--to"}):
        chosen = run.between(_time(options.start), _time(options.end)) if asked else run
    measures = chosen.measures if asked else _measured(run)
    print(measures_table(measures))
    if run.steps < run.steps_asked:
        _print_error(
            f"{options.directory}: {run.status}; measured {run.steps} of {run.steps_asked} steps.", 0
        )
    return _print_cautions(chosen.cautions)


def _time(text: str | None) -> float | str | None:
    """A time from the command line: a number in s, or a number with a unit."""
    try:
        return text if text is None else float(text)
    except ValueError:
        return text


if __name__ == "__main__":
    sys.exit(main())
