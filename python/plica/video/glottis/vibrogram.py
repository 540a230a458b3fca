"""The phonovibrogram: how far both folds' edges are from the midline, along it and over time.

After Lohscheller and others (IEEE Trans. Med. Imaging 27, 2008): a column a frame, a row a place along the
midline. A distance is the glottal area of a slice across the midline on that side over the slice's width.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import numpy.typing as npt

from plica.video.glottis.midline import Midline, pixels

__all__ = ["vibrogram"]

Floats = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

_WIDTH = 2.0  # px of the midline in a row, at least


def vibrogram(glottis: Iterable[Mask], midline: Midline, known: Mask, most: int = 100) -> Floats:
    """(2, places, frames) px, of the left and of the right fold, places from the midline's upper end.

    Parameters
    ----------
    glottis : (h, w) bool, of each frame
    midline : Midline
    known : (frames) bool
        Where not, the column is not a number.
    most : int
        Places at most; of two pixels each at least.
    """
    places = max(min(most, int(midline.length / _WIDTH)), 1)
    width = midline.length / places
    columns: list[Floats] = []
    row: npt.NDArray[np.int_] | None = None
    right: Floats | None = None
    for index, mask in enumerate(glottis):
        if row is None or right is None:
            place = midline.place(pixels(mask.shape))
            row = np.clip((place[..., 0] / width).astype(int), 0, places - 1)
            right = np.clip(0.5 + place[..., 1], 0.0, 1.0)  # of a pixel's area
        if not known[index]:
            columns.append(np.full((2, places), np.nan))
            continue
        sides = [np.bincount(row[mask], part[mask], places) / width for part in (1 - right, right)]
        columns.append(np.stack(sides))
    return np.stack(columns, axis=-1)
