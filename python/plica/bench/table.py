"""Rows of figures as a Markdown table, printed as they come, and as CSV."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from tqdm import tqdm

from plica.storage.files import storage_errors
from plica.storage.table import write_rows

__all__ = ["header", "line", "show"]

Row = Mapping[str, object]


def show(
    rows: Iterable[dict[str, object]],
    columns: Sequence[str],
    *,
    total: int,
    csv: Path | None,
    progress: bool,
) -> list[dict[str, object]]:
    """Print rows as they are made, with a bar of `total` runs on standard error, and write them to `csv`.

    What is made before an error or Ctrl-C is written too.
    """
    if csv is not None:
        with storage_errors(csv, "saved"):
            csv.touch()
    made: list[dict[str, object]] = []
    print(header(columns), flush=True)
    bar = tqdm(total=total, unit=" runs", file=sys.stderr, disable=not progress, miniters=1)
    try:
        for row in rows:
            made.append(row)
            bar.clear()
            print(line(row, columns), flush=True)
            bar.update()
    finally:
        bar.close()
        if csv is not None:
            with storage_errors(csv, "saved"):
                write_rows(csv, made)
    return made


def header(columns: Sequence[str]) -> str:
    """The first two lines."""
    return "| " + " | ".join(columns) + " |\n|" + " --- |" * len(columns)


def line(row: Row, columns: Sequence[str]) -> str:
    """One row; a failed one shows its message in the first column that has no value."""
    cells = [_text(row.get(column, "")) for column in columns]
    if "failure" in row:
        cells[next(k for k, column in enumerate(columns) if column not in row)] = str(row["failure"])
    return "| " + " | ".join(cells) + " |"


def _text(value: object) -> str:
    if not isinstance(value, float):
        return str(value)
    if value == 0.0 or value != value:
        return "0" if value == 0.0 else "-"
    return f"{value:.3f}" if 1e-3 <= abs(value) < 1e4 else f"{value:.1e}"
