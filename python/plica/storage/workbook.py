"""Tables as the sheets of a workbook (.xlsx)."""

from __future__ import annotations

import io
import math
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from plica.errors import InvalidInput, library
from plica.storage.files import replaced, storage_errors

__all__ = ["Sheet", "require_openpyxl", "write_sheets"]

_MOST_ROWS, _MOST_COLUMNS = 2**20, 2**14  # of the format
_NARROWEST, _OF_NUMBERS, _WIDEST = 8, 12, 60  # characters of a column
_LOOKED_AT = 100  # rows that tell how wide a column is
_NO_TEXT = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\ud800-\udfff\ufffe\uffff]")  # no characters of XML


class Sheet(NamedTuple):
    """Headings, and rows of as many cells: numbers, texts; what is missing is None, "" or not a number."""

    headings: Sequence[str]
    rows: Sequence[Sequence[object]]


def require_openpyxl() -> Any:
    """The library that writes workbooks.

    Raises
    ------
    InvalidInput
        If it is not installed; call this before a computation.
    """
    return library("openpyxl", "xlsx", "A workbook (--xlsx)")


def write_sheets(path: Path, sheets: Mapping[str, Sheet]) -> Path:
    """Write sheets by name, replacing the file atomically, and return the path.

    Numbers are numbers, what is missing is an empty cell, a text is never a formula. The headings are bold
    and stay in view.

    Raises
    ------
    InvalidInput
        Without openpyxl, and where a sheet has more rows or columns than the format has.
    StorageFailed
        Where the file cannot be written.
    """
    library = require_openpyxl()
    for name, sheet in sheets.items():
        size = len(sheet.rows) + 1, len(sheet.headings)
        if size[0] > _MOST_ROWS or size[1] > _MOST_COLUMNS:
            raise InvalidInput(
                f"Workbook: sheet {name} of {path} has {size[0]} rows and {size[1]} columns; must have at "
                f"most {_MOST_ROWS} and {_MOST_COLUMNS}. Take the CSV file."
            )
    whole = io.BytesIO()
    with storage_errors(path):  # sheets are drafts of their own in the system's folder for these
        book = library.Workbook(write_only=True)
        for name, sheet in sheets.items():
            _fill(library, book.create_sheet(name), sheet)
        book.save(whole)

    def fill(draft: Path) -> None:
        draft.write_bytes(whole.getbuffer())

    replaced(path, fill)
    return path


def _fill(library: Any, page: Any, sheet: Sheet) -> None:
    from openpyxl.styles import Alignment, Font
    from openpyxl.utils import get_column_letter

    bold, wrapped = Font(bold=True), Alignment(wrap_text=True, vertical="top")

    def text(value: str) -> Any:
        cell = library.cell.WriteOnlyCell(page, _NO_TEXT.sub("?", value))
        cell.data_type = "s"  # also "=1+1"
        if len(value) > _WIDEST:
            cell.alignment = wrapped
        return cell

    page.freeze_panes = "A2"
    for k, heading in enumerate(sheet.headings, 1):
        widths = [_width(row[k - 1]) for row in sheet.rows[:_LOOKED_AT]]
        wide = min(max([_NARROWEST, len(heading), *widths]), _WIDEST) + 2
        page.column_dimensions[get_column_letter(k)].width = wide
    headings = [text(heading) for heading in sheet.headings]
    for cell in headings:
        cell.font = bold
    page.append(headings)
    for row in sheet.rows:
        values = map(_plain, row)
        page.append([text(value) if isinstance(value, str) else value for value in values])


def _width(value: object) -> int:
    return len(value) if isinstance(value, str) else _OF_NUMBERS


def _plain(value: object) -> object:
    """A value as the format has it: None where it is missing, or no finite number."""
    value = value.item() if isinstance(value, np.generic) else value
    missing = value == "" or (isinstance(value, float) and not math.isfinite(value))
    return None if missing else value
