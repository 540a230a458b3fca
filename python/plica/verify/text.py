"""The rows of a verification as text for a terminal and as Markdown."""

from __future__ import annotations

from collections.abc import Sequence

from plica.report.installation import Installation
from plica.storage.table import markdown_head, markdown_row
from plica.verify.case import Case, Row

__all__ = ["COLUMNS", "as_markdown", "case_lines", "cells", "conclusion", "shown", "within"]

Results = Sequence[tuple[Case, Sequence[Row]]]


def shown(number: float | None, digits: int = 6) -> str:
    """A number, or a dash."""
    return "-" if number is None else f"{number:.{digits}g}"


def within(row: Row) -> tuple[str, str]:
    """Error and tolerance with their unit, none for a pure number."""
    unit = {"reference": " rel.", "unit": f" {row.unit}" if row.unit != "1" else ""}.get(row.error_of, "")
    return shown(row.error, 2) + unit, shown(row.tolerance, 2) + unit


def case_lines(case: Case, rows: Sequence[Row]) -> list[str]:
    """What a case proves, followed by its rows."""
    lines = [f"{case.name}: {case.proves}"]
    for row in rows:
        if row.failure and row.value is None:
            lines.append(f"  FAIL  {row.quantity}: {row.failure}")
            continue
        error, tolerance = within(row)
        unit = f" {row.unit}" if row.unit != "1" else ""
        mark = "pass" if row.passed else "FAIL"
        value, reference = (f"{shown(number)}{unit}" for number in (row.value, row.reference))
        lines.append(
            f"  {mark}  {value:<22} of {reference:<22} error {error:<14} <= {tolerance:<14} {row.quantity}"
        )
    return lines


def conclusion(rows: Sequence[Row], seconds: float) -> str:
    """Number of rows that pass, and names of those that fail."""
    failed = [row.name for row in rows if not row.passed]
    text = f"{len(rows) - len(failed)} of {len(rows)} pass, in {seconds:.0f} s."
    return text if not failed else f"{text} Failed: {', '.join(failed)}."


COLUMNS = ("row", "quantity", "value", "reference", "error", "tolerance", "pass")


def cells(row: Row) -> tuple[str, ...]:
    """Of a row, in the order of COLUMNS."""
    unit = f" {row.unit}" if row.unit != "1" else ""
    mark = "yes" if row.passed else f"**no** {row.failure}".strip()
    numbers = (shown(row.value) + unit, shown(row.reference) + unit)
    return (row.name, row.quantity, *numbers, *within(row), mark)


def as_markdown(results: Results, installation: Installation) -> str:
    """A table for each subject, below the engine's version."""
    lines = [f"Made by {installation}."]
    subject = ""
    for _, rows in results:
        for row in rows:
            if row.subject != subject:
                subject = row.subject
                lines += ["", f"### {subject.capitalize()}", "", markdown_head(COLUMNS)]
            lines.append(markdown_row(cells(row)))
    return "\n".join(lines) + "\n"
