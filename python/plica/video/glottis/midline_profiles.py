"""Grey levels and glottis on either side of the midline, in lines across it, of every frame."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from plica.video.glottis.brightness import dark_level
from plica.video.glottis.glottal_area import middle_lines
from plica.video.glottis.midline import Midline, pixels

__all__ = ["GreyLines", "MidlineGrey"]

Floats = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

_CORE = 3.0  # px from the midline, which hold a slit of 2 s that is blurred by s up to 1.1 px
_RIM = 3.0  # px beyond
_BEYOND = 3  # px beyond both ends of the midline, where the outline has lost pointed ends
_WIDE = 20.0  # px from the midline, over which the pixels of a line are counted


@dataclass(frozen=True)
class GreyLines:
    """What :class:`MidlineGrey` has of all frames; lines are a pixel apart, sides left and right.

    Attributes
    ----------
    width : (2, frames, lines) px
        Of the glottis on either side of the midline.
    core : (2, frames, lines) grey levels times px
        Summed over the three pixels next to the midline.
    extent : (2, lines) px
        Of what that is summed over.
    rim : (2, frames, lines) grey levels
        Mean over the three pixels beyond.
    light : (frames) grey levels
        Mean of the tissue by which the light is compared; not a number without any.
    dark : float
        Grey level of the widest glottis; not a number without one.
    middle : (lines) bool
        The middle tenth of the midline's length.
    """

    width: Floats
    core: Floats
    extent: Floats
    rim: Floats
    light: Floats
    dark: float
    middle: Mask


class MidlineGrey:
    """Collects them frame by frame; six numbers for each pixel of the midline's length and each frame.

    Parameters
    ----------
    midline : Midline
    tissue : (h, w) bool
        By which the light of the frames is compared.
    """

    def __init__(self, midline: Midline, tissue: Mask) -> None:
        along, off = np.moveaxis(midline.place(pixels(tissue.shape)), -1, 0)
        number = np.floor(along).astype(int) + _BEYOND
        self._count = int(np.floor(midline.length)) + 1 + 2 * _BEYOND
        self._number = np.where((number >= 0) & (number < self._count), number, self._count)
        right = np.clip(0.5 + off, 0.0, 1.0)  # of a pixel's area
        self._sides = (1 - right, right)
        wide = np.abs(off) < _WIDE
        # Of a line that leans, not every one has as many pixels: a px across it is so many.
        self._density = np.maximum(self._sums(wide, np.ones(int(wide.sum()))) / (2 * _WIDE), 1e-9)
        share = np.clip(_CORE + 0.5 - np.abs(off), 0.0, 1.0)
        core, rim = share > 0, (np.abs(off) > _CORE) & (np.abs(off) <= _CORE + _RIM)
        self._cores = [(core, (side * share)[core]) for side in self._sides]
        self._rims = [rim & (off < 0), rim & (off > 0)]
        self._middle = middle_lines(np.arange(self._count) - _BEYOND + 0.5, midline)
        self._frames: list[npt.NDArray[np.float32]] = []
        self._tissue, self._light = tissue, list[float]()
        self._widest, self._dark = 0, float("nan")

    def _sums(self, where: Mask, weights: npt.NDArray[np.floating]) -> Floats:
        """(lines) of the weights of those pixels."""
        found = np.bincount(self._number[where], weights.astype(float), self._count + 1)
        return np.asarray(found[: self._count])

    def add(self, frame: npt.NDArray[np.floating], covered: Floats) -> None:
        """Those of a frame (h, w) and of how much of its pixels is glottis."""
        glottis = covered >= 0.5
        there = covered > 0
        width = [self._sums(there, (side * covered)[there]) / self._density for side in self._sides]
        core = [self._sums(near, weight * frame[near]) / self._density for near, weight in self._cores]
        rim = [
            self._sums(own, frame[own]) / np.maximum(self._sums(own, np.ones(int(own.sum()))), 1.0)
            for own in self._rims
        ]
        self._frames.append(np.array([width, core, rim], dtype=np.float32))
        self._light.append(float(frame[self._tissue].mean()) if self._tissue.any() else float("nan"))
        if (size := int(glottis.sum())) > self._widest:
            self._widest, self._dark = size, dark_level(frame, glottis)

    def lines(self) -> GreyLines:
        """Those of all frames that were added."""
        width, core, rim = np.moveaxis(np.array(self._frames, dtype=float), 0, 2)
        extent = np.array([self._sums(*near) for near in self._cores]) / self._density
        return GreyLines(width, core, extent, rim, np.array(self._light), self._dark, self._middle)
