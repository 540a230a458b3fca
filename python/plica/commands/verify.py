"""``plica verify``: verify this installation against closed forms, with value, reference, error and
tolerance."""

from __future__ import annotations

import argparse
import json
import sys
import time
from pathlib import Path
from typing import Any

from plica.commands.arguments import add_command, add_threads

__all__ = ["add_commands"]

_HELP = """\
Verifies this installation on this machine: every row compares a value with a closed form, a second algorithm
or a published number, with the error, the tolerance and its reason. It takes about half a minute.

Subjects:
  tissue          constant strains, rigid motion, moduli, creep, natural frequencies
  dynamics        time schemes, energy, momentum, identical bits for any number of threads
  airflow         Bernoulli and viscous flow, the work of pressures
  contact         impacts, contact at rest, conservation laws in collisions
  video           motion between frames, the glottis, pitch, quotients and phases
  identification  filter, smoother, likelihood, gradient, recovery of a known tissue

An error is relative to the reference ("rel.") or in the unit of the row. --json prints an array with one
object per row: name, subject, case, quantity, unit, value, reference, error, tolerance, error_of
("reference" or "unit"), because (reason of the tolerance), source (of the reference), failure, pass. A case
that fails to run has a row without numbers.

examples:
  plica verify
  plica verify --subject contact airflow
  plica verify --json > rows.json
  plica verify -o proof            also writes proof/verification.html, .json, .csv and .md
  plica verify --list              list the cases without running them

Exit codes: 0 all rows pass, 1 a row fails, 2 bad input.
"""


def add_commands(commands: Any) -> None:
    """Add it to the commands of ``plica``."""
    part = add_command(commands, "verify", _verify, "verify this installation against closed forms", _HELP)
    part.add_argument("--subject", metavar="NAME", nargs="+", help="default: all")
    part.add_argument("--list", action="store_true", help="list what each case verifies, without running it")
    part.add_argument("--json", action="store_true", help="print the rows as JSON instead of the table")
    part.add_argument(
        "-o", "--output", dest="directory", metavar="DIR", type=Path, help="also store the report"
    )
    part.add_argument("--quiet", action="store_true", help="only failures, and the last line")
    add_threads(part)


def _verify(options: argparse.Namespace) -> int:
    from tqdm import tqdm

    import plica
    from plica.errors import selected
    from plica.report.installation import this_installation
    from plica.verify.subjects import SUBJECTS, cases, verify
    from plica.verify.text import case_lines, conclusion

    subjects = selected(options.subject, list(SUBJECTS), "verify: --subject")
    if options.list:
        return _list(subjects, as_json=options.json)
    plica.set_threads(options.threads)
    installation, began = this_installation(), time.perf_counter()
    total = sum(len(cases(subject)) for subject in subjects)
    made, subject, printed = [], "", False
    with tqdm(
        total=total, unit=" cases", file=sys.stderr, disable=options.quiet, delay=2, leave=False
    ) as bar:
        for case, rows in verify(subjects):
            made.append((case, rows))
            bar.update()
            shown = [row for row in rows if not (options.quiet and row.passed)]
            if options.json or not shown:
                continue
            bar.clear()
            if rows[0].subject != subject:
                subject = rows[0].subject
                print(f"\n{subject.upper()}" if printed else subject.upper())
                printed = True
            print("\n" + "\n".join(case_lines(case, shown)), flush=True)
    seconds = time.perf_counter() - began
    rows = [row for _, theirs in made for row in theirs]
    if options.json:
        print(json.dumps([row.as_json() for row in rows], indent=2, allow_nan=False))
    else:
        above = "\n" if printed else ""
        print(f"{above}{conclusion(rows, seconds)}" + ("" if options.quiet else f"\n{installation}"))
    if options.directory is not None:
        from plica.verify.files import write

        page = write(made, installation, seconds, options.directory)
        print(f"report: {page}", file=sys.stderr if options.json else sys.stdout)
    return 0 if all(row.passed for row in rows) else 1


def _list(subjects: list[str], *, as_json: bool) -> int:
    from plica.commands.text import hanging
    from plica.verify.subjects import SUBJECTS, cases

    if as_json:
        fields = ("name", "proves", "source")
        listed = [
            {"subject": name} | {field: getattr(case, field) for field in fields}
            for name in subjects
            for case in cases(name)
        ]
        print(json.dumps(listed, indent=2))
        return 0
    for number, name in enumerate(subjects):
        print(("\n" if number else "") + f"{name}: {SUBJECTS[name]}")
        for case in cases(name):
            print(hanging(f"  {case.name}", case.proves, 26))
    return 0
