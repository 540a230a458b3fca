"""``plica bench``: error against run time, and the engine against closed forms and conservation laws."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from plica.commands import bench_contact, bench_extremes
from plica.commands.arguments import add_command, whole
from plica.errors import InvalidInput

if TYPE_CHECKING:
    from plica.bench.record import Record

__all__ = ["add_commands"]

_BENCH_HELP = """\
Error against run time of this installation, beside other packages where they are installed: what is it worth
to wait longer, and which method is never the right one.

examples:
  plica bench list                          the cases, and which peers are here
  plica bench run -o figures                all of them, some 40 minutes; ends with figures/benchmarks.html
  plica bench run assembly --size small     does it work: seconds, no figures to quote
  plica bench compare before after          what became slower, quicker or less exact between two of these
  plica bench page figures                  the page anew

Tables of one subject, in more detail:
  plica bench impact --problems R3 --elements 50
  plica bench free --steps 2000 --contacts multipliers penalty
  plica bench extremes --size small

Trust ratios of rows that took turns on an idle machine; times of other machines or days say little.
"""

_LIST_HELP = """\
Lists families of cases with what to use when, their cases, methods and the reference that errors are taken
against. A peer is a package that does the same; those not installed are named, and left out of runs.
In the sources, `make bench-peers` makes an environment with all of them.
"""

_RUN_HELP = """\
Measures CASES (names of cases or families; all where none is named). All methods of one setting take turns,
round after round, each in a process of its own, with one thread and with two. DIR gets for each case

  CASE.json        settings, errors, every reading, memory, engine, compiler, processor, load, date

and at the end benchmarks.csv (all rows) and benchmarks.html (what to use when, pictures, tables). The same
command goes on after Ctrl-C, level by level; what was begun with another engine, machine or peer is refused.

--size small takes seconds a case, in this process and on one thread: it shows that all works, and its times
and memory are not to be quoted.

examples:
  plica bench run -o figures
  plica bench run assembly filter -o figures --rounds 9
  plica bench run --size small

Exit codes: 0 all that the cases claim was shown, 1 a method stopped or a claim is not so, 2 bad input.
"""

_COMPARE_HELP = """\
Compares two records of a case, or all cases that two directories share. A row is called slower or quicker
only where its readings differ beyond noise: a rank test at 1 % (Mann and Whitney; it takes five readings of
both sides) and medians 3 % apart. "too few": so few readings could not show a change. An error that grew by
more than 1 % is less exact. Where a machine was busy processor times are compared. Different machines are
said, and their times not compared; other cases are refused.

examples:
  plica bench compare before/assembly.json after/assembly.json
  plica bench compare before after

Exit codes: 0 nothing is worse, 1 something is slower or less exact, 2 bad input.
"""


def add_commands(commands: Any) -> None:
    """Add it to the commands of ``plica``."""
    bench = add_command(commands, "bench", None, "error against run time, closed forms and laws", _BENCH_HELP)
    benches = bench.add_subparsers(title="benchmarks", metavar="BENCHMARK", required=True)
    add_command(benches, "list", _list, "cases, methods, and which peers are installed", _LIST_HELP)
    run = add_command(benches, "run", _run, "measure cases, and write the page", _RUN_HELP)
    run.add_argument("cases", metavar="CASE", nargs="*", help="case or family (default: all)")
    run.add_argument("--size", choices=("small", "full"), default="full", help="default: full")
    run.add_argument("--threads", metavar="N", nargs="+", type=whole, help="default: 1 2; of small ones 1")
    run.add_argument("--rounds", metavar="N", type=whole, help="default: 5; of small ones 1")
    run.add_argument(
        "-o", "--output", dest="directory", metavar="DIR", type=Path, help="required for the full size"
    )
    run.add_argument("--anew", action="store_true", help="measure again what DIR has")
    run.add_argument("--quiet", action="store_true", help="no progress, no tables; only what is wrong")
    compare = add_command(benches, "compare", _compare, "two records, noise told from change", _COMPARE_HELP)
    compare.add_argument("before", metavar="A", type=Path, help="record (JSON) or directory of records")
    compare.add_argument("after", metavar="B", type=Path, help="likewise")
    page = add_command(benches, "page", _page, "write the page of a directory anew")
    page.add_argument("directory", metavar="DIR", type=Path, help="where plica bench run wrote")
    bench_contact.add_commands(benches)
    bench_extremes.add_commands(benches)


def _list(options: argparse.Namespace) -> int:
    from plica.bench.families import FAMILIES
    from plica.commands.text import hanging

    for number, family in enumerate(FAMILIES.values()):
        print(("\n" if number else "") + f"{family.name}: {family.title}")
        print(hanging("", family.advice, 2))
        for case in family.cases:
            said = f"{case.does} Reference: {case.reference}. Methods: {_methods(case)}."
            print(hanging(f"  {case.name}", said, 20))
    return 0


def _methods(case: Any) -> str:
    """Their names, those of a long list's beginning; peers that are not installed marked."""
    names = [method.name + ("" if method.installed else " (not installed)") for method in case.methods]
    more = f"; and {len(names) - 6} more" if len(names) > 8 else ""
    return "; ".join(names[:6] if more else names) + more


def _run(options: argparse.Namespace) -> int:
    from plica.bench.families import chosen_cases
    from plica.bench.run import broken_claims

    small = options.size == "small"
    options.rounds = options.rounds or (1 if small else 5)
    options.threads = options.threads or ([1] if small else [1, 2])
    cases = chosen_cases(options.cases)
    if options.directory is None and not small:
        raise InvalidInput("bench run: -o is left out; must name a directory, as a full run is kept.")
    options.goes_on = options.directory is not None
    broken: list[str] = []
    for case in cases:
        record = _measured(case, options)
        if not options.quiet:
            _show(record)
        broken += [f"{case.name}: {said}" for said in broken_claims(case, record)]
    if options.directory is not None:
        from plica.bench.page import write_page

        page = write_page(options.directory)
        if not options.quiet:
            print(f"\npage: {page}")
    for said in broken:
        print(f"plica: {said}", file=sys.stderr)
    return 1 if broken else 0


def _measured(case: Any, options: argparse.Namespace) -> Record:
    """The record of a case, gone on with where the directory has one."""
    from tqdm import tqdm

    from plica.bench.families import family_of
    from plica.bench.record import read, write
    from plica.bench.run import blank, continued, measure
    from plica.storage.files import storage_errors

    record = blank(case, family_of(case.name).name, options.size, options.rounds)
    path = None
    if options.directory is not None:
        with storage_errors(options.directory, "made"):
            options.directory.mkdir(parents=True, exist_ok=True)
        path = options.directory / f"{case.name}.json"
        if path.exists() and not options.anew:
            record = continued(read(path), record, str(path))
    with tqdm(
        unit=" rows", desc=case.name, file=sys.stderr, disable=options.quiet, delay=2, leave=False
    ) as bar:
        return measure(
            case,
            record,
            options.threads,
            keep=lambda made: None if path is None else write(made, path),
            said=lambda row: bar.update(),
        )


def _show(record: Record) -> None:
    from plica.bench.words import as_markdown

    print(f"\n## {record.case}\n\n{as_markdown(record)}", flush=True)


def _compare(options: argparse.Namespace) -> int:
    from plica.bench.compare import compare
    from plica.bench.pairs import pairs

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
    said = f"{worse or 'none'} of {len(changes)} rows {'is' if worse == 1 else 'are'} slower or less exact"
    print(said + (f"; of {unknown} the time cannot be judged." if unknown else "."))
    return 1 if worse else 0


def _page(options: argparse.Namespace) -> int:
    from plica.bench.page import write_page

    print(write_page(options.directory))
    return 0
