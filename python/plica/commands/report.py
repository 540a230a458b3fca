"""``plica report`` and ``plica measures``: of a run or an analysis that is stored."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from plica.commands import video
from plica.commands.arguments import add_command, add_pdf, as_options
from plica.commands.output import measures_table, print_cautions, print_error
from plica.errors import InvalidInput

if TYPE_CHECKING:
    from plica.measures.measure import Measures
    from plica.runs.results import Run

__all__ = ["add_commands", "write_measures_of"]

_MEASURES_HELP = """\
Measures the run or the analysis of a recording in DIR, prints the measures and writes DIR/measures.json and
DIR/waveforms.csv. With --from and --to, a part of a run is measured and printed; nothing is written.

examples:
  plica measures runs/one
  plica measures runs/one --from 40ms --to 60ms     only that part of the run
  plica measures runs/one --from 40ms               from there to the end
"""

_REPORT_HELP = """\
Writes the report of the run or the analysis of a recording in DIR again from the stored results, and prints
its path: DIR/report.html, with --pdf DIR/report.pdf. For a run that was killed it shows the computed part.

examples:
  plica report runs/one
  plica report analysis --pdf
"""


def add_commands(commands: Any) -> None:
    """Add them to the commands of ``plica``."""
    report = add_command(commands, "report", _report, "write DIR/report.html again", _REPORT_HELP)
    add_pdf(report)
    measures = add_command(
        commands, "measures", _measures, "measure the run or analysis in DIR", _MEASURES_HELP
    )
    for part in (report, measures):
        part.add_argument(
            "directory", metavar="DIR", type=Path, help="directory of a run, or of an analysis of a recording"
        )
    measures.add_argument("--from", dest="start", metavar="TIME", help='of a run, e.g. "0.1s" or 0.1')
    measures.add_argument("--to", dest="end", metavar="TIME", help="likewise (default: the end)")


def write_measures_of(run: Run) -> Measures:
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
    measures = chosen.measures if asked else write_measures_of(run)
    print(measures_table(measures))
    if run.steps < run.steps_asked:
        print_error(f"{options.directory}: {run.status}; measured {run.steps} of {run.steps_asked} steps.", 0)
    return print_cautions(chosen.cautions)


def _time(text: str | None) -> float | str | None:
    """A time from the command line: a number in s, or a number with a unit."""
    try:
        return text if text is None else float(text)
    except ValueError:
        return text
