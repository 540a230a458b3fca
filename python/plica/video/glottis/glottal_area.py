"""Glottal area and the folds' edges, left and right of the midline.

Left and right are those of the image.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import KW_ONLY, dataclass

import numpy as np
import numpy.typing as npt

from plica.video.glottis.midline import Midline, pixels

__all__ = ["GlottalArea", "LostToBlur", "areas", "middle"]

Floats = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

_SHADED = 0.25  # of what darkens the midline; films without shade have up to 0.14, with it from 0.40 on


@dataclass(frozen=True)
class GlottalArea:
    """Glottal area, left and right of the midline in the image.

    Attributes
    ----------
    left, right : (frames) px^2
        Not a number where it is not known.
    left_edge, right_edge : (frames) px
        Mean distance of the folds' edges from the midline, over the middle tenth of its length.
    inner : GlottalArea or None
        The same of the darkest part of the glottis; None: not known.
    lost : LostToBlur or None
        What blur takes from it; None: not known.
    """

    left: Floats
    right: Floats
    left_edge: Floats
    right_edge: Floats
    _: KW_ONLY
    inner: GlottalArea | None = None
    lost: LostToBlur | None = None

    @property
    def parts(self) -> dict[str, Floats]:
        """By their names, without the inner ones."""
        names = ("left", "right", "left_edge", "right_edge")
        return {name: getattr(self, name) for name in names}

    @property
    def mirrored(self) -> GlottalArea:
        """Left and right changed."""
        return GlottalArea(
            self.right,
            self.left,
            self.right_edge,
            self.left_edge,
            inner=None if self.inner is None else self.inner.mirrored,
            lost=None if self.lost is None else self.lost.mirrored,
        )

    @property
    def total(self) -> Floats:
        """(frames) px^2."""
        return self.left + self.right

    @property
    def unblurred(self) -> GlottalArea:
        """With what blur takes from it; the darkest part is no larger than all of it."""
        if self.lost is None:
            return self
        lost = self.lost.outline
        found = [np.maximum(part + lost.parts[name], 0.0) for name, part in self.parts.items()]
        if self.inner is None:
            return GlottalArea(*found)
        lost, parts = self.lost.inner, self.inner.parts
        inner = [
            np.minimum(parts[name] + lost.parts[name], most) for name, most in zip(parts, found, strict=True)
        ]
        return GlottalArea(*found, inner=GlottalArea(*inner))

    def less(self, other: GlottalArea) -> GlottalArea:
        """Its parts less those of the other, without inner ones."""
        return GlottalArea(*(part - other.parts[name] for name, part in self.parts.items()))

    def filled(self) -> GlottalArea:
        """With frames whose area is not known (not a number) between their neighbours."""
        known = np.isfinite(self.total)
        return self if known.all() or not known.any() else self.between(known)

    def between(self, known: Mask) -> GlottalArea:
        """With all frames but these between their neighbours."""
        return GlottalArea(
            *(_between(part, known) for part in self.parts.values()),
            inner=None if self.inner is None else self.inner.between(known),
            lost=None if self.lost is None else self.lost.between(known),
        )


@dataclass(frozen=True)
class LostToBlur:
    """What blur takes from the outline (:mod:`plica.video.glottis.hidden_slits`).

    Attributes
    ----------
    outline, inner : GlottalArea
        px^2 and px, to be added to the outline halfway and to that of the darkest part.
    band : (frames) px^2
        How far apart blur alone puts the areas between which the true one lies.
    most : (frames) px^2
        What may be open besides where the folds seem closed: slits that are hidden all the time.
    shade : float
        Share of what darkens the midline that darkens the tissue beside it as much, as no slit does; not a
        number where the folds never close.
    """

    outline: GlottalArea
    inner: GlottalArea
    band: Floats
    most: Floats
    shade: float

    @property
    def by_blur_alone(self) -> bool:
        """Whether slits are what darkens the midline, and no shade between folds that close."""
        return self.shade < _SHADED

    @property
    def mirrored(self) -> LostToBlur:
        """Left and right changed."""
        return LostToBlur(self.outline.mirrored, self.inner.mirrored, self.band, self.most, self.shade)

    def between(self, known: Mask) -> LostToBlur:
        """With all frames but these between their neighbours."""
        parts = self.outline.between(known), self.inner.between(known)
        return LostToBlur(*parts, _between(self.band, known), _between(self.most, known), self.shade)


def _between(values: Floats, known: Mask) -> Floats:
    frames = np.arange(known.size)
    return np.interp(frames, frames[known], values[known])


def middle(place: Floats, midline: Midline) -> Mask:
    """(h, w) the middle tenth along the line, of places (h, w, 2) that :meth:`Midline.place` gives."""
    return np.asarray(np.abs(place[..., 0] / midline.length - 0.5) < 0.05)


def areas(glottis: Iterable[Mask], midline: Midline) -> GlottalArea:
    """Area and edges of each mask (h, w) left and right of the midline; a pixel on it counts for both."""
    rows: list[tuple[float, float, float, float]] = []
    right: Floats | None = None
    tenth: Mask | None = None
    band = 0.0  # px, extent of the band along the line, as its pixels have it
    for mask in glottis:
        if right is None or tenth is None:
            place = midline.place(pixels(mask.shape))
            right = np.clip(0.5 + place[..., 1], 0.0, 1.0)  # of a pixel's area
            tenth = middle(place, midline)
            band = float(tenth.sum()) * midline.along[1] / mask.shape[1]
        sides = [(1 - right)[mask], right[mask]]
        edges = [float(side[tenth[mask]].sum()) / band for side in sides]
        rows.append((float(sides[0].sum()), float(sides[1].sum()), edges[0], edges[1]))
    return GlottalArea(*(np.array(column) for column in zip(*rows, strict=True)))
