"""What must hold of the settings and the drawn masks of a recording, before anything is computed."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt

from plica.video.errors import VideoError
from plica.video.files.recording import Recording
from plica.video.settings import Settings

__all__ = ["checked_masks", "require_modes"]

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


def checked_masks(drawn: Mapping[int, Mask], recording: Recording) -> dict[int, Mask]:
    """By frame, bool (h, w); VideoError for a frame that the recording does not have, a shape or a type."""
    found = {}
    for index, mask in drawn.items():
        if not 0 <= index < recording.count:
            raise VideoError(f"Masks: frame {index}; must be in [0, {recording.count}).")
        if mask.shape != recording.shape or mask.dtype != np.bool_:
            raise VideoError(
                f"Masks: that of frame {index} is {mask.dtype} of shape {mask.shape}; must be bool of "
                f"{recording.shape}, like the frames as used (turned and cut)."
            )
        found[int(index)] = np.asarray(mask)
    return found
