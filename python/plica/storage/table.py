"""Tables as CSV files and as Markdown."""

from __future__ import annotations

import csv
import re
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plica.storage.files import replaced

__all__ = ["as_cells", "heading", "markdown_head", "markdown_row", "write_cells", "write_rows", "write_table"]


def heading(name: str, unit: str) -> str:
    """The heading of a column: the name with its unit, ``flow (m^3/s)``; without a unit for pure numbers."""
    return f"{name} ({unit})" if unit not in ("", "1") else name


def write_table(
    path: Path, columns: Mapping[str, NDArray[Any]], comments: Mapping[str, str] | None = None
) -> None:
    """Write columns (k) by heading as comma-separated values; NaN is an empty cell.

    `comments` are written first, one line each: ``# label: before``. The file is replaced atomically. Numbers
    are read back to the same bits.
    """

    def fill(draft: Path) -> None:
        with draft.open("w", newline="", encoding="utf-8") as out:
            out.writelines(f"# {name}: {text}\r\n" for name, text in (comments or {}).items())
            rows = csv.writer(out)
            rows.writerow(columns)
            rows.writerows(zip(*(_cells(values) for values in columns.values()), strict=True))

    replaced(path, fill)


def write_rows(path: Path, rows: Sequence[Mapping[str, object]]) -> None:
    """Write rows, a column for every name that any of them has. The file is replaced atomically."""
    write_cells(path, *as_cells(rows))


def as_cells(rows: Sequence[Mapping[str, object]]) -> tuple[list[str], list[list[object]]]:
    """The names that any row has, and each row's cells under them; "" where it has none."""
    columns = list(dict.fromkeys(name for row in rows for name in row))
    return columns, [[row.get(name, "") for name in columns] for row in rows]


def write_cells(path: Path, columns: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    """Write rows of as many cells as there are columns, whose names may recur; replaced atomically."""

    def fill(draft: Path) -> None:
        with draft.open("w", newline="", encoding="utf-8") as out:
            csv.writer(out).writerows([columns, *rows])

    replaced(path, fill)


def _cells(values: NDArray[Any]) -> list[object]:
    if values.dtype.kind == "f" and not np.isnan(values).any():
        return list(values.tolist())
    return ["" if value != value else value for value in values.tolist()]


def markdown_head(columns: Iterable[str]) -> str:
    """The first two lines of a table in Markdown."""
    texts = list(columns)
    return f"{markdown_row(texts)}\n|{' --- |' * len(texts)}"


def markdown_row(cells: Iterable[str]) -> str:
    """A line of a table in Markdown."""
    texts = (re.sub(r"(?<!\\)\|", r"\|", text) for text in cells)
    return f"| {' | '.join(texts)} |"
