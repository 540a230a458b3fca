"""Glottal area and the folds' edges, left and right of the midline.

Left and right are those of the image.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from plica.video.midline import Midline, pixels

__all__ = ["GlottalArea", "areas", "middle"]

Floats = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]


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
    """

    left: Floats
    right: Floats
    left_edge: Floats
    right_edge: Floats
    inner: GlottalArea | None = field(default=None, kw_only=True)

    @property
    def parts(self) -> dict[str, Floats]:
        """By their names, without the inner ones."""
        names = ("left", "right", "left_edge", "right_edge")
        return {name: getattr(self, name) for name in names}

    @property
    def mirrored(self) -> GlottalArea:
        """Left and right changed."""
        inner = None if self.inner is None else self.inner.mirrored
        return GlottalArea(self.right, self.left, self.right_edge, self.left_edge, inner=inner)

    @property
    def total(self) -> Floats:
        """(frames) px^2."""
        return self.left + self.right

    def filled(self) -> GlottalArea:
        """With frames whose area is not known (not a number) between their neighbours."""
        known = np.isfinite(self.total)
        if known.all() or not known.any():
            return self
        frames = np.arange(known.size)
        inner = None if self.inner is None else self.inner.filled()
        return GlottalArea(
            *(np.interp(frames, frames[known], part[known]) for part in self.parts.values()), inner=inner
        )


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
