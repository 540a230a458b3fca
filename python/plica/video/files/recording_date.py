"""When a recording was made: as given, or as its file says."""

from __future__ import annotations

import re
from collections.abc import Iterator
from datetime import UTC, date, datetime, timedelta
from pathlib import Path
from typing import Any, NamedTuple

from plica.errors import library
from plica.video.errors import VideoError
from plica.video.files.camera_metadata import Camera
from plica.video.files.image_file import is_picture
from plica.video.files.tiff_file import open_tiff

__all__ = ["FileDate", "file_date", "told_date"]

_FIRST = 1971  # a camera without a clock begins at 1904 or 1970
_TAGS = ("com.apple.quicktime.creationdate", "creation_time", "date_recorded", "date")
_TAKEN, _STORED, _CAMERA = 36867, 306, 0x8769  # EXIF: DateTimeOriginal, DateTime, the camera's directory


class FileDate(NamedTuple):
    """A day, ``2026-03-01``, and the tag that names it."""

    day: str
    tag: str


def told_date(text: str) -> str:
    """A day, or a day and a time, of ISO 8601, beginning with the day as ``2026-03-01``: so written, days
    compare as text.

    VideoError for what is none, or is to come.
    """
    try:
        moment = datetime.fromisoformat(text)
    except (TypeError, ValueError):
        raise VideoError(
            f"Video: recorded = {text!r}; must be a date, year first: 2026-03-01, or 2026-03-01T10:30."
        ) from None
    day = moment.date()
    if day > _tomorrow():
        raise VideoError(f"Video: recorded = {text}; must not be in the future. Is the year right?")
    if text.startswith(day.isoformat()):
        return text
    try:  # "20260301", "2026-W09-7"
        return date.fromisoformat(text).isoformat()
    except ValueError:
        return moment.isoformat()


def file_date(path: Path, camera: Camera | None = None) -> FileDate | None:
    """The day that a video, a TIFF stack, a folder's first picture or a camera's own file says it was made.

    None where it says none, or one that no clock has shown: before 1971, or to come. What cannot be read
    here is for whoever reads the frames to refuse.
    """
    for tag, text in _stated(path, camera):
        found = re.match(r"(\d{4})[:/-] ?(\d\d?)[:/-] ?(\d\d?)(?!\d)", str(text).strip())
        if found is None:
            continue
        try:
            day = date(*map(int, found.groups()))
        except ValueError:
            continue
        if day.year >= _FIRST and day <= _tomorrow():
            return FileDate(day.isoformat(), tag)
    return None


def _tomorrow() -> date:
    return datetime.now(UTC).date() + timedelta(days=1)  # somewhere it is


def _stated(path: Path, camera: Camera | None) -> Iterator[tuple[str, object]]:
    """Tags that name a date, the surest first."""
    if camera is not None:
        if camera.date is not None:
            yield "date", camera.date
    elif path.is_dir():
        pictures = sorted(file for file in path.iterdir() if is_picture(file))
        if pictures:
            yield from _of_picture(pictures[0])
    elif path.suffix.lower() in {".tif", ".tiff"}:
        with open_tiff(path) as stack:
            first: Any = stack.pages[0]
            tag = first.tags.get(_STORED)
            if tag is not None:
                yield "DateTime", tag.value
    elif path.suffix.lower() not in {".h5", ".hdf5", ".mat", ".npy"}:
        av = library("av", "video", f"Recording: {path.name}", VideoError)
        with av.open(str(path), metadata_errors="replace") as container:
            parts = [container.metadata, *(stream.metadata for stream in container.streams.video)]
            named = {key.lower(): value for part in reversed(parts) for key, value in part.items()}
        yield from ((tag, named[tag]) for tag in _TAGS if tag in named)


def _of_picture(path: Path) -> Iterator[tuple[str, object]]:
    from PIL import Image

    with Image.open(path) as image:
        tags = image.getexif()
        found = {"DateTimeOriginal": tags.get_ifd(_CAMERA).get(_TAKEN), "DateTime": tags.get(_STORED)}
        found["Creation Time"] = image.info.get("Creation Time")
    yield from ((name, text) for name, text in found.items() if text)
