"""The report as a DICOM object: conformant, in the study of the recording, the same for the same report."""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pydicom
import pytest

from dicom_files import PATIENT, STUDY, dicom
from picture_files import refused
from plica.commands.main import main
from plica.synthetic.glottis import Synthetic, SyntheticGlottis
from plica.video import analyse, load
from plica.video.dicom_report import write_dicom
from plica.video.errors import VideoError
from plica.video.light import light_of
from plica.video.settings import Settings

pytest.importorskip("weasyprint")

GLOTTIS = SyntheticGlottis(
    Synthetic(height=64, width=64, frames=42, amplitude=(4, 4), opening=(2, 2), frequency=0.12, texture=10)
).stack()

MODULES: dict[str, dict[str, tuple[str, ...]]] = {
    "Patient": {"2": ("PatientName", "PatientID", "PatientBirthDate", "PatientSex")},
    "General Study": {
        "1": ("StudyInstanceUID",),
        "2": ("StudyDate", "StudyTime", "ReferringPhysicianName", "StudyID", "AccessionNumber"),
    },
    "Encapsulated Document Series": {"1": ("Modality", "SeriesInstanceUID", "SeriesNumber")},
    "General Equipment": {"2": ("Manufacturer",)},
    "SC Equipment": {"1": ("ConversionType",)},
    "Encapsulated Document": {
        "1": (
            "InstanceNumber",
            "BurnedInAnnotation",
            "MIMETypeOfEncapsulatedDocument",
            "EncapsulatedDocument",
        ),
        "2": (
            "ContentDate",
            "ContentTime",
            "AcquisitionDateTime",
            "DocumentTitle",
            "ConceptNameCodeSequence",
        ),
    },
    "SOP Common": {"1": ("SOPClassUID", "SOPInstanceUID", "SpecificCharacterSet")},
}
"""Attributes of type 1 (there, with a value) and 2 (there) of the Encapsulated PDF IOD (PS3.3, A.45.1)."""


def _written(source: Path, out: Path, *options: str) -> Any:
    command = ["glottis", str(source), "-o", str(out), "--no-drift", "--quiet", "--dicom", *options]
    assert main(command) == 0
    return pydicom.dcmread(out / "report.dcm")


def _quick(source: Path, out: Path, pdf: bytes = b"%PDF-1.7 a report", **settings: Any) -> Any:
    """Of another PDF than that of the page, which takes seconds."""
    out.mkdir(exist_ok=True)
    (out / "report.pdf").write_bytes(pdf)
    found = analyse(source, out, Settings(correct_drift=False, **settings), until="glottis", progress=False)
    return pydicom.dcmread(write_dicom(found, out / "report.pdf"))


@pytest.fixture(scope="module")
def films(tmp_path_factory: pytest.TempPathFactory) -> Path:
    where = tmp_path_factory.mktemp("films")
    np.save(where / "x.npy", GLOTTIS)
    dicom(where / "x.dcm", GLOTTIS, FrameTime="0.25", AcquisitionDateTime="20240229101500")
    return where


@pytest.fixture(scope="module")
def of_archive(films: Path) -> Any:
    return _written(films / "x.dcm", films / "archive")


@pytest.fixture(scope="module")
def of_array(films: Path) -> Any:
    return _written(films / "x.npy", films / "array", "--label", "Übung 7", "--recorded", "2024-03-01")


@pytest.mark.slow
@pytest.mark.parametrize("which", ["of_archive", "of_array"])
@pytest.mark.parametrize("module", MODULES)
def test_all_attributes_that_the_standard_requires_are_there(
    which: str, module: str, request: pytest.FixtureRequest
) -> None:
    report = request.getfixturevalue(which)
    for kind, keywords in MODULES[module].items():
        for keyword in keywords:
            assert keyword in report, keyword
            if kind == "1":
                assert report[keyword].value not in (None, "", b""), keyword
    assert report.file_meta.MediaStorageSOPClassUID == report.SOPClassUID
    assert report.file_meta.MediaStorageSOPInstanceUID == report.SOPInstanceUID


@pytest.mark.slow
@pytest.mark.parametrize("which", ["of_archive", "of_array"])
def test_it_holds_the_pdf_and_says_what_it_is(
    which: str, films: Path, request: pytest.FixtureRequest
) -> None:
    report = request.getfixturevalue(which)
    folder = films / which.removeprefix("of_")
    pdf = (folder / "report.pdf").read_bytes()
    assert report.EncapsulatedDocument[: report.EncapsulatedDocumentLength] == pdf
    assert len(report.EncapsulatedDocument) - len(pdf) in (0, 1)
    assert report.SOPClassUID == "1.2.840.10008.5.1.4.1.1.104.1"
    assert (report.Modality, report.BurnedInAnnotation) == ("DOC", "YES")
    assert report.MIMETypeOfEncapsulatedDocument == "application/pdf"
    found = load(folder)
    assert report.DocumentTitle == f"High-speed recording {found.label}: {light_of(found).shown} light"
    code = report.ConceptNameCodeSequence[0]
    assert (code.CodeValue, code.CodingSchemeDesignator) == ("18748-4", "LN")
    for uid in (report.SOPInstanceUID, report.SeriesInstanceUID):
        assert uid.startswith("1.2.826.0.1.3680043.8.498.")
        assert uid.is_valid


@pytest.mark.slow
def test_it_lies_in_the_study_of_the_recording(of_archive: Any, films: Path) -> None:
    source = pydicom.dcmread(films / "x.dcm")
    for keyword in (*PATIENT, *STUDY, "PatientSex"):
        assert str(of_archive[keyword].value) == str(source[keyword].value) != ""
    assert of_archive.SpecificCharacterSet == "ISO_IR 192"
    assert of_archive.PatientName == "Müller^Änne"
    assert of_archive.AcquisitionDateTime == "20240229101500"
    (origin,) = of_archive.SourceInstanceSequence
    assert origin.ReferencedSOPInstanceUID == source.SOPInstanceUID
    assert origin.ReferencedSOPClassUID == source.SOPClassUID
    assert len({of_archive.SOPInstanceUID, of_archive.SeriesInstanceUID, of_archive.StudyInstanceUID}) == 3
    assert "SOPInstanceUID" in source
    assert of_archive.SOPInstanceUID != source.SOPInstanceUID


@pytest.mark.slow
def test_nobody_is_named_beside_it(of_archive: Any, films: Path) -> None:
    for path in (films / "archive").iterdir():
        content = path.read_bytes()
        named = any(word.encode() in content for word in ("Müller", "4711-SECRET", "19610203", "A77"))
        assert named == (path.name == "report.dcm"), path.name
    assert PATIENT["PatientID"].encode() not in of_archive.EncapsulatedDocument


@pytest.mark.slow
def test_of_another_recording_it_has_no_patient_and_a_study_of_its_own(
    of_array: Any, of_archive: Any
) -> None:
    for keyword in MODULES["Patient"]["2"] + MODULES["General Study"]["2"]:
        assert not of_array[keyword].value, keyword
    assert "SourceInstanceSequence" not in of_array
    assert of_array.StudyInstanceUID != of_archive.StudyInstanceUID
    assert of_array.StudyInstanceUID.startswith("1.2.826.0.1.3680043.8.498.")
    assert of_array.AcquisitionDateTime == "20240301"
    assert "Übung 7" in of_array.DocumentTitle


@pytest.mark.usefixtures("few_draws")
@pytest.mark.parametrize("name", ["x.dcm", "x.npy"])
def test_the_same_report_is_the_same_object_and_another_one_another(
    name: str, films: Path, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    first = _quick(films / name, out)
    content = (out / "report.dcm").read_bytes()
    _quick(films / name, out)
    assert (out / "report.dcm").read_bytes() == content
    other = _quick(films / name, out, b"%PDF-1.7 another")
    assert other.SOPInstanceUID != first.SOPInstanceUID
    same_study = other.StudyInstanceUID == first.StudyInstanceUID
    assert same_study == (other.SeriesInstanceUID == first.SeriesInstanceUID) == (name == "x.dcm")


@pytest.mark.slow
def test_the_same_command_writes_the_same_object_again(of_archive: Any, films: Path) -> None:
    assert _written(films / "x.dcm", films / "archive") == of_archive


@pytest.mark.usefixtures("few_draws")
def test_reports_of_two_recordings_of_a_study_are_two_series(films: Path, tmp_path: Path) -> None:
    dicom(tmp_path / "y.dcm", GLOTTIS, FrameTime="0.25")
    one, other = _quick(films / "x.dcm", tmp_path / "x"), _quick(tmp_path / "y.dcm", tmp_path / "y")
    assert other.StudyInstanceUID == one.StudyInstanceUID
    assert other.SeriesInstanceUID != one.SeriesInstanceUID
    assert other.SOPInstanceUID != one.SOPInstanceUID


@pytest.mark.usefixtures("few_draws")
def test_a_pdf_of_odd_length_is_padded_and_its_length_said(films: Path, tmp_path: Path) -> None:
    for pdf in (b"%PDF-1.7 odd!", b"%PDF-1.7 even!"):
        report = _quick(films / "x.npy", tmp_path / "out", pdf)
        assert report.EncapsulatedDocumentLength == len(pdf)
        assert report.EncapsulatedDocument[: len(pdf)] == pdf
        assert len(report.EncapsulatedDocument) == 14


@pytest.mark.usefixtures("few_draws")
@pytest.mark.filterwarnings("ignore:Invalid value")  # of reading it again
def test_a_patient_whose_data_break_the_standard_is_copied_as_it_is(tmp_path: Path) -> None:
    path = dicom(tmp_path / "y.dcm", GLOTTIS, FrameTime="0.25")
    path.write_bytes(path.read_bytes().replace(b"19610203", b"1961-2-3"))
    assert _quick(path, tmp_path / "out").PatientBirthDate == "1961-2-3"


@pytest.mark.usefixtures("few_draws")
def test_a_day_that_was_told_is_that_of_the_recording(films: Path, tmp_path: Path) -> None:
    report = _quick(films / "x.dcm", tmp_path / "out", recorded="2024-03-02")
    assert report.AcquisitionDateTime == "20240302"
    assert report.StudyDate == STUDY["StudyDate"]


def test_a_study_that_is_not_known_or_a_recording_that_is_gone_is_said(tmp_path: Path) -> None:
    path = dicom(tmp_path / "y.dcm", GLOTTIS, remove=("StudyInstanceUID",))
    out = tmp_path / "out"
    with pytest.raises(VideoError, match=r"y\.dcm has no StudyInstanceUID; must have it, as the report goes"):
        _quick(path, out)
    path.unlink()
    with pytest.raises(VideoError, match=r"the recording \S+y\.dcm is not there; must be"):
        write_dicom(load(out), out / "report.pdf")
    assert not (out / "report.dcm").exists()


@pytest.mark.parametrize(
    ("library", "said"),
    [
        ("pydicom", "A report for an archive (--dicom) needs pydicom, which is not installed"),
        ("weasyprint", "A report as PDF (--pdf) needs WeasyPrint, which is not installed"),
    ],
)
def test_without_its_libraries_nothing_is_computed(
    library: str,
    said: str,
    films: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setitem(sys.modules, library, None)
    error = refused(["glottis", str(films / "x.npy"), "-o", str(tmp_path / "out"), "--dicom"], capsys)
    assert said in error
    assert re.search(r"pip install 'plica\[(dicom,)?pdf\]'", error)
    assert not (tmp_path / "out").exists()


@pytest.mark.usefixtures("few_draws", "unrendered")
def test_an_object_of_earlier_settings_is_named(
    films: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    _quick(films / "x.npy", tmp_path / "out")
    command = ["glottis", str(films / "x.npy"), "-o", str(tmp_path / "out"), "--no-drift", "--quiet"]
    assert main([*command, "--fps", "2000"]) == 0
    assert "--pdf --dicom writes anew" in capsys.readouterr().err
