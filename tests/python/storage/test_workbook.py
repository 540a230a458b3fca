"""Sheets of a workbook, read back."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import openpyxl
import pytest

import plica
from plica.storage import workbook
from plica.storage.workbook import Sheet, write_sheets


def test_numbers_are_numbers_and_what_is_missing_is_an_empty_cell(tmp_path: Path) -> None:
    row = (1, 2.5, np.float64(-3e-7), np.int64(4), True, "word")
    missing = (None, "", np.nan, float("inf"), np.float64("nan"), "x")
    path = write_sheets(tmp_path / "a.xlsx", {"One": Sheet("abcdef", [row, missing]), "Two": Sheet("a", [])})
    book = openpyxl.load_workbook(path)
    assert book.sheetnames == ["One", "Two"]
    assert list(book["One"].values) == [tuple("abcdef"), row, (None,) * 5 + ("x",)]
    assert list(book["Two"].values) == [("a",)]
    assert [file.name for file in tmp_path.iterdir()] == ["a.xlsx"]


def test_a_text_is_never_a_formula_and_has_no_character_that_xml_has_not(tmp_path: Path) -> None:
    texts = ["=1+1", "=HYPERLINK(0)", "#N/A", "1", "a\x07b", "\udce4", "µ < ä & \U0001f600"]
    path = write_sheets(tmp_path / "a.xlsx", {"One": Sheet(["=2"], [[text] for text in texts])})
    cells = [row[0] for row in openpyxl.load_workbook(path)["One"].rows]
    assert [cell.value for cell in cells] == ["=2", *texts[:4], "a?b", "?", texts[-1]]
    assert {cell.data_type for cell in cells} == {"s"}


def test_headings_are_bold_stay_in_view_and_fit(tmp_path: Path) -> None:
    headings = ["a", "a heading of some length (px^2)", "words"]
    path = write_sheets(tmp_path / "a.xlsx", {"One": Sheet(headings, [[1.0, 2.0, "x" * 200]])})
    sheet = openpyxl.load_workbook(path)["One"]
    assert sheet.freeze_panes == "A2"
    assert all(cell.font.bold for cell in sheet[1])
    assert not any(cell.font.bold for cell in sheet[2])
    assert sheet["C2"].alignment.wrap_text
    narrow, fitting, wide = (sheet.column_dimensions[letter].width for letter in "ABC")
    assert 8 <= narrow <= 20
    assert fitting >= len(headings[1])
    assert 50 <= wide <= 80


def test_more_rows_than_the_format_has_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(workbook, "_MOST_ROWS", 3)
    write_sheets(tmp_path / "a.xlsx", {"One": Sheet("a", [[1], [2]])})
    with pytest.raises(plica.InvalidInput, match=r"sheet One of .*b.xlsx has 4 rows and 1 columns; must"):
        write_sheets(tmp_path / "b.xlsx", {"One": Sheet("a", [[1], [2], [3]])})
    assert [file.name for file in tmp_path.iterdir()] == ["a.xlsx"]


def test_a_file_that_cannot_be_written_is_named_and_the_one_before_stays(tmp_path: Path) -> None:
    path = write_sheets(tmp_path / "a.xlsx", {"One": Sheet("a", [[1]])})
    with pytest.raises(plica.StorageFailed, match=r"none/a\.xlsx: cannot be written: No such file"):
        write_sheets(tmp_path / "none" / "a.xlsx", {"One": Sheet("a", [[1]])})
    before = path.read_bytes()
    (tmp_path / "a.xlsx.part").mkdir()
    with pytest.raises(plica.StorageFailed, match=r"a\.xlsx: cannot be written: Is a directory"):
        write_sheets(path, {"One": Sheet("a", [[2]])})
    assert path.read_bytes() == before


def test_without_its_library_one_sentence_says_how_to_install_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "openpyxl", None)
    with pytest.raises(plica.InvalidInput, match=r"openpyxl, .*; must be: pip install 'plica\[xlsx\]'"):
        write_sheets(tmp_path / "a.xlsx", {"One": Sheet("a", [[1]])})
    assert list(tmp_path.iterdir()) == []
