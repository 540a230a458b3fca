"""An analysis as a workbook (.xlsx): its light, its measures, and its tables, a sheet each."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from plica.storage.workbook import Sheet, write_sheets
from plica.video.analysis import Analysis
from plica.video.light import light_of
from plica.video.tables import Column, about, tables_of

__all__ = ["write_workbook"]


def write_workbook(found: Analysis) -> Path:
    """Write recording.xlsx beside the results: the sheets Light, Measures, Cycles, Folds and Waveforms,
    and Signals where there are some beside the picture.

    The light has each of its reasons in a row, and below them what was analysed. The others have the columns
    and the numbers of the CSV files; what is missing is an empty cell.

    Raises
    ------
    InvalidInput
        Without openpyxl (``pip install 'plica[xlsx]'``); for more frames than a sheet has rows.
    StorageFailed
        Where the file cannot be written.
    """
    light = light_of(found)
    judged: list[tuple[str, object]] = [("light", light.shown)]
    judged += [("reason", reason) for reason in light.reasons]
    sheets = {"Light": Sheet(("what", "value"), [*judged, *about(found).items()])}
    sheets |= {name.capitalize(): _sheet(table) for name, table in tables_of(found).items()}
    return write_sheets(found.directory / "recording.xlsx", sheets)


def _sheet(table: Sequence[Column]) -> Sheet:
    rows = list(zip(*(column.values.tolist() for column in table), strict=True))
    return Sheet([column.heading for column in table], rows)
