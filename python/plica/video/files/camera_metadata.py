"""What a camera's own file says of its recording."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["Camera"]


@dataclass(frozen=True)
class Camera:
    """What the file of a high-speed camera states; None: it does not say.

    Attributes
    ----------
    fps : float or None
        Frames per second of the recording, not of playing it.
    date : str or None
        When it was recorded, as the file writes it.
    bits : int or None
        Depth of a pixel: its grey levels are 0 to 2^bits - 1.
    """

    fps: float | None
    date: str | None
    bits: int | None
