"""The files that ``plica video``, ``glottis`` and ``modes`` write of an analysis, as its options ask."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from plica.errors import InvalidInput

if TYPE_CHECKING:
    from plica.video.analysis import Analysis

__all__ = ["add_dicom", "outdated", "require_libraries", "untaken", "write_files"]

_ASKED_FOR = {
    "report.pdf": "pdf",
    "report.dcm": "dicom",
    "area.wav": "praat",
    "recording.xlsx": "xlsx",
    "recording.mat": "matlab",
}
"""Files that an option writes, and the option: without it they are not written again."""

_OF_REPORT = ("report.pdf", "report.dcm")


def add_dicom(part: argparse.ArgumentParser) -> None:
    """The option --dicom."""
    part.add_argument(
        "--dicom",
        action="store_true",
        help="also report.dcm, the report for an archive (pip install 'plica[dicom,pdf]')",
    )


def require_libraries(options: argparse.Namespace, *, report: bool) -> None:
    """InvalidInput where a library is missing that a file needs: before anything is computed."""
    from plica.report.page import require_pdf
    from plica.storage.workbook import require_openpyxl
    from plica.video.dicom_report import require_pydicom

    if report and options.dicom:
        require_pydicom()
        try:
            require_pdf()
        except InvalidInput as error:
            raise InvalidInput(f"DICOM: --dicom writes report.pdf too. {error}") from None
    if report and options.pdf:
        require_pdf()
    if options.xlsx:
        require_openpyxl()


def write_files(found: Analysis, options: argparse.Namespace, *, report: bool, again: bool) -> Path:
    """Write the tables, the `report` and what the options ask for; returns the page, or its PDF.

    Unless `again` it leaves what is there where all of it is newer than the results.
    """
    from plica.report.page import pdf_of
    from plica.report.progress import figures_shown
    from plica.video.dicom_report import write_dicom
    from plica.video.matlab import write_matlab
    from plica.video.praat import write_praat
    from plica.video.report.page import write_report
    from plica.video.tables import write_tables
    from plica.video.workbook import write_workbook

    page = found.directory / "report.html"
    # A command that writes no report has no option of its files.
    possible = [name for name in _ASKED_FOR if report or name not in _OF_REPORT]
    asked = [name for name in possible if getattr(options, _ASKED_FOR[name])]
    if "report.dcm" in asked:
        asked.append("report.pdf")
    wanted = [found.directory / name for name in ("light.json", *([page.name] if report else []), *asked)]
    if not again and _are_newer(wanted, found.path):
        return page
    write_tables(found)
    if "recording.xlsx" in asked:
        write_workbook(found)
    if "recording.mat" in asked:
        write_matlab(found)
    if report:
        with figures_shown(not options.quiet):
            page = write_report(found)
        if "report.pdf" in asked:
            page = pdf_of(page)
        if "report.dcm" in asked:
            write_dicom(found, page)
    if "area.wav" in asked:
        write_praat(found)
    return page


def outdated(found: Analysis) -> list[str]:
    """A caution of files with figures of earlier settings or masks: of those that were asked for, the ones
    older than the results."""
    there = [name for name in _ASKED_FOR if (found.directory / name).exists()]
    old = [name for name in there if not _are_newer([found.directory / name], found.path)]
    again = " ".join(f"--{_ASKED_FOR[name]}" for name in old)
    return [f"{', '.join(old)} in {found.directory} of earlier settings; {again} writes anew."] if old else []


def _are_newer(files: Sequence[Path], results: Path) -> bool:
    """Whether all of these files are there and were written after the results."""
    written = results.stat().st_mtime_ns
    return all(file.exists() and file.stat().st_mtime_ns > written for file in files)


def untaken(found: Analysis) -> list[str]:
    """Cautions of what the recording's file states and what is neither taken nor given, with what to give."""
    if found.camera is None:
        return []
    return [
        f"{said}. Give --{name.replace('_', '-')}."
        for name, said in found.camera.unused.items()
        if getattr(found.settings, name) is None
    ]
