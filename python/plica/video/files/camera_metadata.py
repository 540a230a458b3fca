"""What a camera's own file, or a DICOM file, says of its recording."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

__all__ = ["Camera"]


@dataclass(frozen=True)
class Camera:
    """What the file of a recording states; None: it does not say.

    Attributes
    ----------
    fps : float or None
        Frames per second of the recording, not of playing it.
    date : str or None
        When it was recorded, as the file writes it.
    bits : int or None
        Depth of a pixel: its grey levels are 0 to 2^bits - 1.
    unused : dict
        What the file states and why it is not taken, a sentence for each setting ("fps", "mm_per_px") that
        has to be given instead.
    """

    fps: float | None
    date: str | None
    bits: int | None
    unused: Mapping[str, str] = field(default_factory=dict)
