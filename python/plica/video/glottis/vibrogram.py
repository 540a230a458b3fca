"""The phonovibrogram: how far both folds' edges are from the midline, along it and over time.

After Lohscheller and others (IEEE Trans. Med. Imaging 27, 2008): a column a frame, a row a place along the
midline. A distance is the mean of a fold's own edge over a slice across the midline (:mod:`.fold_edges`),
negative where the fold is beyond the midline.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import numpy.typing as npt

from plica.video.glottis.fold_edges import fold_edges
from plica.video.glottis.midline import Covered, Midline

__all__ = ["vibrogram"]

Floats = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

_WIDTH = 2.0  # px of the midline in a row, at least


def vibrogram(
    glottis: Iterable[Covered], midline: Midline, known: Mask, most: int = 100, blur: float = 0.0
) -> Floats:
    """(2, places, frames) px, of the left and of the right fold, places from the midline's upper end.

    Parameters
    ----------
    glottis : (h, w), of each frame
        Masks, or how much of each pixel is glottis.
    midline : Midline
    known : (frames) bool
        Where not, the column is not a number.
    most : int
        Places at most; of two pixels each at least.
    blur : float
        px, standard deviation, of the edges (:func:`.fold_edges.fold_edges`).
    """
    edges = fold_edges(glottis, midline, blur)
    places = max(min(most, int(midline.length / _WIDTH)), 1)
    ends = np.linspace(0.0, midline.length, places + 1)
    low, high = (np.clip(edges.along + half, ends[:-1, None], ends[1:, None]) for half in (-0.5, 0.5))
    shares = (high - low) / np.maximum((high - low).sum(axis=1, keepdims=True), 1e-9)
    found = np.stack([shares @ edge.T for edge in (edges.left, edges.right)])
    return np.where(known, found, np.nan)
