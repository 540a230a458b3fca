"""Several recordings with one command: a folder of results each, and one table of all."""

from __future__ import annotations

import csv
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from plica.errors import InvalidInput, SolveFailed, StorageFailed

if TYPE_CHECKING:
    from plica.video.analysis import Analysis

__all__ = ["analyse_each", "folders_of"]


def analyse_each(
    sources: Sequence[Path],
    output: Path,
    analysed: Callable[[Path, Path], Analysis],
    *,
    quiet: bool,
    workbook: bool = False,
) -> int:
    """Analyse each recording in a folder of its own, and write the table of all after each.

    One that cannot be analysed has its error in the table, and the others are analysed. Where a command is
    repeated that was stopped, the table of the earlier one stays until this one has as many rows.

    Parameters
    ----------
    sources : Paths
    output : Path
        Folder of their folders and of recordings.csv.
    analysed : function
        The analysis of a recording in a folder.
    quiet : bool
        Print only errors.
    workbook : bool
        Also write the table as recordings.xlsx.

    Returns
    -------
    int
        Exit code: 0, or 2 where one could not be analysed.

    Raises
    ------
    InvalidInput
        Where two recordings have one name; for a workbook without openpyxl.
    """
    from plica.storage.files import storage_errors
    from plica.storage.table import as_cells, write_rows
    from plica.storage.workbook import Sheet, require_openpyxl, write_sheets
    from plica.video.report.table import row_of

    if workbook:
        require_openpyxl()
    rows: list[dict[str, object]] = []
    folders = folders_of(sources, output)
    table, failed = output / "recordings.csv", 0
    with storage_errors(output):
        output.mkdir(parents=True, exist_ok=True)
        known = _rows_in(table)
    for number, (source, folder) in enumerate(folders.items(), 1):
        if not quiet:
            print(f"{number} of {len(folders)}: {source}", flush=True)
        row: dict[str, object] = {"recording": str(source)}
        try:
            row |= row_of(analysed(source, folder))
        except (InvalidInput, SolveFailed, StorageFailed) as error:
            row["error"] = str(error)
            failed += 1
            print(f"plica: {source}: {error}", file=sys.stderr)
        rows.append(row)
        if len(rows) < min(known, len(folders)):
            continue
        write_rows(table, rows)  # after each: what was found is never lost
        if workbook:
            write_sheets(table.with_suffix(".xlsx"), {"Recordings": Sheet(*as_cells(rows))})
    if not quiet:
        print(f"written: {table}: {len(rows) - failed} recordings" + (f", {failed} failed" if failed else ""))
    return 2 if failed else 0


def _rows_in(table: Path) -> int:
    """Rows of a table written before; 0 where there is none."""
    if not table.is_file():
        return 0
    with table.open(encoding="utf-8", errors="replace", newline="") as file:
        return sum(1 for _ in csv.reader(file)) - 1


def folders_of(sources: Sequence[Path], output: Path) -> dict[Path, Path]:
    """The folder of each recording's results: of its name without its suffix, or with it where another one
    has the same. InvalidInput where two have one name."""
    stems = [source.stem for source in sources]
    names = [source.name if stems.count(source.stem) > 1 else source.stem for source in sources]
    for name, source in zip(names, sources, strict=True):
        if names.count(name) > 1:
            raise InvalidInput(
                f"Video: {source}; must be the only recording called {name}, as its results lie in a folder "
                "of that name. Rename one, or analyse it by itself."
            )
    return {source: output / name for name, source in zip(names, sources, strict=True)}
