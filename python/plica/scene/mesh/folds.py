"""The shape of a parametric larynx by the sizes in which folds are described."""

from __future__ import annotations

import math
from typing import Annotated, Any, Self

import numpy as np
from pydantic import Field, model_validator

from plica.scene.mesh.fold_surface import FoldSurface
from plica.scene.mesh.lesion import Chink, Lesion
from plica.scene.part import Part, problem
from plica.units import Angle, Length

__all__ = ["SHAPE", "Folds"]

PositiveLength = Annotated[Length, Field(gt=0)]
SHAPE = (
    "sections",
    "major",
    "radius",
    "layer_thickness",
    "ligament_thickness",
    "layers_from_section",
    "layers_to_section",
)
"""The options of a larynx that follow from its folds."""

_BELOW, _ABOVE = -20e-3, 20e-3  # m, lowest and highest section: the ends of the thesis's larynx
# Half-widths as in the thesis, in shares of the wall's radius: at the ends, where the surface below begins.
_ENDS, _BEGIN = 0.875, 0.75
_TOP = ((0.5e-3, 0.375), (1.3e-3, 0.625))  # of the surface above the folds: m above the upper edge, and share
_LEVEL = math.radians(80)  # from the vertical, where the upper edge ends
_PIECES = 2  # of a round edge
_LEAST_END = 0.3e-3  # m, of tissue between the ends of the glottis and the wall


class Folds(Part):
    """The shape of both folds, in the terms in which they are measured.

    Left and right are mirror images, and front and back, but for the last four keys. The airway is an ellipse
    at each height, as long as the glottis; in the middle plane a fold has an inferior surface, a lower edge,
    a medial surface, an upper edge at z = 0, and a superior surface that is nearly level. What is left out
    has the size of the thesis's larynx, whose edges are cut, not round."""

    length: Annotated[Length, Field(ge=4e-3, le=30e-3)] = 14e-3
    """[m] Of the glottis, from back to front."""
    thickness: Annotated[Length, Field(ge=0.3e-3, le=10e-3)] = 2.7e-3
    """[m] Height of the medial surface, between the edges."""
    gap: Annotated[Length, Field(gt=0, le=4e-3)] = 0.5e-3
    """[m] Between the folds before they move, in the middle, where it is narrowest. Beside `left_gap` and
    `right_gap` it only sets how far outward the wall is."""
    medial_angle: Annotated[Angle, Field(ge=-0.35, le=0.35)] = 0.0
    """[rad] Of each medial surface from the vertical, ``"3 deg"``. Positive: the glottis narrows upward, as
    before a voice; negative: it widens."""
    edge_radius: Annotated[Length, Field(ge=0, le=3e-3)] = 0.5e-3
    """[m] Of the lower and the upper edge, in two straight pieces each; 0: sharp."""
    inferior_angle: Annotated[Angle, Field(ge=0.35, le=1.3)] = math.radians(50)
    """[rad] From the vertical, of the surface below the folds, ``"50 deg"``."""
    depth: Annotated[Length, Field(ge=2e-3, le=20e-3)] = 7.75e-3
    """[m] Of the tissue, from the narrowest place of the glottis to the wall. The wall is round, with the
    radius of depth and half a gap, which must be 0.3 mm more than half the length."""
    cover: PositiveLength = 0.5e-3
    """[m] Thickness of the cover, measured level with the ground."""
    ligament: PositiveLength = 0.5e-3
    """[m] Thickness of the ligament, behind it."""
    left_gap: Annotated[Length, Field(gt=0, le=4e-3)] | None = None
    """[m] From the middle plane to the left fold, where it is nearest; default: half of `gap`. A paralysed
    fold lies further aside. What it lies further aside, it is thinner at the wall."""
    right_gap: Annotated[Length, Field(gt=0, le=4e-3)] | None = None
    """[m] From the middle plane to the right fold; default: half of `gap`."""
    posterior_chink: Chink | None = None
    """An opening at the back that is there before the voice; default: none."""
    lesions: tuple[Lesion, ...] = ()
    """Patches of other tissue; where they overlap, their factors multiply, and the density is the mean
    of theirs (docs/lesions.md)."""

    @model_validator(mode="after")
    def _fits_the_wall(self) -> Self:
        least = 0.5 * self.length + _LEAST_END - 0.5 * self.gap
        if self.depth < least:
            raise problem(
                f"must be >= {1e3 * least:.4g} mm, so that the round wall encloses the glottis of length "
                f"{1e3 * self.length:.4g} mm.",
                "depth",
                value=self.depth,
                unit=" m",
            )
        below = self._below(self._edges()[0][0])
        if len(below) > 1 and not below[1][0] > _BELOW:
            raise problem(
                f"must be larger: the inferior surface would reach to z = {1e3 * below[1][0]:.4g} mm, and "
                f"the larynx ends at {1e3 * _BELOW:.4g} mm. Or use less depth.",
                "inferior_angle",
                value=float(f"{math.degrees(self.inferior_angle):.4g}"),
                unit=" deg",
            )
        return self

    @model_validator(mode="after")
    def _has_room_for_what_differs(self) -> Self:
        chink = self.posterior_chink
        if chink is not None and chink.length > self.length:
            raise problem(
                f"must be <= {1e3 * self.length:.4g} mm, the length of the folds.",
                *("posterior_chink", "length"),
                value=chink.length,
                unit=" m",
            )
        for k, lesion in enumerate(self.lesions):
            self._check_place(lesion, k)
        if self.lesions:
            self._check_protrusions()
        return self

    def _check_place(self, lesion: Lesion, k: int) -> None:
        """Raise unless a lesion is in its fold."""
        for name, value, most, of in (
            ("from_front", lesion.from_front, self.length, "length of the folds"),
            ("below_edge", lesion.below_edge, self.thickness, "thickness of the folds"),
        ):
            if value is not None and value > most:
                raise problem(
                    f"must be <= {1e3 * most:.4g} mm, the {of}: the lesion is outside its fold.",
                    *("lesions", k, name),
                    value=value,
                    unit=" m",
                )
        if lesion.size[2] > self.depth:
            raise problem(
                f"must be <= {1e3 * self.depth:.4g} mm, the depth of the tissue.",
                *("lesions", k, "size", 2),
                value=lesion.size[2],
                unit=" m",
            )
        y, half = self.middle_of(lesion)[0], 0.5 * lesion.size[0]
        if lesion.protrusion > 0 and abs(y) + half > 0.5 * self.length * (1 + 1e-9):
            raise problem(
                f"must be <= {1e3 * (self.length - 2 * abs(y)):.4g} mm, so that what protrudes ends where "
                "the folds end. Or move its middle, from_front.",
                *("lesions", k, "size", 0),
                value=lesion.size[0],
                unit=" m",
            )

    def _check_protrusions(self) -> None:
        """Raise if a lesion would touch the other fold before the voice."""
        surface, share = self.surface(), np.linspace(-0.5, 0.5, 101)
        for k, lesion in enumerate(self.lesions):
            middle = self.middle_of(lesion)
            y, z = np.meshgrid(*(at + size * share for at, size in zip(middle, lesion.size, strict=False)))
            bump = lesion.bump(y, z, middle)
            free = surface.at(-1.0, y, z) + surface.at(1.0, y, z) + bump
            high = bump > 0
            most = float((lesion.protrusion * free[high] / bump[high]).min()) if high.any() else math.inf
            if not lesion.protrusion < most:
                raise problem(
                    f"must be < {1e3 * most:.4g} mm: there it touches the other fold before the voice. Take "
                    "a wider gap, left_gap or right_gap.",
                    *("lesions", k, "protrusion"),
                    value=lesion.protrusion,
                    unit=" m",
                )

    def middle_of(self, lesion: Lesion) -> tuple[float, float]:
        """y and z (m) of the middle of a lesion on its fold."""
        front = 0.5 * self.length
        return (
            front - (front if lesion.from_front is None else lesion.from_front),
            -(0.5 * self.thickness if lesion.below_edge is None else lesion.below_edge),
        )

    def surface(self) -> FoldSurface:
        """Where both folds' surfaces are, and their lesions."""
        left, right = (0.5 * self.gap if own is None else own for own in (self.left_gap, self.right_gap))
        return FoldSurface(
            self.shape(),
            (left - 0.5 * self.gap, right - 0.5 * self.gap),
            self.posterior_chink,
            [(lesion, self.middle_of(lesion)) for lesion in self.lesions],
        )

    @property
    def moved(self) -> bool:
        """Whether their surface is another than that of like folds."""
        gaps = [own for own in (self.left_gap, self.right_gap) if own is not None]
        return (
            self.posterior_chink is not None
            or any(own != 0.5 * self.gap for own in gaps)
            or any(lesion.protrusion > 0 for lesion in self.lesions)
        )

    @property
    def unlike_sides(self) -> bool:
        """Whether left and right differ."""
        left, right = (0.5 * self.gap if own is None else own for own in (self.left_gap, self.right_gap))
        return left != right or bool(self.lesions)

    def _below(self, edge: tuple[float, float]) -> list[tuple[float, float]]:
        """Sections below the lower edge, which begins there: heights and half-widths, m."""
        radius = self.depth + 0.5 * self.gap
        (z, x), begin = edge, _BEGIN * radius
        ends = [(_BELOW, _ENDS * radius)]
        return [*ends, (z - (begin - x) / math.tan(self.inferior_angle), begin)] if begin > x else ends

    def shape(self) -> dict[str, Any]:
        """The options of a larynx that are named in `SHAPE`."""
        radius = self.depth + 0.5 * self.gap
        lower, upper = self._edges()
        below = self._below(lower[0])
        above = [(upper[-1][0] + up, share * radius) for up, share in _TOP if share * radius > upper[-1][1]]
        return {
            "sections": [*below, *lower, *upper, *above, (_ABOVE, _ENDS * radius)],
            "major": 0.5 * self.length,
            "radius": radius,
            "layer_thickness": self.cover,
            "ligament_thickness": self.ligament,
            "layers_from_section": len(below),
            "layers_to_section": len(below) + len(lower) + len(upper) - 1,
        }

    def _edges(self) -> tuple[list[tuple[float, float]], list[tuple[float, float]]]:
        """The lower and the upper edge, upward: heights and half-widths, m."""
        slant = self.thickness * math.tan(self.medial_angle)
        half = 0.5 * self.gap
        low, high = half + max(slant, 0.0), half + max(-slant, 0.0)
        lower = self._arc((-self.thickness, low), -self.inferior_angle)
        upper = self._arc((0.0, high), _LEVEL)
        return lower[::-1], upper

    def _arc(self, start: tuple[float, float], last: float) -> list[tuple[float, float]]:
        """A round edge from the medial surface on to an inclination of `last`, rad outward of vertical."""
        if self.edge_radius == 0:
            return [start]
        z, x, first = *start, -self.medial_angle
        inclined = [first + (last - first) * k / _PIECES for k in range(_PIECES + 1)]
        return [
            (
                z + self.edge_radius * (math.sin(angle) - math.sin(first)),
                x + self.edge_radius * (math.cos(first) - math.cos(angle)),
            )
            for angle in inclined
        ]
