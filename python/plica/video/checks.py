"""What must hold of the settings and the drawn masks of a recording, before anything is computed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import numpy.typing as npt

from plica.video.errors import VideoError
from plica.video.files.corrections import VIEW, Corrections
from plica.video.files.recording import Recording
from plica.video.glottis.segmenter import read_masks
from plica.video.settings import Settings

__all__ = ["checked_masks", "corrected", "drawn_masks", "require_midline", "require_modes"]

Mask = npt.NDArray[np.bool_]


def require_modes(settings: Settings, recording: Recording) -> None:
    """VideoError for more modes than the recording can have, before anything is computed."""
    height, width = recording.shape
    most = min(recording.count - 2, 2 * height * width)
    if settings.modes is not None and settings.modes > most:
        raise VideoError(
            f"Video: modes = {settings.modes}; must be at most {most} for {recording.count} frames of "
            f"{width} x {height} px: fewer than its {recording.count - 1} flows, and than their components."
        )


def require_midline(settings: Settings, recording: Recording) -> None:
    """VideoError for a midline that was set with an end outside the frames as used."""
    if settings.midline is None:
        return
    height, width = recording.shape
    x, y = settings.midline[::2], settings.midline[1::2]
    if not (all(0 <= one <= width - 1 for one in x) and all(0 <= one <= height - 1 for one in y)):
        raise VideoError(
            f"Midline: {_told(settings.midline)} px; must have its ends within the frames as used (turned "
            f"and cut), x in [0, {width - 1}] and y in [0, {height - 1}]. Was it read off other frames?"
        )


def checked_masks(drawn: Mapping[int, Mask], recording: Recording) -> dict[int, Mask]:
    """By frame, bool (h, w); VideoError for a frame that the recording does not have, a shape or a type."""
    found = {}
    for index, mask in drawn.items():
        if not 0 <= index < recording.count:
            raise VideoError(
                f"Masks: the mask of frame {index}; must be of a frame in [0, {recording.count - 1}], those "
                f"of the recording ({recording.count}, counted from --from). Give it the number of its frame."
            )
        if mask.shape != recording.shape or mask.dtype != np.bool_:
            raise VideoError(
                f"Masks: that of frame {index} is {mask.dtype} of shape {mask.shape}; must be bool of "
                f"{recording.shape}, like the frames as used (turned and cut)."
            )
        found[int(index)] = np.asarray(mask)
    return found


def corrected(settings: Settings, drawn: object) -> Settings:
    """The settings with those that were corrected by hand, if what is drawn are `Corrections`.

    VideoError where one of them is given already, or frames are turned or cut otherwise than when they were
    corrected.
    """
    if not isinstance(drawn, Corrections):
        return settings
    for name, value in drawn.settings.items():
        if (given := getattr(settings, name)) is not None:
            raise VideoError(
                f"Corrections: {drawn.name} has {name} = {_told(value)}, and {_told(given)} is given; must "
                f"be one of the two. Leave --{name.replace('_', '-')} out, or undo it on the page."
            )
    for name in VIEW:
        given, shown = getattr(settings, name), drawn.view[name]
        if given != shown and name not in drawn.settings:
            raise VideoError(
                f"Corrections: {drawn.name} was drawn on frames with {name} = {_told(shown)}; must be "
                f"{_told(given)}, as given. Give the options of the analysis that was corrected: the page "
                "shows them."
            )
    return replace(settings, **drawn.settings)


def drawn_masks(
    drawn: str | Path | Corrections | Mapping[int, Mask], source: Path, recording: Recording
) -> dict[int, Mask] | None:
    """Masks drawn by hand, of a folder, of `Corrections` of this recording, or by frame; None where only
    other things were corrected. VideoError where they do not fit."""
    if isinstance(drawn, Corrections):
        drawn.require(source, recording)
        return checked_masks(drawn.masks, recording) if drawn.masks else None
    return checked_masks(
        drawn if isinstance(drawn, Mapping) else read_masks(Path(drawn), recording.shape), recording
    )


def _told(value: object) -> str:
    if value is None:
        return "not given"
    return ", ".join(f"{part:g}" for part in value) if isinstance(value, tuple) else f"{value}"
