"""``plica run``: run a scene, measure it and report it."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from plica.commands import uncertainty
from plica.commands.arguments import add_command, add_threads
from plica.commands.output import measures_table, print_cautions
from plica.commands.report import write_measures_of
from plica.errors import SolveFailed

if TYPE_CHECKING:
    from plica.measures.caution import Caution
    from plica.measures.measure import Measures
    from plica.runs.results import Run

__all__ = ["add_commands"]

_HELP = """\
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
  plica run vowel.toml -o runs/bare --without tract --without trachea
                                                the same voice without tubes; plica compare shows both

A run that finished before the vibration was steady is continued in the same way: give SCENE a longer
duration (and change nothing else), then --resume. The results are those of a run with that duration from the
start.
"""


def add_commands(commands: Any) -> None:
    """Add it to the commands of ``plica``."""
    part = add_command(commands, "run", _run, "run a scene", _HELP)
    part.add_argument("scene", metavar="SCENE", type=Path, help="scene file (TOML)")
    part.add_argument(
        "-o", "--output", dest="directory", metavar="DIR", type=Path, required=True, help="results"
    )
    part.add_argument(
        "--without",
        metavar="KEY",
        action="append",
        default=[],
        help="leave this part of the scene out, e.g. tract; can be given again",
    )
    part.add_argument("--resume", action="store_true", help="continue the run in DIR, or extend its duration")
    part.add_argument(
        "--uncertainty", action="store_true", help="also estimate the numerical error (plica uncertainty)"
    )
    add_threads(part)
    part.add_argument("--quiet", action="store_true", help="no progress, no table; only errors and cautions")
    part.set_defaults(resumable_file="scene.toml")


def _run(options: argparse.Namespace) -> int:
    import plica
    from plica.runs.run import run_telling

    scene = plica.Scene.load(options.scene)
    if options.without:
        scene = scene.replace(dict.fromkeys(options.without))
    plica.set_threads(options.threads)
    told: list[Caution] = []

    def tell(caution: Caution) -> None:
        told.append(caution)
        print_cautions([caution])

    try:
        run = run_telling(scene, options.directory, tell, resume=options.resume, progress=not options.quiet)
    except SolveFailed:
        if (options.directory / "results.h5").exists():
            run = plica.Run.load(options.directory)
            _concluded(run, shown=not options.quiet)
            print_cautions(
                [one for one in run.cautions if one not in run.scene_cautions]
            )  # those are in the error
        raise
    measures, report = _concluded(run, shown=not options.quiet)
    if not options.quiet:
        print(measures_table(measures, short=True))
        print(f"\nreport: {report}")
    print_cautions([caution for caution in run.cautions if caution not in told])
    return uncertainty.estimated(options.directory, quiet=options.quiet) if options.uncertainty else 0


def _concluded(run: Run, *, shown: bool) -> tuple[Measures, Path]:
    """Write measures, cautions, table and report of the computed steps of a run."""
    from plica.report.progress import figures_shown
    from plica.report.run import write_report
    from plica.storage.files import storage_errors

    measures = write_measures_of(run)
    with storage_errors(run.directory), figures_shown(shown):
        return measures, write_report(run, run.directory / "report.html", run.uncertainty)
