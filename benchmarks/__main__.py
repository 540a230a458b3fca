"""``python -m benchmarks``: error against run time, and the engine against closed forms and at its limits."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

from benchmarks.contact import commands as contact
from benchmarks.extremes import commands as extremes
from benchmarks.harness import commands as harness
from benchmarks.harness import verification
from plica.commands.arguments import Parser
from plica.commands.main import execute

__all__ = ["main", "parser"]

_HELP = """\
Error against run time of the installed plica, compared with other packages that are installed: how much
accuracy a longer run time gives, and which methods are never the best choice. To be run in the sources.

examples:
  python -m benchmarks list                          the cases, and which peers are installed
  python -m benchmarks run -o figures                all cases, 40 minutes; writes figures/benchmarks.html
  python -m benchmarks run assembly --size small     a quick check in seconds; times are not meaningful
  python -m benchmarks compare before after          what became slower, faster or less accurate in between
  python -m benchmarks page figures                  write the page again
  python -m benchmarks tables                        the tables of all records, in build/tables

More detailed tables of one subject:
  python -m benchmarks impact --problems R3 --elements 50
  python -m benchmarks free --steps 2000 --contacts multipliers penalty
  python -m benchmarks extremes --size small
  python -m benchmarks verification

Compare only rows that were measured alternately on an idle machine; times of other machines or days differ.
"""


def parser() -> argparse.ArgumentParser:
    """Of all commands."""
    made = Parser(
        "python -m benchmarks", description=_HELP, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    commands = made.add_subparsers(title="commands", metavar="COMMAND", required=True)
    for part in (harness, contact, extremes, verification):
        part.add_commands(commands)
    return made


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; returns its exit code."""
    typed = sys.argv[1:] if arguments is None else list(arguments)
    return execute(parser().parse_args(typed), typed)


if __name__ == "__main__":
    sys.exit(main())
