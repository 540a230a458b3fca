"""``extremes``: the engine at its limits."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from typing import Any

from benchmarks.harness.output import add_output, put
from plica.commands.arguments import add_command

__all__ = ["COLUMNS", "add_commands"]

COLUMNS = ("subject", "extreme", "reference", "verdict", "error", "allowed", "note")

_HELP = """\
Tests the engine at its limits: Poisson's ratios up to 0.49999, layers 1e8 times as stiff as their neighbours,
slivers, meshes far from the origin or in other units, steps of 0.1 us to 10 ms, lung pressures up to 20
kPa, closed and wide-open folds, a million steps, broken files of every kind, random scenes. Each gets a
verdict:

  right     within the tolerance of a closed form, a second algorithm, or an equivalent scene
  said      less accurate, and a caution says so
  refused   with a clear message, InvalidInput or SolveFailed

or, as a failure: WRONG (without a caution), NaN, CRASH, HANG. docs/records/extremes.json has them all.

examples:
  python -m benchmarks extremes --size small         a quick check in seconds
  python -m benchmarks extremes -o extremes.csv      everything, about a minute
  python -m benchmarks extremes --subjects tissue voice
  python -m benchmarks extremes --only "Poisson"     probes whose name contains this

Exit codes: 0 no failure, 1 at least one failure, 2 bad input.
"""


def add_commands(benches: Any) -> None:
    """Add it to the commands."""
    sub = add_command(
        benches, "extremes", _extremes, "the engine at its limits: right, warned of, or refused", _HELP
    )
    sub.add_argument("--size", choices=("small", "full"), default="full", help="default: full")
    sub.add_argument(
        "--subjects", metavar="NAME", nargs="+", help="tissue, voice, endurance, files; default: all"
    )
    sub.add_argument("--only", metavar="TEXT", default="", help="probes whose name contains it")
    add_output(sub)


def _extremes(options: argparse.Namespace) -> int:
    from benchmarks.extremes.probe import FORBIDDEN
    from benchmarks.extremes.worker import SUBJECTS, verdicts
    from plica.errors import InvalidInput, selected

    subjects = selected(options.subjects, list(SUBJECTS), "benchmarks: --subjects")
    subject_of = {
        probe.name: subject
        for subject in subjects
        for probe in SUBJECTS[subject]
        if options.only in probe.name and (probe.small or options.size == "full")
    }
    probes = [probe for subject in subjects for probe in SUBJECTS[subject] if probe.name in subject_of]
    if not probes:
        raise InvalidInput(f'benchmarks: --only = "{options.only}"; must be part of the name of a probe.')

    def rows() -> Iterator[dict[str, object]]:
        for probe, verdict, seconds in verdicts(probes):
            yield {
                "subject": subject_of[probe.name],
                "extreme": probe.name,
                "reference": probe.reference,
                "verdict": verdict.word,
                "error": "" if verdict.error is None else f"{verdict.error:.1e}",
                "allowed": "" if verdict.allowed is None else f"{verdict.allowed:.0e}",
                "note": verdict.note,
                "s": f"{seconds:.1f}",
            }

    made = put(options, COLUMNS, rows(), len(probes))
    forbidden = [row for row in made if row["verdict"] in FORBIDDEN]
    for row in forbidden:
        print(f"plica: {row['extreme']}: {row['verdict']}: {row['note']}", file=sys.stderr)
    return 1 if forbidden else 0
