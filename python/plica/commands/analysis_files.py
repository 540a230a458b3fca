"""The files that ``plica video``, ``glottis`` and ``modes`` write of an analysis, as its options ask."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from plica.commands.recordings import is_newer
from plica.errors import InvalidInput

if TYPE_CHECKING:
    from plica.video.analysis import Analysis

__all__ = ["add_dicom", "require_libraries", "untaken", "write_files"]


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
    dicom = report and options.dicom
    pdf = dicom or (report and options.pdf)
    asked = {
        "light.json": True,
        page.name: report,
        "report.pdf": pdf,
        "report.dcm": dicom,
        "area.wav": options.praat,
        "recording.xlsx": options.xlsx,
        "recording.mat": options.matlab,
    }
    wanted = [found.directory / name for name, is_asked in asked.items() if is_asked]
    if not again and is_newer(wanted, found.path):
        return page
    write_tables(found)
    if options.xlsx:
        write_workbook(found)
    if options.matlab:
        write_matlab(found)
    if report:
        with figures_shown(not options.quiet):
            page = write_report(found)
        if pdf:
            page = pdf_of(page)
        if dicom:
            write_dicom(found, page)
    if options.praat:
        write_praat(found)
    return page


def untaken(found: Analysis) -> list[str]:
    """Cautions of what the recording's file states and what is neither taken nor given, with what to give."""
    if found.camera is None:
        return []
    return [
        f"{said}. Give --{name.replace('_', '-')}."
        for name, said in found.camera.unused.items()
        if getattr(found.settings, name) is None
    ]
