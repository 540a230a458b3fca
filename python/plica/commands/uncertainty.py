"""``plica uncertainty``: how far the numbers of a run are from those of finer levels."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from plica.commands.arguments import add_command, add_threads

__all__ = ["add_commands", "estimated"]

_HELP = """\
Says of every measure of the finished run in DIR how far it may be from what an infinitely small step and mesh
would give. The scene is computed again with half its step and, as far as the budget goes, on a finer and a
coarser mesh and with a quarter of the step: a settled voice from its own orbit, the first 6 cycles left out,
anything else from its start. What that costs is said before it begins. Then it writes, beside measures.json,

  uncertainty.json   {source, remarks, levels, measures: {name: {value, unit, numerical, step, mesh,
                     statistical, spread, cycles}}, waveforms: likewise}; step and mesh are
                     {uncertainty, verdict, order, extrapolated, values}
  uncertainty.csv    a row a measure, in SI
  report.html        anew, with value +- uncertainty

"numerical" is the sum of the uncertainties by step and by mesh, bounds meant to hold in 95 of 100 cases;
"statistical", of the mean over the cycles that were measured, is no part of it. The table says of both parts
how they were found:

  order 2.0          three levels converge with that order, which is theory's
  monotone, 1.4      they converge with that order, which is not: a factor of safety of 3
  two levels         the order is taken from theory, with that factor
  scatter            levels differ by less than cycles do: the bound is what the cycles let one see
  no convergence     differences do not fall: not in the asymptotic range, three times the largest difference
  unchanged          no difference at all

Stopped by Ctrl-C, the same command goes on; the levels are kept in DIR/uncertainty and may be deleted.
docs/uncertainty.md says by which rule, and how often it held the truth.

examples:
  plica uncertainty runs/one
  plica uncertainty runs/one --budget 8           more levels: up to eight times what the run took
  plica uncertainty runs/own --mesh finer.toml    a scene with another mesh of one's own, all else the same
  plica uncertainty runs/one --mesh none          of the step alone
  plica run scene.toml -o runs/one --uncertainty  both in one
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
        help="times what the run took, at least a minute (default: 4)",
    )
    part.add_argument(
        "--mesh",
        metavar="SCENE",
        default="auto",
        help='compare with the mesh of this scene; "none": with none',
    )
    add_threads(part)
    part.add_argument("--quiet", action="store_true", help="no plan, no progress, no table")
    part.set_defaults(goes_on=True)


def _uncertainty(options: argparse.Namespace) -> int:
    import plica

    plica.set_threads(options.threads)
    return estimated(options.directory, budget=options.budget, mesh=options.mesh, quiet=options.quiet)


def estimated(directory: Path, *, budget: float = 4.0, mesh: str = "auto", quiet: bool = False) -> int:
    """Estimate, print the table and draw the report anew."""
    from plica.phonation.report import write_report
    from plica.phonation.run.results import Run
    from plica.report.progress import figures_shown
    from plica.storage.files import storage_errors
    from plica.uncertainty import estimate_uncertainty
    from plica.uncertainty.text import uncertainty_table

    found = estimate_uncertainty(directory, budget=budget, mesh=mesh, progress=not quiet)
    with storage_errors(directory), figures_shown(not quiet):
        report = write_report(Run.load(directory), directory / "report.html", found)
    if not quiet:
        print(uncertainty_table(found))
        print(f"\nreport: {report}")
    return 0
