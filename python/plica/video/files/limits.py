"""What no recording exceeds: the sizes that files state are held against these before they are read."""

from __future__ import annotations

from plica.video.errors import VideoError

__all__ = ["MOST_FRAMES", "MOST_PIXELS", "check"]

MOST_FRAMES = 1_000_000
"""50 s at 20,000 frames/s"""
MOST_PIXELS = 1 << 26
"""Of a frame: 8192 x 8192"""
_LEAST = 16  # px, of a side


def check(name: str, count: int, shape: tuple[int, int]) -> None:
    """Raises VideoError for fewer than two frames or for frames too small, too large or too many to be a
    recording."""
    if count < 2:
        raise VideoError(
            f"Recording: {name} has {count} frame{'' if count == 1 else 's'}; must be two or more."
        )
    if count > MOST_FRAMES:
        raise VideoError(
            f"Recording: {name} has {count} frames or more; must be at most {MOST_FRAMES}. Store the part "
            "that is to be analysed in a file of its own."
        )
    if shape[0] * shape[1] > MOST_PIXELS:
        raise VideoError(
            f"Recording: {name} has frames of {shape[1]} x {shape[0]} px; must have at most {MOST_PIXELS} "
            "px. Store the region that is to be analysed in a file of its own."
        )
    if min(shape) < _LEAST:
        raise VideoError(
            f"Recording: {name} has frames of {shape[1]} x {shape[0]} px; must be "
            f"{_LEAST} x {_LEAST} px or more."
        )
