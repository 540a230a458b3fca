"""Where the folds part or meet between two frames, and how far each edge moves: what masks know of the flow.

A slit that opens from closed comes into sight, and one that closes goes out of sight: its brightness is found
again nowhere in the other frame, and smoothness across the line in which the folds meet joins tissue that
moves apart. The masks know both: which side of the midline a pixel is on, and how far each edge moves
(docs/imaging.md, "Folds that part and meet").
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from plica.video.midline import Midline, pixels

__all__ = ["Folds", "Parting"]

Floats = npt.NDArray[np.float32]
Mask = npt.NDArray[np.bool_]

_BESIDE = 1.5  # px from an edge, of tissue that moves with it
_ALONG = 1.5  # px, standard deviation of the blur along the midline: masks are of whole pixels
_SHUT = 0.25  # px; an edge nearer to the midline is at it


@dataclass(frozen=True)
class Parting:
    """What two masks know of the motion on the first frame's grid.

    Attributes
    ----------
    sides : (h, w)
        -1 left of the midline and 1 right of it, where there is glottis in either frame; else 0.
    measured : (h, w)
        1 where the motion across the midline is known: beside an edge that leaves the midline or comes to it.
    displacement : (h, w) px
        That motion, along `across`.
    gone : (h, w) bool
        Glottis that is closed in the second frame: nothing of it is found again.
    across : (float, float)
        Unit vector, to the right.
    """

    sides: Floats
    measured: Floats
    displacement: Floats
    gone: Mask
    across: tuple[float, float]


@dataclass(frozen=True)
class Folds:
    """What is known of the folds in a pair of frames.

    Attributes
    ----------
    first, second : (h, w) bool
        The glottis of each frame.
    midline : Midline
        In which the folds meet.
    """

    first: Mask
    second: Mask
    midline: Midline

    @property
    def back(self) -> Folds:
        """Of the motion from the second frame to the first."""
        return Folds(self.second, self.first, self.midline)

    def parting(self) -> Parting | None:
        """What it knows of the motion; None where no edge leaves the midline or comes to it."""
        return _parting(self.first, self.second, self.midline)


def _parting(first: Mask, second: Mask, midline: Midline) -> Parting | None:
    from scipy import ndimage

    place = midline.place(pixels(first.shape))
    along = np.floor(place[..., 0]).astype(int)
    along -= along.min()
    off = place[..., 1]
    sides = np.where(off < 0, -1, 1)
    bins = int(along.max()) + 1
    open_then = np.bincount(along[first], minlength=bins) > 0, np.bincount(along[second], minlength=bins) > 0
    turned = open_then[0] ^ open_then[1]
    if not turned.any():
        return None
    measured, displacement = np.zeros(first.shape, np.float32), np.zeros(first.shape, np.float32)
    for side in (-1, 1):
        own = sides == side
        # Pixels of a bin times its height over its number of lines is the edge's distance from the midline.
        edge, edge_then = (
            ndimage.gaussian_filter1d(np.bincount(along[mask & own], minlength=bins).astype(float), _ALONG)
            for mask in (first, second)
        )
        goes = turned & (np.maximum(edge, edge_then) > _SHUT)
        far = np.abs(off) - np.where(open_then[0], edge, 0.0)[along]
        beside = own & ~first & goes[along] & (far < _BESIDE)
        measured[beside] = 1
        displacement[beside] = (side * (edge_then - edge))[along][beside]
    either = ndimage.binary_dilation(open_then[0] | open_then[1], iterations=2)[along]
    return Parting(
        np.where(either, sides, 0).astype(np.float32),
        measured,
        displacement,
        first & turned[along],
        (float(midline.across[0]), float(midline.across[1])),
    )
