"""Grey levels and glottis on either side of where the folds part and meet, in lines across the midline.

Folds that swing out of phase part on one side of the midline and meet on the other, so that the place is each
frame's and each line's own: the middle of the slit, or the line of contact (:mod:`.fold_edges`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from plica.video.glottis.brightness import dark_level
from plica.video.glottis.fold_edges import FoldEdges
from plica.video.glottis.glottal_area import middle_lines
from plica.video.glottis.midline import Midline, pixels

__all__ = ["GreyLines", "MidlineGrey"]

Floats = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

_CORE = 3.0  # px from the slit's place, which hold a slit of 2 s that is blurred by s up to 1.1 px
_RIM = 3.0  # px beyond
_BEYOND = 3  # px beyond both ends of the midline, where the outline has lost pointed ends
_WIDE = 20.0  # px from the midline, over which the pixels of a line are counted


@dataclass(frozen=True)
class GreyLines:
    """What :class:`MidlineGrey` has of all frames; lines are a pixel apart, sides left and right of `place`.

    Attributes
    ----------
    place : (frames, lines) px
        Right of the midline: of the slit, or where the folds touch.
    width : (2, frames, lines) px
        Of the glottis on either side of the place.
    core : (2, frames, lines) grey levels times px
        Summed over the three pixels next to the place.
    extent : (2, frames, lines) px
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

    place: Floats
    width: Floats
    core: Floats
    extent: Floats
    rim: Floats
    light: Floats
    dark: float
    middle: Mask


class MidlineGrey:
    """Collects them frame by frame; eight numbers for each pixel of the midline's length and each frame.

    Parameters
    ----------
    midline : Midline
    tissue : (h, w) bool
        By which the light of the frames is compared.
    edges : FoldEdges, optional
        Of all frames: between them lie the slits, or the folds touch. None: on the midline, always.
    """

    def __init__(self, midline: Midline, tissue: Mask, edges: FoldEdges | None = None) -> None:
        along, off = np.moveaxis(midline.place(pixels(tissue.shape)), -1, 0)
        number = np.floor(along).astype(int) + _BEYOND
        self._count = int(np.floor(midline.length)) + 1 + 2 * _BEYOND
        self._number = np.where((number >= 0) & (number < self._count), number, self._count)
        self._off = off
        wide = np.abs(off) < _WIDE
        # Of a line that leans, not every one has as many pixels: a px across it is so many.
        self._density = np.maximum(
            _sums(self._number[wide], np.ones(int(wide.sum())), self._count) / (2 * _WIDE), 1e-9
        )
        lines = np.arange(float(self._count)) - _BEYOND + 0.5
        self._middle = middle_lines(lines, midline)
        self._places = None if edges is None else _places(edges, lines)
        farthest = 0.0 if self._places is None else float(np.abs(self._places).max(initial=0.0))
        near = (np.abs(off) < farthest + _CORE + _RIM + 1) & (self._number < self._count)
        self._near = near, self._number[near], off[near]
        self._frames: list[npt.NDArray[np.float32]] = []
        self._tissue, self._light = tissue, list[float]()
        self._widest, self._dark = 0, float("nan")

    def _place(self, index: int) -> Floats:
        """(lines + 1) px, of a frame; of what lies on no line, 0."""
        return np.zeros(self._count + 1) if self._places is None else np.append(self._places[index], 0.0)

    def add(self, frame: npt.NDArray[np.floating], covered: Floats) -> None:
        """Those of the next frame (h, w) and of how much of its pixels is glottis."""
        place = self._place(len(self._frames))
        there = covered > 0
        own = self._number[there]
        width = [
            _sums(own, side * covered[there], self._count) / self._density
            for side in _sides(self._off[there] - place[own])
        ]
        near, number, off = self._near
        off = off - place[number]
        grey, sides = frame[near].astype(float), _sides(off)
        share = np.clip(_CORE + 0.5 - np.abs(off), 0.0, 1.0)
        extent = [_sums(number, side * share, self._count) / self._density for side in sides]
        core = [_sums(number, side * share * grey, self._count) / self._density for side in sides]
        rim = (np.abs(off) > _CORE) & (np.abs(off) <= _CORE + _RIM)
        rims = []
        for beside in (rim & (off < 0), rim & (off > 0)):
            pixels_of = np.maximum(np.bincount(number[beside], minlength=self._count), 1)
            rims.append(_sums(number[beside], grey[beside], self._count) / pixels_of)
        self._frames.append(np.array([width, core, extent, rims], dtype=np.float32))
        self._light.append(float(frame[self._tissue].mean()) if self._tissue.any() else float("nan"))
        glottis = covered >= 0.5
        if (size := int(glottis.sum())) > self._widest:
            self._widest, self._dark = size, dark_level(frame, glottis)

    def lines(self) -> GreyLines:
        """Those of all frames that were added."""
        width, core, extent, rim = np.moveaxis(np.array(self._frames, dtype=float), 0, 2)
        place = np.array([self._place(index)[:-1] for index in range(len(self._frames))])
        return GreyLines(place, width, core, extent, rim, np.array(self._light), self._dark, self._middle)


def _sums(number: npt.NDArray[np.integer], weights: npt.NDArray[np.floating], count: int) -> Floats:
    """(lines) of the weights of pixels with these numbers of lines."""
    return np.asarray(np.bincount(number, weights.astype(float), count + 1)[:count])


def _sides(off: Floats) -> tuple[Floats, Floats]:
    """What of a pixel's area lies left and right of where `off` is 0."""
    right = np.clip(0.5 + off, 0.0, 1.0)
    return 1 - right, right


def _places(edges: FoldEdges, lines: Floats) -> Floats:
    """(frames, lines) px right of the midline: between the edges; where it never opens, as next to it."""
    opens = edges.open.any(axis=0)
    if not opens.any():
        return np.zeros((len(edges.open), lines.size))
    middle = (edges.right - edges.left) / 2
    return np.array([np.interp(lines, edges.along[opens], row) for row in middle[:, opens]])
