"""``plica compare``: compare two analyses of recordings, or two runs."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from plica.commands.arguments import add_command, add_pdf
from plica.commands.video import is_analysis
from plica.errors import InvalidInput

if TYPE_CHECKING:
    from collections.abc import Callable

    from plica.report.comparison import Sheet
    from plica.report.run.comparison import RunComparison
    from plica.video.report.comparison import Comparison

__all__ = ["add_commands"]

_HELP = """\
Compares two analyses of plica video (or glottis), e.g. of one larynx before and after a treatment: every
measure of both with its 95 % interval, and the difference, after minus before, with its own interval from
the bootstrap replicates of both. A * marks a difference whose interval excludes zero: it exceeds the
variation between cycles. Whether it exceeds the variation of a voice from day to day cannot be determined
from two recordings.

Measures that cannot be compared are listed with the reason and the remedy: lengths if the pixel size of one
is unknown (--mm-per-px), times without a frame rate (--fps), left and right if the patient's side is unknown
in one (--patient-left; a rotated endoscope is then accounted for, as with --anterior). All of these can be
given to plica video later, in the directory of its analysis.

With -o, in DIR:

  comparison.html  figures side by side: kymogram, cycle, phonovibrogram, area over a cycle; measures
  comparison.csv   one row per measure
  comparison.json  everything: values, intervals, cautions, measures that were not compared and why
  comparison.pdf   with --pdf: the page on A4 (pip install 'plica[pdf]')

Two runs of plica run can be compared too: simulations are deterministic, so differences have no interval. One
within the numerical uncertainty, or below the standard deviation between cycles, has a note that says so.
Their page begins with the flows of both over a cycle, the spectra of both sounds, and both sounds to listen
to, at one full scale. Of two that differ in subglottal pressure it is said if the flow falls as the pressure
rises.

examples:
  plica compare before after                     the table
  plica compare before after -o change --pdf     also the page
"""


def add_commands(commands: Any) -> None:
    """Add it to the commands of ``plica``."""
    part = add_command(commands, "compare", _compare, "compare two analyses, or two runs", _HELP)
    part.add_argument("before", metavar="BEFORE", type=Path, help="directory of an analysis, or of a run")
    part.add_argument("after", metavar="AFTER", type=Path, help="directory of another one of the same kind")
    part.add_argument("-o", "--output", metavar="DIR", type=Path, help="directory of the page and tables")
    add_pdf(part)
    part.add_argument("--quiet", action="store_true", help="no table; only errors and cautions")


def _compare(options: argparse.Namespace) -> int:
    from plica.report.comparison import comparison_table, write_comparison
    from plica.report.page import require_pdf
    from plica.report.progress import figures_shown
    from plica.storage.files import storage_errors

    if options.pdf and options.output is None:
        raise InvalidInput(
            "Compare: --pdf is given without -o; must come with -o, the directory of the page."
        )
    if options.pdf:
        require_pdf()
    found, sheet_of = _compared(options.before, options.after)
    if not options.quiet:
        print(comparison_table(found.changes))
    for remark in found.remarks:
        print(f"plica: {remark}", file=sys.stderr)
    if options.output is not None:
        with storage_errors(options.output), figures_shown(not options.quiet):
            options.output.mkdir(parents=True, exist_ok=True)
            page = write_comparison(sheet_of(), options.output, pdf=options.pdf)
        if not options.quiet:
            print(f"report: {page}")
    return 0


def _compared(before: Path, after: Path) -> tuple[Comparison | RunComparison, Callable[[], Sheet]]:
    """The comparison, and what makes its page, which draws."""
    if _are_recordings(before, after):
        from plica.video.report.comparison import compare
        from plica.video.report.comparison_page import sheet_of

        recordings = compare(before, after)
        return recordings, lambda: sheet_of(recordings)
    from plica.report.run.comparison import compare_runs, sheet_of_runs
    from plica.runs.results import Run

    runs = compare_runs([Run.load(before), Run.load(after)], [before, after])
    return runs, lambda: sheet_of_runs(runs)


def _are_recordings(before: Path, after: Path) -> bool:
    """Whether both are analyses of recordings; raises InvalidInput if only one is, or one is neither."""
    for path in (before, after):
        if not (path / "results.h5").is_file():
            what = "is not a directory" if not path.is_dir() else "has no results.h5"
            raise InvalidInput(f"Compare: {path} {what}; must be the directory of an analysis, or of a run.")
    if before.samefile(after):
        raise InvalidInput(f"Compare: {before} and {after} are the same directory; must be different.")
    kinds = {path: is_analysis(path) for path in (before, after)}
    if len(set(kinds.values())) > 1:
        recording, run = sorted((before, after), key=lambda path: not kinds[path])
        raise InvalidInput(
            f"Compare: {recording} is the analysis of a recording and {run} a run; must be of the same kind. "
            "To measure a run like a recording, use plica film, then plica video."
        )
    return kinds[before]
