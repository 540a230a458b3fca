"""Frame rate, size of a pixel and day of recording that a DICOM file states, as far as they can be taken."""

from __future__ import annotations

import numpy as np

from plica.video.files.camera_metadata import Camera
from plica.video.files.dicom_file import Attributes
from plica.video.files.frame_times import even_step

__all__ = ["SPACINGS", "camera_of"]

SPACINGS = ("PixelSpacing", "ImagerPixelSpacing", "NominalScannedPixelSpacing")
"""Attributes that state the distance of pixels, down and across, in mm."""

_PLAYED = 200.0  # frames/s below which a rate is taken for that of playing
_FASTEST = 1e6  # frames/s
_SAME_RATE = 0.01  # relative: CineRate is a whole number
_DAYS = ("AcquisitionDateTime", "AcquisitionDate", "ContentDate", "StudyDate")


def camera_of(said: Attributes, stored: int) -> Camera:
    """What it says of the camera, `stored` bits a pixel.

    A rate from 200 frames/s on is the camera's; one below is taken for that of playing, as in files of video.
    A size of a pixel is never taken: no attribute says that it is calibrated for the plane of the glottis.

    Raises
    ------
    VideoError
        For frames that are not equally spaced in time.
    """
    fps, unused = _rate(said)
    found = {"fps": unused} if unused else {}
    if size := _size(said):
        found["mm_per_px"] = size
    return Camera(fps, _day(said), stored, found)


def _rate(said: Attributes) -> tuple[float | None, str]:
    """Frames per second of the camera, or why none of those stated is taken for it."""
    stated = {}
    if (step := _vector_step(said)) is not None:
        stated["FrameTimeVector"] = 1 / step
    time = said.number("FrameTime")
    if time is not None and time > 0:
        stated["FrameTime"] = 1000 / time
    for keyword in ("CineRate", "RecommendedDisplayFrameRate"):
        rate = said.number(keyword)
        if rate is not None and rate > 0:
            stated[keyword] = rate
    fast = {keyword: rate for keyword, rate in stated.items() if _PLAYED <= rate <= _FASTEST}
    if not stated:
        return None, ""
    if not fast:
        keyword, rate = next(iter(stated.items()))
        limits = (
            f"below {_PLAYED:g}: taken for the rate at which it is played"
            if rate < _PLAYED
            else f"above {_FASTEST:g}: no camera's"
        )
        return None, f"the file states {rate:g} frames/s ({keyword}), {limits}, and not used"
    if max(fast.values()) / min(fast.values()) - 1 > _SAME_RATE:
        listed = " and ".join(f"{rate:g} ({keyword})" for keyword, rate in fast.items())
        return None, f"the file states {listed} frames/s, which differ: neither is used"
    return next(iter(fast.values())), ""


def _vector_step(said: Attributes) -> float | None:
    """s between frames, of their increments in ms."""
    steps, count = said.numbers("FrameTimeVector"), said.whole("NumberOfFrames", 1)
    if not steps:
        return None
    if len(steps) != count:
        raise said.wrong(
            f"has a FrameTimeVector of {len(steps)} times", f"of {count}, one for each frame. Export it again"
        )
    return even_step(said.name, np.cumsum(steps) / 1000)


def _size(said: Attributes) -> str:
    """Why a pixel's size is not taken."""
    for keyword in SPACINGS:
        found = said.numbers(keyword)
        if len(found) == 2 and min(found) > 0:
            return (
                f"the file states {found[0]:g} mm/px ({keyword}), not for which distance from the endoscope: "
                "not used"
            )
    return ""


def _day(said: Attributes) -> str | None:
    for keyword in _DAYS:
        digits = said.text(keyword)[:8]
        if len(digits) == 8 and digits.isdecimal():
            return f"{digits[:4]}-{digits[4:6]}-{digits[6:]}"
    return None
