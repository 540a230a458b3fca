"""The report of an analysis as a DICOM object: the PDF, in the study of the recording (Encapsulated PDF)."""

from __future__ import annotations

import copy
import hashlib
import warnings
from pathlib import Path
from typing import Any

from plica._engine import build_info
from plica.errors import library
from plica.storage.files import replaced
from plica.video.analysis import Analysis
from plica.video.errors import VideoError
from plica.video.files.dicom_file import dicom_errors, is_dicom, read_dataset
from plica.video.light import light_of

__all__ = ["require_pydicom", "write_dicom"]

_TITLE = {"CodeValue": "18748-4", "CodingSchemeDesignator": "LN", "CodeMeaning": "Diagnostic Imaging Report"}
"""Of LOINC, in the standard's context group of document titles (CID 7020)."""

_ALWAYS = (
    "PatientName",
    "PatientID",
    "PatientBirthDate",
    "PatientSex",
    "StudyDate",
    "StudyTime",
    "ReferringPhysicianName",
    "StudyID",
    "AccessionNumber",
)
"""Of patient and study, type 2: there, empty where they are not known."""

_IF_KNOWN = (
    "TypeOfPatientID",
    "IssuerOfPatientID",
    "IssuerOfPatientIDQualifiersSequence",
    "PatientIdentityRemoved",
    "DeidentificationMethod",
    "DeidentificationMethodCodeSequence",
    "PatientAge",
    "PatientSize",
    "PatientWeight",
    "StudyDescription",
    "IssuerOfAccessionNumberSequence",
    "TimezoneOffsetFromUTC",
)
"""Likewise, type 3."""


def require_pydicom() -> Any:
    """The library that writes DICOM.

    Raises
    ------
    InvalidInput
        If it is not installed; call this before a computation.
    """
    return library("pydicom", "dicom,pdf", "A report for an archive (--dicom)")


def write_dicom(found: Analysis, pdf: Path) -> Path:
    """Write report.dcm beside the report's `pdf`; returns its path.

    Of a recording in DICOM it has the patient and the study, and names the recording as its source, so that
    an archive files it there. Of another recording they are empty, and the study is its own: give it the
    patient in the archive. Its UIDs come from the content: the same report is the same object.

    Raises
    ------
    InvalidInput
        Without pydicom (``pip install 'plica[dicom,pdf]'``).
    VideoError
        Where the recording is not there any more, or states no study.
    StorageFailed
        Where the file cannot be written.
    """
    require_pydicom()
    content = pdf.read_bytes()
    recording = _recording(found.source)
    with dicom_errors(f"{found.source.name} cannot be read as DICOM"):
        report = _report(found, content, recording)
    path = found.directory / "report.dcm"

    def fill(draft: Path) -> None:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of patient and study, which are as the recording has them
            report.save_as(draft, enforce_file_format=True)

    replaced(path, fill)
    return path


def _recording(source: Path) -> Any | None:
    """The attributes of a recording in DICOM; None of another kind."""
    if not source.exists():
        raise VideoError(
            f"DICOM: the recording {source} is not there; must be, as it says whose study the report belongs "
            "to. Put it back."
        )
    if source.is_dir() or not is_dicom(source):
        return None
    found = read_dataset(source)
    for keyword in ("StudyInstanceUID", "SOPClassUID", "SOPInstanceUID"):
        if not found.get(keyword):
            raise VideoError(
                f"DICOM: {source.name} has no {keyword}; must have it, as the report goes into its study. "
                "Export it again."
            )
    return found


def _report(found: Analysis, content: bytes, recording: Any | None) -> Any:
    from pydicom.dataset import Dataset, FileMetaDataset
    from pydicom.uid import EncapsulatedPDFStorage, ExplicitVRLittleEndian

    report = Dataset()
    report.file_meta = FileMetaDataset()
    report.file_meta.TransferSyntaxUID = ExplicitVRLittleEndian
    report.SpecificCharacterSet = "ISO_IR 192"  # UTF-8
    report.SOPClassUID = EncapsulatedPDFStorage
    _identify(report, content, recording)
    report.Modality = "DOC"
    report.SeriesNumber, report.InstanceNumber = 1, 1
    report.SeriesDescription = "High-speed recording: report"
    report.Manufacturer, report.ManufacturerModelName = "Plica", "plica"
    report.SoftwareVersions = build_info()["version"]
    report.ConversionType = "WSD"
    report.ContentDate = report.ContentTime = ""  # else the same report would be another object tomorrow
    report.AcquisitionDateTime = _acquired(found, recording)
    report.BurnedInAnnotation = "YES"
    report.VerificationFlag = "UNVERIFIED"
    report.DocumentTitle = f"High-speed recording {found.label}: {light_of(found).shown} light"
    report.ConceptNameCodeSequence = [_dataset(_TITLE)]
    report.MIMETypeOfEncapsulatedDocument = "application/pdf"
    report.EncapsulatedDocument = content + b"\0" * (len(content) % 2)
    report.EncapsulatedDocumentLength = len(content)
    return report


def _identify(report: Any, content: bytes, recording: Any | None) -> None:
    """Patient, study, series and object; the source, where there is one."""
    from pydicom.uid import generate_uid

    for keyword in _ALWAYS:
        setattr(report, keyword, "")
    of_content = hashlib.sha256(content).hexdigest()
    origin = of_content
    if recording is None:
        report.StudyInstanceUID = generate_uid(entropy_srcs=["plica study", origin])
    else:
        origin = str(recording.SOPInstanceUID)
        for keyword in (*_ALWAYS, *_IF_KNOWN):
            if keyword in recording:
                setattr(report, keyword, _copied(recording[keyword]))
        report.StudyInstanceUID = recording.StudyInstanceUID
        named = {"ReferencedSOPClassUID": recording.SOPClassUID, "ReferencedSOPInstanceUID": origin}
        report.SourceInstanceSequence = [_dataset(named)]
    report.SeriesInstanceUID = generate_uid(entropy_srcs=["plica series", report.StudyInstanceUID, origin])
    report.SOPInstanceUID = generate_uid(entropy_srcs=["plica report", origin, of_content])


def _copied(element: Any) -> Any:
    """A value, its text decoded: the report has a character set of its own."""
    if element.VR == "SQ":
        return copy.deepcopy(element.value)
    return "" if element.value is None else str(element.value)


def _acquired(found: Analysis, recording: Any | None) -> str:
    """Date and time of the recording; its day alone where that was given, empty where it is not known."""
    stated = None if recording is None else recording.get("AcquisitionDateTime")
    if stated and found.settings.recorded is None:
        return str(stated)
    return found.recorded[:10].replace("-", "")


def _dataset(values: dict[str, Any]) -> Any:
    from pydicom.dataset import Dataset

    made = Dataset()
    for keyword, value in values.items():
        setattr(made, keyword, value)
    return made
