"""Glottal area and the folds' edges, left and right of the midline.

Left and right are those of the image.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import KW_ONLY, dataclass, replace
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from plica.video.glottis.fold_edges import SlitsOverTime
from plica.video.glottis.midline import Covered, Midline

__all__ = ["GlottalArea", "LostToBlur", "areas", "middle", "middle_lines", "read_area"]

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
        How far each fold's edge lies from the midline on its own side, negative beyond it: the mean over the
        middle tenth of its length (:mod:`plica.video.glottis.fold_edges`).
    inner : GlottalArea or None
        The same of the darkest part of the glottis; None: not known.
    lost : LostToBlur or None
        What blur takes from it; None: not known.
    contact : (frames) px, or None
        To the right, over the middle tenth, how far the line in which the folds touch is off one that
        rests (:class:`FoldEdges`); None: not known.
    """

    names: ClassVar[tuple[str, ...]] = ("left", "right", "left_edge", "right_edge")

    left: Floats
    right: Floats
    left_edge: Floats
    right_edge: Floats
    _: KW_ONLY
    inner: GlottalArea | None = None
    lost: LostToBlur | None = None
    contact: Floats | None = None

    @property
    def parts(self) -> dict[str, Floats]:
        """By their names, without the inner ones."""
        return {name: getattr(self, name) for name in self.names}

    @property
    def opened(self) -> Mask:
        """(frames) whether the edges are apart, in the middle tenth."""
        return np.asarray(self.left_edge + self.right_edge > 1e-9)

    @property
    def stored(self) -> dict[str, Floats]:
        """What a file has of it, by name, without the inner ones."""
        return {
            **self.parts,
            "contact": np.zeros(self.left.size) if self.contact is None else self.contact,
        }

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
            contact=None if self.contact is None else -self.contact,
        )

    @property
    def total(self) -> Floats:
        """(frames) px^2."""
        return self.left + self.right

    @property
    def share_of_left(self) -> float:
        """What the left edge moves, over what both move; a half where none does."""
        left, right = (float(np.ptp(edge[np.isfinite(edge)])) for edge in (self.left_edge, self.right_edge))
        return left / (left + right) if left + right > 0 else 0.5

    @property
    def unblurred(self) -> GlottalArea:
        """With what blur takes from it; the darkest part is no larger than all of it."""
        if self.lost is None:
            return self
        found = self._with(self.lost.outline)
        if self.inner is None:
            return found
        return replace(found, inner=self.inner._with(self.lost.inner).within(found))

    def within(self, other: GlottalArea) -> GlottalArea:
        """No larger on either side than the other, and with edges between its where that is open."""
        sides = np.minimum(self.left, other.left), np.minimum(self.right, other.right)
        left = -np.clip(-self.left_edge, -other.left_edge, other.right_edge)
        right = np.clip(self.right_edge, -other.left_edge, other.right_edge)
        both = (left, self.left_edge), (right, self.right_edge)
        edges = (np.where(other.opened, within, own) for within, own in both)
        return GlottalArea(*sides, *edges, inner=self.inner, lost=self.lost, contact=self.contact)

    def while_open(self, other: GlottalArea) -> GlottalArea:
        """The same within the other, and with its edges where those touch."""
        found = self.within(other)
        left = np.where(other.opened, found.left_edge, other.left_edge)
        right = np.where(other.opened, found.right_edge, other.right_edge)
        return replace(found, left_edge=left, right_edge=right)

    def _with(self, lost: GlottalArea) -> GlottalArea:
        """With what is lost; no area is below zero, and no edge beyond the other fold's."""
        left, right = np.maximum(self.left + lost.left, 0.0), np.maximum(self.right + lost.right, 0.0)
        edges = self.left_edge + lost.left_edge, self.right_edge + lost.right_edge
        over = np.minimum(edges[0] + edges[1], 0.0) / 2
        return GlottalArea(left, right, edges[0] - over, edges[1] - over, contact=self.contact)

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
            contact=None if self.contact is None else _between(self.contact, known),
        )


def read_area(stored: Callable[[str], Floats]) -> GlottalArea:
    """The area with its inner part and what blur takes, of what a file has of them by name (`stored`)."""

    def part(kind: str, **further: Any) -> GlottalArea:
        return GlottalArea(*(stored(f"{kind}{name}") for name in GlottalArea.names), **further)

    band, most, shade = (stored(name) for name in ("blur_band", "lost_most", "lost_shade"))
    lost = LostToBlur(part("lost_"), part("inner_lost_"), band, most, float(shade))
    inner = part("inner_", contact=stored("inner_contact"))
    return part("", inner=inner, lost=lost, contact=stored("contact"))


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


def middle_lines(along: npt.NDArray[np.floating], midline: Midline) -> Mask:
    """(lines) the middle tenth, or what is nearest to it, of lines so many px from the upper end."""
    off = np.abs(along / midline.length - 0.5)
    return np.asarray(off <= max(0.05, float(off.min(initial=1.0))))


def middle(place: Floats, midline: Midline) -> Mask:
    """(h, w) the middle tenth along the line, of places (h, w, 2) that :meth:`Midline.place` gives."""
    return np.asarray(np.abs(place[..., 0] / midline.length - 0.5) < 0.05)


def areas(glottis: Iterable[Covered], midline: Midline, blur: float = 0.0) -> GlottalArea:
    """Area and edges of each mask, or coverage, (h, w) left and right of the midline.

    `blur` (px, standard deviation) of the masks' edges tells where slits close that it made narrower.
    """
    slits = SlitsOverTime(midline, blur)
    for mask in glottis:
        slits.add(mask)
    edges = slits.edges()
    tenth = middle_lines(edges.along, midline)
    of_edges = (edge[:, tenth].mean(axis=1) for edge in (edges.left, edges.right, edges.contact))
    left_edge, right_edge, contact = of_edges
    return GlottalArea(*slits.areas(), left_edge, right_edge, contact=contact)
