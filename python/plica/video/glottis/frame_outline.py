"""The glottis of one frame, and what finds it in every frame of a recording."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
import numpy.typing as npt

__all__ = ["Finder", "Outline"]

Floats = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]


@dataclass(frozen=True)
class Outline:
    """The glottis of a frame.

    Attributes
    ----------
    mask : (h, w) bool
    coverage : (h, w)
        How much of each pixel is glottis (:mod:`.coverage`).
    inner : (h, w)
        The same of what is darkest of it: shade beside the folds, which is glottis at a half, hardly moves
        its outline. The coverage itself where there is nothing to tell it by.
    least, largest : float
        px^2, band of its area: had the outline been drawn somewhat nearer to the dark, or to the tissue.
    confined : float
        Share of the outline that lies on the limit of where the glottis is looked for, and may go on beyond.
    """

    mask: Mask
    coverage: Floats
    inner: Floats
    least: float
    largest: float
    confined: float = 0.0


class Finder(Protocol):
    """What finds the glottis in the frames of one recording: how it looks there, or a network.

    Attributes
    ----------
    blur : float
        px, by which frames are blurred against noise before the outline is drawn where grey is halfway from
        the glottis' dark to the tissue; not a number where it is drawn by something else.
    """

    @property
    def blur(self) -> float:
        """px."""

    def outline(self, frame: npt.NDArray[np.float32], index: int) -> Outline:
        """The glottis of the frame of this number, (h, w) grey, 0 to 255 on the recording's scale."""

    def left_out(self, glottis: Mask) -> Mask:
        """(h, w) what is always dark beside what is glottis in some frame, and was taken for no glottis."""
