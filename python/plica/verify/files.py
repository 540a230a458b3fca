"""A verification as files: JSON, CSV, Markdown, and one HTML page that fetches nothing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

from plica.report.installation import Installation
from plica.report.page import render
from plica.storage.files import storage_errors, write_text
from plica.storage.json_file import write_json
from plica.storage.table import write_rows
from plica.verify.case import Case, Row
from plica.verify.subjects import SUBJECTS
from plica.verify.text import as_markdown, conclusion, shown, within

__all__ = ["write"]

_LABELS = {
    "version": "Plica",
    "commit": "commit",
    "compiler": "compiler",
    "backend": "factorisation",
    "python": "Python",
    "processor": "processor",
    "system": "system",
    "threads": "threads",
    "date": "date",
}


def write(
    results: Sequence[tuple[Case, Sequence[Row]]], installation: Installation, seconds: float, directory: Path
) -> Path:
    """Write verification.json, .csv, .md and .html to the directory; returns the path of the page."""
    rows = [row for _, theirs in results for row in theirs]
    with storage_errors(directory, "made"):
        directory.mkdir(parents=True, exist_ok=True)
    write_json([row.as_json() for row in rows], directory / "verification.json")
    write_rows(directory / "verification.csv", [row.as_json() for row in rows])
    write_text(as_markdown(results, installation), directory / "verification.md")
    page = render(
        "verify/report.html.j2",
        subjects=[
            (name, topic, _of(name, results)) for name, topic in SUBJECTS.items() if _of(name, results)
        ],
        conclusion=conclusion(rows, seconds),
        good=all(row.passed for row in rows),
        installation=[(_LABELS[name], value or "not known") for name, value in asdict(installation).items()],
        shown=shown,
        within=within,
    )
    return write_text(page, directory / "verification.html")


def _of(subject: str, results: Sequence[tuple[Case, Sequence[Row]]]) -> list[tuple[Case, Sequence[Row]]]:
    return [(case, rows) for case, rows in results if rows[0].subject == subject]
