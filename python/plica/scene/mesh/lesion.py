"""A lesion of a fold: a patch of other tissue, which may protrude, and a chink behind the folds."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from plica.scene.part import Part
from plica.units import Density, Length, Number

__all__ = ["Chink", "Lesion"]

Floats = NDArray[np.float64]
PositiveLength = Annotated[Length, Field(gt=0, le=40e-3)]
Factor = Annotated[Number, Field(gt=0, le=1e3)]


class Chink(Part):
    """An opening at the back end of the glottis, in both folds and at all heights of theirs: as wide as said
    a third of its length from the back, 0 at both of its ends; its area is 9/16 of width times length."""

    width: Annotated[Length, Field(gt=0, le=5e-3)]
    """[m] Where it is widest, on top of the gap there."""
    length: PositiveLength
    """[m] From the back end of the glottis forward; at most that of the folds."""

    def half_width(self, from_back: Floats) -> Floats:
        """Of one fold (m), at distances (m) from the back end of the glottis."""
        share = np.clip(from_back / self.length, 0.0, 1.0)
        return 0.5 * self.width * 27 / 4 * share * (1 - share) ** 2


class Lesion(Part):
    """A patch of one fold that is stiffer, softer, heavier or more viscous than the tissue there, and may
    protrude: half an ellipsoid below the surface. Its border is sharp; a cell that it cuts has the mean of
    both tissues, by the share of the cell within."""

    fold: Literal["left", "right"]
    """Which fold it is in; left is the patient's."""
    from_front: Annotated[Length, Field(ge=0)] | None = None
    """[m] Of its middle from the front end of the glottis, along the folds; default: half their length."""
    below_edge: Annotated[Length, Field(ge=0)] | None = None
    """[m] Of its middle below the upper edge of the medial surface; default: half the thickness."""
    size: tuple[PositiveLength, PositiveLength, PositiveLength]
    """[m] Its length along the fold and its height, both across the middle, and its depth there, level with
    the ground."""
    layers: tuple[Annotated[str, Field(min_length=1)], ...] | None = None
    """Layers whose tissue it changes, e.g. `["cover"]`; default: all that it reaches."""
    stiffness: Factor = 1.0
    """[-] Factor of all elastic moduli of the tissue."""
    viscosity: Annotated[Number, Field(ge=0, le=1e3)] = 1.0
    """[-] Factor of its viscosity."""
    density: Annotated[Density, Field(gt=0)] | None = None
    """[kg/m^3] Its own mass per volume; default: that of the tissue."""
    protrusion: Annotated[Length, Field(ge=0, le=5e-3)] = 0.0
    """[m] By how much its middle stands out of the fold, toward the other one. It falls off as (1 - r^2)^2
    to the rim of the patch, r = 1, and the patch grows by it."""

    @property
    def changes_tissue(self) -> bool:
        """Whether its tissue is another than that around it."""
        return self.stiffness != 1 or self.viscosity != 1 or self.density is not None

    @property
    def sign(self) -> float:
        """Of x in its fold."""
        return -1.0 if self.fold == "left" else 1.0

    def _inside(self, y: Floats, z: Floats, middle: tuple[float, float]) -> Floats:
        """1 - r^2 of places, r = 1 at the rim; 0 beyond."""
        along, up, _ = self.size
        square = ((y - middle[0]) / (0.5 * along)) ** 2 + ((z - middle[1]) / (0.5 * up)) ** 2
        return np.maximum(1 - square, 0.0)

    def reach(self, y: Floats, z: Floats, middle: tuple[float, float]) -> Floats:
        """How deep (m) it goes at these places, from where the fold's surface is without it."""
        return np.asarray(self.size[2] * np.sqrt(self._inside(y, z, middle)))

    def bump(self, y: Floats, z: Floats, middle: tuple[float, float]) -> Floats:
        """By how much (m) it stands out there."""
        return np.asarray(self.protrusion * self._inside(y, z, middle) ** 2)
