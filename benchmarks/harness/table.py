"""Tables of rows: printed in Markdown as they are made, and kept as CSV."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path

from tqdm import tqdm

from plica.storage.files import storage_errors
from plica.storage.table import markdown_head, markdown_row, write_rows

__all__ = ["Row", "as_text", "cells", "kept", "markdown", "show"]

Row = Mapping[str, object]


def as_text(cell: object) -> str:
    """A cell as it is read: a float in three decimals or two digits, a dash for what is not a number."""
    if cell is None or cell != cell:
        return "-"
    if not isinstance(cell, float) or cell == 0.0:
        return "0" if cell == 0.0 and isinstance(cell, float) else str(cell)
    return f"{cell:.3f}" if 1e-3 <= abs(cell) < 1e4 else f"{cell:.1e}"


def markdown(columns: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """The whole table."""
    return "\n".join([markdown_head(columns), *(markdown_row(map(as_text, row)) for row in rows)])


def show(
    columns: Sequence[str], rows: Iterable[Sequence[object]], total: int | None = None
) -> list[list[object]]:
    """Print rows as they are made, with a bar of `total` runs on standard error; returns them.

    Raises ValueError for a row with more or fewer cells than columns.
    """
    made: list[list[object]] = []
    print(markdown_head(columns), flush=True)
    with tqdm(total=total, unit=" runs", file=sys.stderr, disable=total is None, miniters=1) as bar:
        for row in rows:
            made.append(list(row))
            if len(row) != len(columns):
                raise ValueError(f"table: row {made[-1]} has {len(row)} cells; must be {len(columns)}.")
            bar.clear()
            print(markdown_row(map(as_text, row)), flush=True)
            bar.update()
    return made


def cells(row: Row, columns: Sequence[str]) -> list[object]:
    """Of a row with names; one with a "failure" has its message in the first column without a value."""
    found = [row.get(column, "") for column in columns]
    if "failure" in row:
        found[next(k for k, column in enumerate(columns) if column not in row)] = row["failure"]
    return found


def kept(rows: Iterable[Row], csv: Path | None) -> Iterator[Row]:
    """The rows as they are made, then in the file: also what was made before an error or Ctrl-C.

    Raises StorageFailed before the first one where the file cannot be written.
    """
    if csv is None:
        yield from rows
        return
    with storage_errors(csv, "saved"):
        csv.touch()
    made: list[Row] = []
    try:
        for row in rows:
            made.append(row)
            yield row
    finally:
        with storage_errors(csv, "saved"):
            write_rows(csv, made)
