"""Kymograms: grey along lines across the midline, over time."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
import numpy.typing as npt

from plica.video.errors import VideoError
from plica.video.files.recording import Grey
from plica.video.glottis.midline import Midline

__all__ = ["check_places", "kymogram"]

Floats = npt.NDArray[np.float64]


def check_places(places: Sequence[float]) -> None:
    """VideoError unless there are some, along the midline, 0 at its upper end and 1 at its lower."""
    if not (places and all(0 <= place <= 1 for place in places)):
        said = ", ".join(f"{place:g}" for place in places)
        raise VideoError(
            f"Video: kymogram = {said}; must be places in [0, 1], from the midline's upper to its lower end."
        )


def kymogram(
    frames: Iterable[Grey], midline: Midline, places: Sequence[float] = (0.5,), half_width: float = 60
) -> Floats:
    """Grey along lines across the midline, frame by frame, interpolated linearly; 0 beyond the frame.

    Parameters
    ----------
    frames : (h, w) each
    midline : Midline
    places : sequence of float
        Of the lines, in [0, 1]: 0 at the midline's upper end and 1 at its lower.
    half_width : float
        px, on either side of the midline.

    Returns
    -------
    (places, frames, 2 half_width + 1), from the image's left to its right.

    Raises
    ------
    VideoError
        For a place beyond the midline's ends.
    """
    from scipy import ndimage

    check_places(places)

    offsets = np.arange(-int(half_width), int(half_width) + 1.0)
    along = midline.length * np.asarray(places, dtype=float)
    lines = midline.points(np.stack(np.meshgrid(along, offsets, indexing="ij"), axis=-1))
    at = [lines[..., 1], lines[..., 0]]
    rows = [ndimage.map_coordinates(frame, at, order=1, mode="constant", cval=0.0) for frame in frames]
    return np.stack(rows, axis=1).astype(float)
