"""DICOM files as pydicom reads them: their attributes, and the errors of those that are damaged."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, BinaryIO

from plica.errors import library
from plica.video.errors import VideoError

__all__ = ["Attributes", "dicom_errors", "is_dicom", "opened_dataset", "read_dataset"]

_PREAMBLE = 128  # bytes before DICM


def is_dicom(path: Path) -> bool:
    """Whether a file begins as one of DICOM: DICM after 128 bytes."""
    with open(path, "rb") as file:
        return file.read(_PREAMBLE + 4)[_PREAMBLE:] == b"DICM"


@contextmanager
def dicom_errors(what: str, hint: str = "Is it whole?") -> Iterator[None]:
    """VideoError of `what` for what pydicom, Pillow and the numbers of a damaged file raise.

    Their warnings are about details of the standard that do not concern the frames.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    except VideoError:
        raise
    except Exception as error:  # of two libraries, and of numbers in a damaged file: some twenty kinds
        reason = " ".join(str(error).split()).rstrip(".") or type(error).__name__
        raise VideoError(f"Recording: {what} ({reason}). {hint}") from None


def read_dataset(path: Path) -> Any:
    """The attributes before the pixel data of a DICOM file, as of pydicom.

    Raises
    ------
    VideoError
        Without pydicom; for a file that is not of DICOM or is damaged.
    """
    with open(path, "rb") as file:
        return opened_dataset(path, file)


def opened_dataset(path: Path, file: BinaryIO) -> Any:
    """As :func:`read_dataset`, of an open file, which is left at the tag of the pixel data."""
    pydicom = library("pydicom", "dicom", f"Recording: {path.name}", VideoError)
    if not is_dicom(path):
        raise VideoError(
            f"Recording: {path.name} is not a DICOM file: it does not have DICM after {_PREAMBLE} bytes. "
            "Is it whole? Export it again."
        )
    with dicom_errors(f"{path.name} cannot be read as DICOM"):
        found = pydicom.dcmread(file, stop_before_pixels=True)
        for element in found.file_meta:
            element.value  # noqa: B018
        if not str(found.file_meta.get("TransferSyntaxUID", "")):
            raise VideoError(
                f"Recording: {path.name} has no TransferSyntaxUID; must have it, as it says how the frames "
                "are stored. Export it again."
            )
    return found


class Attributes:
    """Attributes, each with an error that names it where it is not what it must be."""

    def __init__(self, name: str, found: Any) -> None:
        self.name, self.found = name, found

    def wrong(self, what: str, must: str) -> VideoError:
        """An error of the file: what it is, and what it must be."""
        return VideoError(f"Recording: {self.name} {what}; must be {must}.")

    def text(self, keyword: str) -> str:
        """Empty where it is missing."""
        return str(self.found.get(keyword) or "").strip()

    def whole(self, keyword: str, default: int | None = None) -> int:
        """VideoError where it is missing without a default, or is none."""
        value = self.found.get(keyword)
        if value in (None, ""):
            if default is None:
                raise self.wrong(f"has no {keyword}", "a picture that states it. Export it again")
            return default
        try:
            return int(value)
        except (TypeError, ValueError):
            raise self.wrong(f"has {keyword} = {value}", "one whole number") from None

    def number(self, keyword: str) -> float | None:
        """None where it is missing or not finite."""
        value = self.found.get(keyword)
        try:
            number = float(value) if value not in (None, "") else math.nan
        except (TypeError, ValueError):
            raise self.wrong(f"has {keyword} = {value}", "one number") from None
        return number if math.isfinite(number) else None

    def numbers(self, keyword: str) -> list[float]:
        """Empty where they are missing."""
        value = self.found.get(keyword)
        if value in (None, ""):
            return []
        many = [value] if isinstance(value, str | int | float) else list(value)
        try:
            return [float(one) for one in many]
        except (TypeError, ValueError):
            raise self.wrong(f"has {keyword} = {value}", "numbers") from None
