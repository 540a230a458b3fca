"""Where the folds part or meet between two frames, and how far each edge moves: what masks know of the flow.

A slit that opens from closed comes into sight, and one that closes goes out of sight: its brightness is found
again nowhere in the other frame, and smoothness across the line in which the folds meet joins tissue that
moves apart. The masks know both: which side of the midline a pixel is on, and how far each edge moves. A slit
too narrow for a mask still darkens the line (docs/recordings_motion.md, "Folds that part and meet").
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from plica.video.glottis.brightness import dark_level
from plica.video.glottis.midline import Midline, pixels

__all__ = ["Folds", "Parting"]

Floats = npt.NDArray[np.float32]
Mask = npt.NDArray[np.bool_]
Lines = npt.NDArray[np.float64]

_BESIDE = 1.5  # px from an edge, of tissue that moves with it
_ALONG = 1.5  # px, standard deviation of the blur along the midline: masks are of whole pixels
_SHUT = 0.25  # px; an edge nearer to the midline is at it
_REACH = 4.0  # px from the midline within which a slit too narrow for a mask darkens
_RIM = 1.0  # px about that reach, where the tissue is that moves in or out
_TISSUE = (6.0, 25.0)  # px from the midline, of the tissue by which the light is compared
_LIT_ALONG = 8.0  # px, standard deviation of that comparison along the midline
_LEAST = 0.15  # px; darkening that says less is noise
_FAINT = 20.0  # grey levels by which tissue is brighter than the glottis, at least


@dataclass(frozen=True)
class Parting:
    """What two frames and their masks know of the motion on the first frame's grid.

    Attributes
    ----------
    sides : (h, w)
        -1 left of the midline and 1 right of it, as far as the folds meet in it; else 0.
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
        In which the folds meet, as far as they do.
    dark : float or None
        Grey level of a glottis that is wide open (:func:`dark_level`), of a range of 255; None: as dark as
        these two frames show it. A slit is brighter, as blur mixes tissue into it: from two narrow slits the
        folds' ways come out up to twice too long.
    """

    first: Mask
    second: Mask
    midline: Midline
    dark: float | None = None

    @property
    def back(self) -> Folds:
        """Of the motion from the second frame to the first."""
        return Folds(self.second, self.first, self.midline, self.dark)

    def parting(self, one: Floats, two: Floats) -> Parting | None:
        """What they and the frames (h, w), in grey levels of a range of 255, know of the motion.

        None where no edge leaves the midline or comes to it.
        """
        lines = _Lines(self.midline, self.first.shape)
        open_then = lines.sums(self.first) > 0, lines.sums(self.second) > 0
        turned = open_then[0] ^ open_then[1]
        ways = _darkening(lines, self, one, two)
        unseen = lines.within & ~open_then[0] & ~open_then[1]
        measured, displacement = np.zeros_like(one, np.float32), np.zeros_like(one, np.float32)
        for side in (-1, 1):
            own = lines.side == side
            # Pixels of a line over its number of rows is the edge's distance from the midline.
            edge, edge_then = (
                lines.blurred(lines.sums(mask & own), _ALONG) for mask in (self.first, self.second)
            )
            darkened = ways(own)
            narrow = unseen & (np.abs(darkened) > _LEAST)
            goes = narrow | (turned & (np.maximum(edge, edge_then) > _SHUT))
            way = np.where(narrow, darkened, edge_then - edge)
            far = np.abs(lines.off) - np.where(open_then[0], edge, 0.0)[lines.number]
            beside = own & ~self.first & goes[lines.number] & (far < _BESIDE)
            measured[beside] = 1
            displacement[beside] = (side * way)[lines.number][beside]
        if not turned.any() and not measured.any():
            return None
        meet = lines.within | open_then[0] | open_then[1]
        return Parting(
            np.where(meet[lines.number], lines.side, 0).astype(np.float32),
            measured,
            displacement,
            self.first & turned[lines.number],
            (float(self.midline.across[0]), float(self.midline.across[1])),
        )


class _Lines:
    """The frame in lines across the midline, a pixel apart."""

    def __init__(self, midline: Midline, shape: tuple[int, ...]) -> None:
        along, self.off = np.moveaxis(midline.place(pixels(shape)), -1, 0)
        number = np.floor(along).astype(int)
        self.number = number - number.min()
        self.count = int(self.number.max()) + 1
        self.side = np.where(self.off < 0, -1, 1)
        place = np.arange(self.count) + number.min()
        self.within = (place >= 0) & (place <= midline.length)

    def sums(self, mask: Mask, values: npt.NDArray[np.floating] | None = None) -> Lines:
        """Of each line: how many pixels of the mask it has, or the sum of the values there."""
        weights = None if values is None else values[mask].astype(float)
        return np.bincount(self.number[mask], weights, self.count).astype(float)

    def blurred(self, values: Lines, width: float) -> Lines:
        """Along the midline, by a Gaussian of this standard deviation (px)."""
        from scipy import ndimage

        return np.asarray(ndimage.gaussian_filter1d(values, width))


def _darkening(lines: _Lines, folds: Folds, one: Floats, two: Floats) -> Callable[[Mask], Lines]:
    """How far (px) the fold of a side moves away from the midline, by how much darker it gets there.

    Tissue that leaves the `_REACH` next to the midline takes its brightness with it, and glottis takes its
    place: the sum of the grey levels there falls by the way times the tissue's contrast at the rim, however
    blurred the slit. What the light changes is taken from the tissue beside.
    """
    far = np.abs(lines.off)
    shown = [dark_level(one, folds.first), dark_level(two, folds.second)]
    dark = float(np.fmin(shown[0], shown[1])) if folds.dark is None else folds.dark
    dark = dark if np.isfinite(dark) else 0.0  # where neither shows a glottis: as dark as the recording gets
    tissue = (
        lines.within[lines.number] & (far > _TISSUE[0]) & (far < _TISSUE[1]) & ~folds.first & ~folds.second
    )
    before, after = (
        lines.blurred(lines.sums(tissue, frame - np.float32(dark)), _LIT_ALONG) for frame in (one, two)
    )
    gain = np.where((before > 0) & (after > 0), after / np.maximum(before, 1e-9), 1.0)
    light = gain[lines.number]

    def way(own: Mask) -> Lines:
        near, rim = own & (far <= _REACH), own & (np.abs(far - _REACH) <= _RIM)
        fall = lines.sums(near, (one - dark) - (two - dark) / light)
        contrast = lines.sums(rim, ((one - dark) + (two - dark) / light) / 2)
        number = lines.blurred(lines.sums(rim), _ALONG)
        depth = lines.blurred(contrast, _ALONG) / np.maximum(number, 1e-9)
        wide = lines.blurred(lines.sums(near), _ALONG) / _REACH
        return np.asarray(lines.blurred(fall, _ALONG) / np.maximum(wide * depth, _FAINT))

    return way
