"""DICOM files that would mislead are refused in one sentence, which names what must hold."""

from __future__ import annotations

import struct
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pydicom
import pytest
from pydicom.dataset import Dataset, FileMetaDataset
from pydicom.encaps import encapsulate
from pydicom.uid import (
    MPEG4HP42STEREO,
    BasicTextSRStorage,
    DeflatedExplicitVRLittleEndian,
    ExplicitVRBigEndian,
    JPEGLosslessSV1,
    MediaStorageDirectoryStorage,
    RLELossless,
)

from dicom_files import bitstream, dicom, jpeg, rle, video
from picture_files import refused
from plica.video import VideoError
from plica.video.files.sources import open_source

RANDOM = np.random.default_rng(7)
F = RANDOM.integers(0, 256, (3, 32, 47)).astype(np.uint8)
DEEP = RANDOM.integers(0, 1 << 16, (3, 32, 48)).astype(np.uint16)
DEEP[0, 0, :2] = 4096, 1
COLOURS = RANDOM.integers(0, 256, (3, 32, 46, 3)).astype(np.uint8)
SMOOTH = (np.add.outer(np.arange(64), np.arange(96)) + np.arange(5)[:, None, None]).astype(np.uint8)
MOVIE = bitstream(SMOOTH)


def _object(path: Path, sop_class: str, **attributes: Any) -> Path:
    """An object without pixels."""
    found = Dataset()
    found.file_meta = FileMetaDataset()
    found.file_meta.TransferSyntaxUID = pydicom.uid.ExplicitVRLittleEndian
    found.SOPClassUID, found.SOPInstanceUID = sop_class, "1.2.3"
    for keyword, value in attributes.items():
        setattr(found, keyword, value)
    found.save_as(path, enforce_file_format=True)
    return path


def _text(path: Path, content: bytes = b"no recording") -> Path:
    path.write_bytes(content)
    return path


def _replaced(path: Path, old: bytes, new: bytes) -> Path:
    content = path.read_bytes()
    assert content.count(old) == 1
    path.write_bytes(content.replace(old, new))
    return path


def _stated(path: Path, **attributes: Any) -> Path:
    """With other attributes than belong to its frames."""
    found = pydicom.dcmread(path)
    for keyword, value in attributes.items():
        setattr(found, keyword, value)
    found.save_as(path)
    return path


def _floats(path: Path) -> Path:
    values = F.astype(np.float32)
    dicom(path, F, remove=("PixelData",), BitsAllocated=32)
    found = pydicom.dcmread(path)
    found.FloatPixelData = values.tobytes()
    found.save_as(path)
    return path


def _items(table: bytes) -> bytes:
    """Three items of two bytes each, after a table of offsets."""
    parts = [table, b"ab", b"cd", b"ef"]
    items = (b"\xfe\xff\0\xe0" + struct.pack("<I", len(part)) + part for part in parts)
    return b"".join(items) + b"\xfe\xff\xdd\xe0\0\0\0\0"


SYNTAX = b"\x02\0\x10\0UI\x14\x001.2.840.10008.1.2.1\0"
FILES: dict[str, tuple[Callable[[Path], Path], str]] = {
    "text": (lambda p: _text(p), "x.dcm is not a DICOM file: it does not have DICM after 128 bytes"),
    "nothing after DICM": (lambda p: _text(p, b"\0" * 128 + b"DICM"), "x.dcm"),
    "DICOMDIR": (
        lambda p: _object(p, MediaStorageDirectoryStorage),
        "x.dcm is a DICOMDIR, a list of files; must be a recording: give one of the files that it lists",
    ),
    "structured report": (
        lambda p: _object(p, BasicTextSRStorage),
        "x.dcm has no pixel data (Basic Text SR Storage); must be a picture with several frames, or a video",
    ),
    "no pixel data": (lambda p: dicom(p, F, remove=("PixelData",)), "x.dcm has no pixel data (Video"),
    "floating-point pixels": (_floats, "x.dcm has pixels that are floating-point numbers; must be"),
    "one frame": (lambda p: dicom(p, F[:1]), "x.dcm has 1 frame; must be two or more"),
    "no number of frames": (
        lambda p: dicom(p, F[:1], remove=("NumberOfFrames",)),
        "x.dcm has 1 frame; must be two or more",
    ),
    "signed": (
        lambda p: dicom(p, DEEP >> 4, stored=12, PixelRepresentation=1),
        "x.dcm has signed pixels of 12 bits (PixelRepresentation = 1); must be unsigned",
    ),
    "32 bits": (
        lambda p: dicom(p, F.astype(np.uint32), stored=32),
        "x.dcm has BitsAllocated = 32; must be 8 or 16",
    ),
    "more stored than allocated": (
        lambda p: dicom(p, F, BitsStored=12),
        "x.dcm has BitsStored = 12; must be in [1, 8], of BitsAllocated",
    ),
    "high bit": (
        lambda p: dicom(p, DEEP, stored=12, HighBit=9),
        "x.dcm has HighBit = 9 with BitsStored = 12; must be in [11, 15], as BitsAllocated = 16",
    ),
    "bits beyond those stored": (
        lambda p: dicom(p, DEEP, stored=12),
        "x.dcm: frame 0 has bits beyond the 12 that BitsStored and HighBit = 11 name, in a pixel of 4096",
    ),
    "bits below those stored": (
        lambda p: dicom(p, DEEP, stored=12, HighBit=15),
        "frame 0 has bits beyond the 12 that BitsStored and HighBit = 15 name, in a pixel of 1",
    ),
    "RLE of more bits than stored": (
        lambda p: _stated(rle(p, DEEP), BitsStored=12, HighBit=11),
        "x.dcm: frame 0 has bits beyond the 12 that BitsStored and HighBit = 11 name, in a pixel of 4096",
    ),
    "a length that no number has": (
        lambda p: _replaced(dicom(p, F), b"\x02\0\0\0UL\4\0", b"\x02\0\0\0UL\5\0"),
        "x.dcm cannot be read as DICOM",
    ),
    "a transfer syntax that nobody knows": (
        lambda p: _replaced(jpeg(p, SMOOTH), b"1.2.840.10008.1.2.4.50", b"1.2\0840.10008.1.2.4.50"),
        "x.dcm cannot be read as DICOM",
    ),
    "truncated": (
        lambda p: dicom(p, F, cut=500),
        "x.dcm has 4012 bytes of pixel data; must have 4512, as it states 3 frames of 47 x 32 px of 8 bits",
    ),
    "more frames stated": (
        lambda p: dicom(p, F, NumberOfFrames=4),
        "x.dcm has pixel data of 4512 bytes; must have 6016, as it states 4 frames of 47 x 32 px of 8 bits",
    ),
    "fewer frames stated": (
        lambda p: dicom(p, F, NumberOfFrames=2),
        "x.dcm has pixel data of 4512 bytes; must have 3008, as it states 2 frames",
    ),
    "more JPEG frames stated": (
        lambda p: jpeg(p, SMOOTH, NumberOfFrames=6),
        "x.dcm states 6 frames, and its pixel data have 5 (in 5 pieces); must be the same",
    ),
    "fewer JPEG frames stated": (
        lambda p: jpeg(p, SMOOTH, table=False, pieces=2, NumberOfFrames=4),
        "x.dcm states 4 frames, and its pixel data have 5 (in 10 pieces); must be the same",
    ),
    "JPEG cut off": (
        lambda p: jpeg(p, SMOOTH) and _text(p, p.read_bytes()[:-2000]),
        "x.dcm ends within its compressed pixel data, after",
    ),
    "JPEG damaged": (
        lambda p: _text(p, jpeg(p, SMOOTH).read_bytes().replace(b"\xff\xd8\xff", b"\0\0\0")),
        "x.dcm: frame 0 cannot be decoded",
    ),
    "offsets that name nothing": (
        lambda p: dicom(p, F, syntax=RLELossless, data=_items(struct.pack("<3I", 0, 9, 12))),
        "x.dcm has a table of offsets that does not name the pieces of its frames",
    ),
    "JPEG Lossless": (
        lambda p: dicom(p, F, syntax=JPEGLosslessSV1, data=encapsulate([b"ab"] * 3)),
        "x.dcm is compressed as JPEG Lossless, Non-Hierarchical, First-Order Prediction",
    ),
    "deflated": (
        lambda p: dicom(p, F, syntax=DeflatedExplicitVRLittleEndian),
        "x.dcm has the transfer syntax Deflated Explicit VR Little Endian; must be uncompressed as a file",
    ),
    "no transfer syntax": (
        lambda p: _replaced(dicom(p, F), SYNTAX, SYNTAX.replace(b"\x10", b"\x11")),
        "x.dcm has no TransferSyntaxUID; must have it",
    ),
    "palette": (
        lambda p: dicom(p, F, PhotometricInterpretation="PALETTE COLOR"),
        "x.dcm has PhotometricInterpretation = PALETTE COLOR of 1 samples; must be one of MONOCHROME1",
    ),
    "no interpretation": (
        lambda p: dicom(p, F, remove=("PhotometricInterpretation",)),
        "has PhotometricInterpretation = none of 1 samples",
    ),
    "two samples": (lambda p: dicom(p, F, SamplesPerPixel=2), "SamplesPerPixel = 2; must be 1 (grey) or 3"),
    "no planar configuration": (
        lambda p: dicom(p, COLOURS, remove=("PlanarConfiguration",)),
        "x.dcm has no PlanarConfiguration; must be a picture",
    ),
    "planar configuration": (
        lambda p: dicom(p, COLOURS, PlanarConfiguration=2),
        "has PlanarConfiguration = 2; must be 0 or 1",
    ),
    "deep colour differences": (
        lambda p: dicom(p, COLOURS.astype(np.uint16), PhotometricInterpretation="YBR_FULL"),
        "has YBR_FULL of 16 bits; must be of 8 bits",
    ),
    "halved colour without video": (
        lambda p: dicom(p, COLOURS, PhotometricInterpretation="YBR_PARTIAL_420"),
        "has YBR_PARTIAL_420 without compression; must be RGB, YBR_FULL or YBR_FULL_422",
    ),
    "turned by its slope": (
        lambda p: dicom(p, F, RescaleSlope=-1, RescaleIntercept=255),
        "has RescaleSlope = -1; must be above 0: else dark and bright change places",
    ),
    "turned by its table": (
        lambda p: dicom(p, F, PresentationLUTShape="INVERSE"),
        "has PresentationLUTShape = INVERSE with MONOCHROME2; must be IDENTITY",
    ),
    "oblong pixels": (
        lambda p: dicom(p, F, PixelAspectRatio=[2, 1]),
        "has pixels of 2 down to 1 across (PixelAspectRatio); must be square, to 1 %",
    ),
    "oblong spacing": (
        lambda p: dicom(p, F, PixelSpacing=["0.05", "0.06"]),
        "has pixels of 0.05 down to 0.06 across (PixelSpacing); must be square",
    ),
    "a gap": (
        lambda p: dicom(p, np.repeat(F, 2, axis=0), FrameTimeVector=[0, 0.25, 0.25, 0.5, 0.25, 0.25]),
        "from frame 2, at 0.0005 s, to frame 3 there are 0.0005 s; must be 0.00025 s as between the others",
    ),
    "too few times": (
        lambda p: dicom(p, F, FrameTimeVector=["0", "0.25"]),
        "has a FrameTimeVector of 2 times; must be of 3, one for each frame",
    ),
    "no rows": (lambda p: dicom(p, F, remove=("Rows",)), "x.dcm has no Rows; must be a picture"),
    "tiny": (lambda p: dicom(p, F[:, :8, :8]), "has frames of 8 x 8 px; must be 16 x 16 px or more"),
    "video of another length": (
        lambda p: video(p, SMOOTH, MOVIE, NumberOfFrames=7),
        "x.dcm states 7 frames of 96 x 64 px, and its video has 5 frames of 96 x 64 px; must be the same",
    ),
    "video of another size": (
        lambda p: video(p, SMOOTH, MOVIE, Rows=62),
        "x.dcm states 5 frames of 96 x 62 px, and its video has 5 frames of 96 x 64 px",
    ),
    "no video": (lambda p: video(p, SMOOTH, b"no video"), "x.dcm cannot be read as a video"),
    "video cut off": (
        lambda p: _text(p, video(p, SMOOTH, MOVIE).read_bytes()[:-900]),
        "x.dcm ends within its compressed pixel data",
    ),
    "stereo": (
        lambda p: video(p, SMOOTH, MOVIE, syntax=MPEG4HP42STEREO),
        "x.dcm is a stereo video; must have one view",
    ),
}


@pytest.mark.parametrize("kind", FILES)
def test_a_file_that_would_mislead_is_refused(
    kind: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    make, said = FILES[kind]
    out = tmp_path / "out"
    error = refused(["glottis", str(make(tmp_path / "x.dcm")), "-o", str(out), "--quiet"], capsys)
    assert said in error
    assert error.startswith("plica: Recording: x.dcm")
    assert not out.exists()


def test_odd_frames_in_words_of_a_big_endian_file_are_refused(tmp_path: Path) -> None:
    odd = F[:, :31]
    path = dicom(tmp_path / "x.dcm", odd, syntax=ExplicitVRBigEndian)
    _replaced(path, b"\x7f\xe0\x00\x10OB", b"\x7f\xe0\x00\x10OW")
    with pytest.raises(VideoError, match="frames of 1457 bytes in words of a big-endian file; must be even"):
        open_source(path)


def test_without_pydicom_it_is_said_what_to_install(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    path = dicom(tmp_path / "x.dcm", F)
    monkeypatch.setitem(sys.modules, "pydicom", None)
    said = refused(["glottis", str(path), "-o", str(tmp_path / "out")], capsys)
    assert "x.dcm needs pydicom, which is not installed; must be: pip install 'plica[dicom]'" in said
