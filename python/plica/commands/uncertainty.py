"""``plica uncertainty``: numerical uncertainty of the measures of a run."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from plica.commands.arguments import add_command, add_threads
from plica.measures.uncertainty import VERDICTS

__all__ = ["add_commands", "estimated"]

_MEANINGS = "\n".join(f"  {verdict:<16} {meaning}" for verdict, meaning in VERDICTS.items())

_HELP = f"""\
Estimates the discretisation error of every measure of the finished run in DIR. The scene is computed again
with half its step and, as far as the budget allows, on a finer and a coarser mesh and with a quarter of the
step: a steady vibration from its own state, without the first 6 cycles, others from their start. The cost is
printed first. Then it writes, in addition to measures.json,

  uncertainty.json   {{source, remarks, levels, measures: {{name: {{value, unit, numerical, step, mesh,
                     statistical, spread, cycles}}}}, waveforms: likewise}}; step and mesh are
                     {{uncertainty, verdict, order, extrapolated, values}}
  uncertainty.csv    one row per measure, in SI
  report.html        and measures.json again, with the numerical uncertainty

"numerical" is the sum of the uncertainties by step and by mesh, bounds for 95 of 100 cases; "statistical",
of the mean over the measured cycles, is not included. The table shows how each part was determined, an order
with its number (a level is the scene with another step or mesh):

{_MEANINGS}

After Ctrl-C the same command continues; the levels are kept in DIR/uncertainty and may be deleted.
docs/uncertainty.md describes the method and its reliability.

examples:
  plica uncertainty runs/one
  plica uncertainty runs/one --budget 8           more levels: up to eight times the time of the run
  plica uncertainty runs/own --mesh finer.toml    a scene that differs only in its mesh
  plica uncertainty runs/one --mesh none          only the error of the step
  plica run scene.toml -o runs/one --uncertainty  run and estimate
"""


def add_commands(commands: Any) -> None:
    """Add it to the commands of ``plica``."""
    part = add_command(commands, "uncertainty", _uncertainty, "estimate the numerical error of a run", _HELP)
    part.add_argument("directory", metavar="DIR", type=Path, help="of a finished run")
    part.add_argument(
        "--budget",
        metavar="N",
        type=float,
        default=4.0,
        help="in units of the time of the run, at least a minute (default: 4)",
    )
    part.add_argument(
        "--mesh",
        metavar="SCENE",
        default="auto",
        help='compare with the mesh of this scene; "none": no other mesh',
    )
    add_threads(part)
    part.add_argument("--quiet", action="store_true", help="no plan, no progress, no table")
    part.set_defaults(resumable=True)


def _uncertainty(options: argparse.Namespace) -> int:
    import plica

    plica.set_threads(options.threads)
    return estimated(options.directory, budget=options.budget, mesh=options.mesh, quiet=options.quiet)


def estimated(directory: Path, *, budget: float = 4.0, mesh: str = "auto", quiet: bool = False) -> int:
    """Estimate, print the table and write the report again."""
    from plica.measures.file import write_measures
    from plica.report.progress import figures_shown
    from plica.report.run import write_report
    from plica.runs.results import Run
    from plica.storage.files import storage_errors
    from plica.uncertainty import estimate_uncertainty
    from plica.uncertainty.text import uncertainty_table

    found = estimate_uncertainty(directory, budget=budget, mesh=mesh, progress=not quiet)
    with storage_errors(directory), figures_shown(not quiet):
        run = Run.load(directory)
        write_measures(run.measures, directory / "measures.json")
        report = write_report(run, directory / "report.html", found)
    if not quiet:
        print(uncertainty_table(found))
        print(f"\nreport: {report}")
    return 0
