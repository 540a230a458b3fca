"""DICOM files as endoscopy systems and archives write them, made by pydicom for the tests."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image
from pydicom.dataset import Dataset, FileMetaDataset
from pydicom.encaps import encapsulate
from pydicom.uid import (
    MPEG4HP41,
    ExplicitVRBigEndian,
    ExplicitVRLittleEndian,
    JPEG2000Lossless,
    JPEGBaseline8Bit,
    RLELossless,
    VideoEndoscopicImageStorage,
    generate_uid,
)

from picture_files import encoded

PATIENT = {"PatientName": "Müller^Änne", "PatientID": "4711-SECRET", "PatientBirthDate": "19610203"}
STUDY = {
    "StudyInstanceUID": "1.2.826.0.1.3680043.8.498.1",
    "StudyDate": "20240305",
    "StudyTime": "140700",
    "AccessionNumber": "A77",
    "StudyID": "S9",
    "ReferringPhysicianName": "Weiß^Eva",
}


def dicom(
    path: Path,
    frames: np.ndarray,
    *,
    stored: int | None = None,
    syntax: str = ExplicitVRLittleEndian,
    data: bytes | None = None,
    remove: tuple[str, ...] = (),
    cut: int = 0,
    **attributes: Any,
) -> Path:
    """Frames (n, h, w) or (n, h, w, 3) of uint8 or uint16 as an object; `data` in place of their bytes.

    `attributes` replace those that belong to the frames, and `cut` bytes are taken off the end.
    """
    found = Dataset()
    found.file_meta = FileMetaDataset()
    found.file_meta.TransferSyntaxUID = syntax
    found.SpecificCharacterSet = "ISO_IR 100"
    found.SOPClassUID = VideoEndoscopicImageStorage
    found.SOPInstanceUID = generate_uid(entropy_srcs=[path.name])
    found.Modality = "ES"
    found.PatientSex = "F"
    bits = 8 * frames.dtype.itemsize
    colours = frames.ndim == 4
    described = {
        **PATIENT,
        **STUDY,
        "SamplesPerPixel": 3 if colours else 1,
        "PhotometricInterpretation": "RGB" if colours else "MONOCHROME2",
        "NumberOfFrames": len(frames),
        "Rows": frames.shape[1],
        "Columns": frames.shape[2],
        "BitsAllocated": bits,
        "BitsStored": stored or bits,
        "HighBit": (stored or bits) - 1,
        "PixelRepresentation": 0,
        **({"PlanarConfiguration": 0} if colours else {}),
        **attributes,
    }
    for keyword, value in described.items():
        if keyword not in remove:
            setattr(found, keyword, value)
    if "PixelData" not in remove:
        big = syntax == ExplicitVRBigEndian
        raw = frames.astype(frames.dtype.newbyteorder(">")) if big else frames
        found.PixelData = raw.tobytes() if data is None else data
        whole = len(found.PixelData)
        found.PixelData += b"\0" * (whole % 2)
        found["PixelData"].VR = "OB" if bits == 8 or data is not None else "OW"
        if found.file_meta.TransferSyntaxUID.is_encapsulated:
            found["PixelData"].is_undefined_length = True
    found.save_as(path, enforce_file_format=True)
    if cut:
        path.write_bytes(path.read_bytes()[:-cut])
    return path


def jpegs(frames: np.ndarray, form: str = "JPEG", **how: Any) -> list[bytes]:
    """Each frame as a picture of its own."""
    found = []
    for frame in frames:
        buffer = io.BytesIO()
        Image.fromarray(frame).save(buffer, format=form, **how)
        found.append(buffer.getvalue())
    return found


def jpeg(path: Path, frames: np.ndarray, *, table: bool = True, pieces: int = 1, **attributes: Any) -> Path:
    """JPEG Baseline, a frame in as many pieces."""
    colours = frames.ndim == 4
    data = encapsulate(jpegs(frames, quality=95), fragments_per_frame=pieces, has_bot=table)
    kind = {"PhotometricInterpretation": "YBR_FULL_422"} if colours else {}
    return dicom(path, frames, syntax=JPEGBaseline8Bit, data=data, **{**kind, **attributes})


def jpeg_2000(path: Path, frames: np.ndarray, **attributes: Any) -> Path:
    """JPEG 2000 without loss."""
    parts = jpegs(frames, "JPEG2000", irreversible=False, no_jp2=True)
    kind = {"PhotometricInterpretation": "YBR_RCT"} if frames.ndim == 4 else {}
    return dicom(path, frames, syntax=JPEG2000Lossless, data=encapsulate(parts), **{**kind, **attributes})


def rle(path: Path, frames: np.ndarray, **attributes: Any) -> Path:
    """RLE, by pydicom's encoder; its segments are one colour each, whatever the planar configuration."""
    import pydicom

    planar = attributes.pop("PlanarConfiguration", None)
    plain = pydicom.dcmread(dicom(path, frames, **attributes))
    plain.compress(RLELossless, generate_instance_uid=False)
    if planar is not None:
        plain.PlanarConfiguration = planar
    plain.save_as(path, enforce_file_format=True)
    return path


def bitstream(frames: np.ndarray, codec: str = "libx264", container: str = "mp4") -> bytes:
    """A video of grey or coloured frames."""
    return bytes(encoded(io.BytesIO(), frames, codec, "yuv420p", container).getvalue())


def video(path: Path, frames: np.ndarray, data: bytes, *, pieces: int = 1, **attributes: Any) -> Path:
    """A video object."""
    colours = np.repeat(frames[..., None], 3, axis=3) if frames.ndim == 3 else frames
    how = {"PhotometricInterpretation": "YBR_PARTIAL_420", "syntax": MPEG4HP41, **attributes}
    return dicom(path, colours, data=encapsulate([data], fragments_per_frame=pieces, has_bot=False), **how)
