"""Where commands put their tables: on the terminal, in a CSV file, in a record."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

from benchmarks.harness.record import this_environment
from benchmarks.harness.study import keep
from benchmarks.harness.table import Row, cells, kept, show

__all__ = ["add_output", "put"]


def add_output(command: Any) -> None:
    """The options -o, --record and --quiet."""
    command.add_argument(
        "-o", "--output", dest="csv", metavar="FILE", type=Path, help="also write all values as CSV"
    )
    command.add_argument(
        "--record",
        metavar="NAME",
        help="also keep the table as docs/records/NAME.json (of committed sources)",
    )
    command.add_argument("--quiet", action="store_true", help="no progress")


def put(
    options: argparse.Namespace,
    columns: Sequence[str],
    rows: Iterable[Row],
    total: int,
    said: Callable[[Sequence[dict[str, object]]], str] = lambda rows: "",
) -> list[dict[str, object]]:
    """Print the rows as they are made, and a sentence about them, and keep them as the options ask."""
    environment = this_environment({})
    made: list[dict[str, object]] = []

    def shown() -> Iterable[list[object]]:
        for row in kept(rows, options.csv):
            made.append(dict(row))
            yield cells(row, columns)

    table = show(columns, shown(), None if options.quiet else total)
    sentence = said(made)
    print(f"\n{sentence}" if sentence else "")
    if options.record is not None:
        keep(options.record, columns, table, sentence, environment)
    return made
