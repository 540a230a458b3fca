"""``plica compare``: two analyses of recordings, or two runs, beside each other."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from plica.commands.arguments import add_command, add_pdf
from plica.commands.video import is_analysis
from plica.errors import InvalidInput

if TYPE_CHECKING:
    from plica.phonation.report.comparison import RunComparison
    from plica.video.comparison import Comparison

__all__ = ["add_commands"]

_HELP = """\
Two analyses of plica video (or glottis) beside each other, as of one larynx before and after a treatment:
every measure of both with its 95 % interval, and the difference, after less before, with an interval of its
own from the bootstrap replicates of both. A * marks a difference whose interval leaves zero out: it is more
than the cycles' scatter. Whether it is more than a voice varies from one day to the next, two recordings
cannot tell.

What cannot be compared is said with the reason, and how to mend it: lengths where the size of a pixel is not
known of both (--mm-per-px), times without a frame rate (--fps), left and right where it is not known of both
which is the patient's (--patient-left; a turned endoscope is then allowed for, as with --anterior). All of
these may be told to plica video later, in the directory of its analysis.

With -o, in DIR:

  comparison.html  pictures next to each other: kymogram, cycle, phonovibrogram, area over a cycle; measures
  comparison.csv   a row a measure
  comparison.json  all of it: values, intervals, cautions, what was not compared and why
  comparison.pdf   with --pdf: the page on A4 (pip install 'plica[pdf]')

Two runs of plica run may be compared too: a simulation does not scatter, so differences have no interval.

examples:
  plica compare before after                     the table
  plica compare before after -o change --pdf     the page too
"""


def add_commands(commands: Any) -> None:
    """Add it to the commands of ``plica``."""
    part = add_command(commands, "compare", _compare, "show two analyses beside each other", _HELP)
    part.add_argument("before", metavar="BEFORE", type=Path, help="directory of an analysis, or of a run")
    part.add_argument("after", metavar="AFTER", type=Path, help="directory of another of the same kind")
    part.add_argument("-o", "--output", metavar="DIR", type=Path, help="directory of the page and tables")
    add_pdf(part)
    part.add_argument("--quiet", action="store_true", help="no table; only what is wrong")


def _compare(options: argparse.Namespace) -> int:
    from plica.report.comparison import comparison_table, write_comparison
    from plica.report.page import require_pdf
    from plica.report.progress import figures_shown
    from plica.storage.files import storage_errors

    if options.pdf and options.output is None:
        raise InvalidInput(
            "Compare: --pdf is given without -o; must have the directory that it is written to."
        )
    if options.pdf:
        require_pdf()
    found = _compared(options.before, options.after)
    if not options.quiet:
        print(comparison_table(found.changes))
    for remark in found.remarks:
        print(f"plica: {remark}", file=sys.stderr)
    if options.output is not None:
        with storage_errors(options.output), figures_shown(not options.quiet):
            options.output.mkdir(parents=True, exist_ok=True)
            page = write_comparison(found.sheet(), options.output, pdf=options.pdf)
        if not options.quiet:
            print(f"report: {page}")
    return 0


def _compared(before: Path, after: Path) -> Comparison | RunComparison:
    if _are_recordings(before, after):
        from plica.video.comparison import compare

        return compare(before, after)
    from plica.phonation.report.comparison import compare_runs
    from plica.phonation.run.results import Run

    return compare_runs([Run.load(before), Run.load(after)], [before, after])


def _are_recordings(before: Path, after: Path) -> bool:
    """Whether both are analyses of recordings; InvalidInput where only one is, or one is nothing."""
    for path in (before, after):
        if not (path / "results.h5").is_file():
            what = "is no directory" if not path.is_dir() else "has no results.h5"
            raise InvalidInput(f"Compare: {path} {what}; must be the directory of an analysis, or of a run.")
    if before.samefile(after):
        raise InvalidInput(f"Compare: {before} and {after} are one directory; must be two.")
    kinds = {path: is_analysis(path) for path in (before, after)}
    if len(set(kinds.values())) > 1:
        recording, run = sorted((before, after), key=lambda path: not kinds[path])
        raise InvalidInput(
            f"Compare: {recording} is the analysis of a recording and {run} a run; must be two of one kind. "
            "To measure a run as a camera would: plica film, then plica video."
        )
    return kinds[before]
