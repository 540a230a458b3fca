"""``list``, ``run``, ``compare``, ``page`` and ``tables`` of ``python -m benchmarks``."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

from tqdm import tqdm

from benchmarks.harness.all_tables import write_tables
from benchmarks.harness.case_record import CaseRecord
from benchmarks.harness.case_table import as_markdown
from benchmarks.harness.compare import compare, pairs
from benchmarks.harness.families import FAMILIES, chosen_cases, family_of
from benchmarks.harness.page import write_page
from benchmarks.harness.run import blank, continue_record, failed_claims, measure
from plica.commands.arguments import add_command, whole
from plica.commands.text import hanging
from plica.errors import InvalidInput
from plica.storage.files import storage_errors

__all__ = ["add_commands"]

_LIST_HELP = """\
Lists families of cases with advice, their cases, methods and the reference for errors. A peer is another
package for the same task; peers that are not installed are marked, and left out of runs. In the source tree,
`make bench-peers` creates an environment with all of them.
"""

_RUN_HELP = """\
Measures CASES (names of cases or families; default: all). The methods of one setting are measured
alternately in rounds, each in its own process, with one thread and with two. For each case DIR gets

  CASE.json        settings, errors, every reading, memory, engine, compiler, processor, load, date

and at the end benchmarks.csv (all rows) and benchmarks.html (advice, figures, tables). After Ctrl-C the same
command continues, level by level; records started with another engine, machine or peer are refused.

--size small takes seconds per case, in this process and on one thread: it checks that everything works; its
times and memory are not meaningful.

examples:
  python -m benchmarks run -o figures
  python -m benchmarks run assembly filter -o figures --rounds 9
  python -m benchmarks run --size small

Exit codes: 0 all claims of the cases hold, 1 a method failed or a claim does not hold, 2 bad input.
"""

_COMPARE_HELP = """\
Compares two records of a case, or all cases that two directories share. A row is called slower or quicker
only if its readings differ beyond noise: a rank test at 1 % (Mann and Whitney; it needs five readings on
both sides) and medians 3 % apart. "too few": too few readings to detect a change. An error that increased by
more than 1 % is less exact. If a machine was busy, processor times are compared. Times of different machines
are not compared, with a note; different cases are refused.

examples:
  python -m benchmarks compare before/assembly.json after/assembly.json
  python -m benchmarks compare before after

Exit codes: 0 no row is worse, 1 a row is slower or less exact, 2 bad input.
"""


_TABLES_HELP = """\
Writes the table of every record in docs/records and docs/benchmarks, as Markdown and as CSV, and README.md,
which lists them: `make tables`.
"""


def add_commands(benches: Any) -> None:
    """Add them to the commands."""
    add_command(benches, "list", _list, "cases, methods, and which peers are installed", _LIST_HELP)
    run = add_command(benches, "run", _run, "measure cases, and write the page", _RUN_HELP)
    run.add_argument("cases", metavar="CASE", nargs="*", help="case or family (default: all)")
    run.add_argument("--size", choices=("small", "full"), default="full", help="default: full")
    run.add_argument("--threads", metavar="N", nargs="+", type=whole, help="default: 1 2; small: 1")
    run.add_argument("--rounds", metavar="N", type=whole, help="default: 5; small: 1")
    run.add_argument(
        "-o", "--output", dest="directory", metavar="DIR", type=Path, help="required for the full size"
    )
    run.add_argument("--anew", action="store_true", help="measure again cases that DIR has")
    run.add_argument("--quiet", action="store_true", help="no progress, no tables; only errors")
    compare = add_command(
        benches, "compare", _compare, "compare two records, separating change from noise", _COMPARE_HELP
    )
    compare.add_argument("before", metavar="A", type=Path, help="record (JSON) or directory of records")
    compare.add_argument("after", metavar="B", type=Path, help="likewise")
    page = add_command(benches, "page", _page, "write the page of a directory again")
    page.add_argument(
        "directory", metavar="DIR", type=Path, help="output directory of python -m benchmarks run"
    )
    tables = add_command(benches, "tables", _tables, "write the tables of all records", _TABLES_HELP)
    tables.add_argument(
        "-o",
        "--output",
        dest="directory",
        metavar="DIR",
        type=Path,
        default=Path("build/tables"),
        help="default: build/tables",
    )


def _list(options: argparse.Namespace) -> int:
    for number, family in enumerate(FAMILIES.values()):
        print(("\n" if number else "") + f"{family.name}: {family.title}")
        print(hanging("", family.advice, 2))
        for case in family.cases:
            description = f"{case.does} Reference: {case.reference}. Methods: {_methods(case)}."
            print(hanging(f"  {case.name}", description, 20))
    return 0


def _methods(case: Any) -> str:
    """The names of the methods, shortened if there are many; peers that are not installed are marked."""
    names = [method.name + ("" if method.installed else " (not installed)") for method in case.methods]
    more = f"; and {len(names) - 6} more" if len(names) > 8 else ""
    return "; ".join(names[:6] if more else names) + more


def _run(options: argparse.Namespace) -> int:
    small = options.size == "small"
    options.rounds = options.rounds or (1 if small else 5)
    options.threads = options.threads or ([1] if small else [1, 2])
    cases = chosen_cases(options.cases)
    if options.directory is None and not small:
        raise InvalidInput("run: -o is left out; must name a directory for the results of a full run.")
    options.resumable = options.directory is not None
    broken: list[str] = []
    for case in cases:
        record = _measured(case, options)
        if not options.quiet:
            print(f"\n## {record.case}\n\n{as_markdown(record)}", flush=True)
        broken += [f"{case.name}: {claim}" for claim in failed_claims(case, record)]
    if options.directory is not None:
        page = write_page(options.directory)
        if not options.quiet:
            print(f"\npage: {page}")
    for claim in broken:
        print(f"plica: {claim}", file=sys.stderr)
    return 1 if broken else 0


def _measured(case: Any, options: argparse.Namespace) -> CaseRecord:
    """The record of a case, continued if the directory has one."""
    record = blank(case, family_of(case.name).name, options.size, options.rounds)
    path = None
    if options.directory is not None:
        with storage_errors(options.directory, "made"):
            options.directory.mkdir(parents=True, exist_ok=True)
        path = options.directory / f"{case.name}.json"
        if path.exists() and not options.anew:
            record = continue_record(CaseRecord.read(path), record, str(path))
    with tqdm(
        unit=" rows", desc=case.name, file=sys.stderr, disable=options.quiet, delay=2, leave=False
    ) as bar:
        return measure(
            case,
            record,
            options.threads,
            keep=lambda made: None if path is None else made.write(path),
            on_row=lambda row: bar.update(),
        )


def _compare(options: argparse.Namespace) -> int:
    changes, worse = [], 0
    for before, after in pairs(options.before, options.after):
        found = compare(before, after)
        print(f"{before.case}: engine {before.environment.commit} -> {after.environment.commit}")
        for note in found.notes:
            print(f"  note: {note}")
        for change in found.changes:
            print(f"  {change}")
        worse += len(found.worse)
        changes += [change.verdict for change in found.changes]
    unknown = sum(verdict in ("too few", "not compared") for verdict in changes)
    text = f"{worse or 'none'} of {len(changes)} rows {'is' if worse == 1 else 'are'} slower or less exact"
    print(text + (f"; the time of {unknown} cannot be compared." if unknown else "."))
    return 1 if worse else 0


def _page(options: argparse.Namespace) -> int:
    print(write_page(options.directory))
    return 0


def _tables(options: argparse.Namespace) -> int:
    print(f"The table of every record, as Markdown and CSV: {write_tables(options.directory)}")
    return 0
