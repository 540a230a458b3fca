"""What a recording is analysed with."""

from __future__ import annotations

import json
import math
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np

from plica.errors import nearest, one_of
from plica.video.errors import VideoError
from plica.video.files.recording_date import told_date
from plica.video.files.signal_file import Channel
from plica.video.glottis.kymogram import check_places
from plica.video.glottis.midline import Midline
from plica.video.motion.flow import PRESETS

__all__ = ["SIGNALS", "Settings"]

SIGNALS = ("audio", "egg")
"""Settings that name a signal beside the picture."""
_NONE = "none"  # no signal any more

_RANGES = {"fps": (1.0, 1e7), "mm_per_px": (1e-5, 10.0), "rotation": (-360.0, 360.0)}
"""Beyond any camera that films a larynx."""
_UNITS = {"fps": "frames/s", "mm_per_px": "mm a pixel", "rotation": "degrees"}
_ASKS = {
    "fps": "Is it the rate of the camera, in frames a second?",
    "mm_per_px": "Is it the size of one pixel, in mm?",
    "rotation": "Is it the angle to turn by, in degrees?",
}
_LONGEST = 120  # characters of a label: one line of the page


@dataclass(frozen=True)
class Settings:
    """What a recording is analysed with; None is unknown, or found.

    The frame rate, the size of a pixel, the anterior end, the patient's left, the label, the day and signals
    beside the picture are said of the recording and compute nothing of it; these, the midline, the kymograms
    and the modes may be given, or changed, when the analysis is done.

    Raises
    ------
    VideoError
        For one that is out of range.
    """

    fps: float | None = None
    """True frames per second; None: times in frames."""
    mm_per_px: float | None = None
    """Millimetres a pixel; None: lengths in pixels."""
    rotation: float = 0.0
    """Degrees, anticlockwise as seen."""
    first: int | None = None
    """First frame that is analysed; None: 0. Frames and times are counted from it."""
    last: int | None = None
    """Last frame that is analysed, included; None: the last one."""
    region: tuple[int, int, int, int] | None = None
    """x, y, width, height in px of the turned frames."""
    dataset: str | None = None
    """Of an HDF5 file that holds several."""
    midline: tuple[float, float, float, float] | None = None
    """x, y of one end and of the other, px of the region; None: found."""
    anterior: Literal["upper", "lower"] | None = None
    """End of the midline that is the anterior one."""
    patient_left: Literal["left", "right"] | None = None
    """Side of the image on which the patient's left fold is; names of sides stay those of the image."""
    preset: str = "video"
    """Of the flow."""
    correct_drift: bool = True
    """Take the endoscope's motion out."""
    modes: int | None = None
    """Principal modes; None: 6, or as many as there are."""
    segmenter: str | None = None
    """File of an ONNX model that finds the glottis; None: found by its edges and its darkness."""
    kymogram: tuple[float, ...] | None = None
    """Places of the kymograms' lines: 0 at the midline's upper end, 1 at its lower; None: 0.25, 0.5, 0.75."""
    label: str | None = None
    """What whoever looks at it calls the recording, on its page and beside its figures; None: nothing."""
    recorded: str | None = None
    """Day on which it was recorded, 2026-03-01; None: as its file says, if it does."""
    audio: str | None = None
    """Sound beside the picture: FILE.wav, FILE.wav:CHANNEL, or :-CHANNEL to invert it; "none": none any more.
    It needs a frame rate."""
    egg: str | None = None
    """Electroglottogram beside the picture, larger with more contact; as `audio`."""
    sound_start: tuple[float, ...] | None = None
    """s, time of the recording's first frame in the files of both signals, or in that of either; negative
    where they begin after it. None: 0."""
    sync: int | None = None
    """Channel of the signals' files with one pulse at the first frame, from which `sound_start` counts."""

    def __post_init__(self) -> None:
        if self.segmenter is not None:
            if not isinstance(self.segmenter, str):
                raise VideoError(f"Video: segmenter = {self.segmenter!r}; must be the path of an ONNX model.")
            object.__setattr__(self, "segmenter", str(Path(self.segmenter).resolve()))
        for name in SIGNALS:
            told = getattr(self, name)
            if told is not None and told != _NONE:
                if not isinstance(told, str):
                    raise VideoError(f"Video: {name} = {told!r}; must be FILE.wav or FILE.wav:CHANNEL.")
                object.__setattr__(self, name, str(Channel.of(told)))
        for name, length in (("region", 4), ("midline", 4), ("kymogram", None), ("sound_start", None)):
            values = getattr(self, name)
            if values is None:
                continue
            try:
                read = () if isinstance(values, str) else tuple(map(float, values))
                if name == "region":
                    read = tuple(int(value) for value in read if value.is_integer())
            except (TypeError, ValueError):
                read = ()
            if not read or (length is not None and len(read) != length):
                whole = "whole " if name == "region" else ""
                many = "numbers" if length is None else f"{length} {whole}numbers"
                raise VideoError(f"Video: {name} = {values!r}; must be {many}.")
            object.__setattr__(self, name, read)
        for name in ("first", "last"):
            frame = getattr(self, name)
            if frame is not None and (not _is_whole(frame) or frame < 0):
                raise VideoError(f"Video: {name} = {frame!r}; must be the number of a frame, 0 or more.")
        if self.first is not None and self.last is not None and not self.first < self.last:
            raise VideoError(
                f"Video: first = {self.first}, last = {self.last} (--from, --to); the last must come "
                "after the first."
            )
        for name in ("fps", "mm_per_px", "rotation"):
            number = getattr(self, name)
            if number is None and name != "rotation":
                continue
            if isinstance(number, bool) or not isinstance(number, int | float | np.integer):
                raise VideoError(f"Video: {name} = {number!r}; must be a number of {_UNITS[name]}.")
            if not (math.isfinite(number) and (number > 0 or name == "rotation")):
                must = "finite" if name == "rotation" else "> 0 and finite, or left out if unknown"
                raise VideoError(f"Video: {name} = {number:g} {_UNITS[name]}; must be {must}. {_ASKS[name]}")
            least, most = _RANGES[name]
            if not least <= number <= most:
                raise VideoError(
                    f"Video: {name} = {number:g} {_UNITS[name]}; must be in [{least:g}, {most:g}]. "
                    f"{_ASKS[name]}"
                )
        for name, value, known in (
            ("preset", self.preset, tuple(PRESETS)),
            ("anterior", self.anterior, ("upper", "lower")),
            ("patient_left", self.patient_left, ("left", "right")),
        ):
            if value is not None and value not in known:
                raise VideoError(
                    f'Video: {name} = "{value}"; must be {one_of(known)}.{nearest(value, known)}'
                )
        if self.midline is not None:
            Midline.between(self.midline)
        if self.modes is not None and (not _is_whole(self.modes) or self.modes < 1):
            raise VideoError(f"Video: modes = {self.modes!r}; must be a whole number, 1 or more.")
        if self.kymogram is not None:
            check_places(self.kymogram)
        if self.sound_start is not None:
            _check_start(self.sound_start)
        if self.sync is not None and (not _is_whole(self.sync) or self.sync < 1):
            raise VideoError(f"Video: sync = {self.sync!r}; must be a channel's number, 1 or more.")
        if self.label is not None:
            _check_label(self.label)
        if self.recorded is not None:
            object.__setattr__(self, "recorded", told_date(self.recorded))

    def as_json(self) -> str:
        """All of them, as :meth:`from_json` reads them."""
        return json.dumps(asdict(self))

    @classmethod
    def from_json(cls, text: str) -> Settings:
        """Those that :meth:`as_json` wrote."""
        stored: dict[str, Any] = json.loads(text)
        for name, value in stored.items():
            stored[name] = tuple(value) if isinstance(value, list) else value
        return cls(**stored)

    @property
    def signals(self) -> dict[str, str]:
        """Signals beside the picture, by name."""
        told = {name: getattr(self, name) for name in SIGNALS}
        return {name: text for name, text in told.items() if text not in (None, _NONE)}

    def start_of(self, name: str) -> float:
        """s, time of the recording's first frame in the file of a signal, or after its pulse."""
        starts = self.sound_start or (0.0,)
        return starts[SIGNALS.index(name)] if len(starts) > 1 else starts[0]

    @property
    def places(self) -> tuple[float, ...]:
        """Of the kymograms."""
        return self.kymogram or (0.25, 0.5, 0.75)

    @property
    def mode_count(self) -> int:
        """Principal modes."""
        return self.modes or 6


def _check_start(starts: tuple[float, ...]) -> None:
    """VideoError unless they are one time, or one for each signal."""
    if len(starts) > len(SIGNALS) or not all(map(math.isfinite, starts)):
        text = ",".join(f"{start:g}" for start in starts)
        raise VideoError(
            f"Video: sound_start = {text} s; must be one finite time, or two: of the sound, and of the "
            "electroglottogram."
        )


def _check_label(label: object) -> None:
    """VideoError unless it is one line of words."""
    if not isinstance(label, str) or not label.strip() or not label.isprintable():
        raise VideoError(f"Video: label = {label!r}; must be one line of text, or left out.")
    if len(label) > _LONGEST:
        raise VideoError(
            f"Video: label = {label[:20]!r}... has {len(label)} characters; must be {_LONGEST} or fewer."
        )


def _is_whole(value: object) -> bool:
    return isinstance(value, int | np.integer) and not isinstance(value, bool)
