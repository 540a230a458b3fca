"""Surfaces of a mesh selected by position or normal, for files without labelled triangles."""

from __future__ import annotations

from typing import Annotated, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from plica.scene.part import Part, problem
from plica.units import Angle, Length, Number

__all__ = ["Box", "FaceSelection", "Facing", "Plane", "select"]

_Reals = NDArray[np.float64]
_Integers = NDArray[np.int32]
_Range = tuple[Length, Length]
_Direction = tuple[Number, Number, Number]


class Plane(Part):
    """Faces whose nodes are all in a plane."""

    point: tuple[Length, Length, Length]
    """[m] Any point of the plane."""
    normal: _Direction
    """[-] Normal of the plane, of any length and sign."""
    within: Annotated[Length, Field(gt=0)] | None = None
    """[m] Largest distance of a node; default: a millionth of the mesh's size."""

    @model_validator(mode="after")
    def _has_a_direction(self) -> Self:
        _must_point(self, "normal")
        return self


class Box(Part):
    """Faces whose nodes are all in a box, including its sides (to 1e-9 of the mesh's size)."""

    x: _Range | None = None
    """[m] Smallest and largest x; default: any."""
    y: _Range | None = None
    """[m] Smallest and largest y."""
    z: _Range | None = None
    """[m] Smallest and largest z."""

    @model_validator(mode="after")
    def _ranges_ascend(self) -> Self:
        given = {name: getattr(self, name) for name in "xyz" if getattr(self, name) is not None}
        if not given:
            raise problem("must have one of x, y, z.")
        for name, (least, largest) in given.items():
            if least > largest:
                raise problem("must have the smallest first.", name, value=[least, largest])
        return self


class Facing(Part):
    """Faces whose outward normal points in a direction."""

    along: _Direction
    """[-] The direction, of any length."""
    within: Annotated[Angle, Field(gt=0, le=np.pi)] = np.pi / 4
    """[rad] Largest angle between normal and direction, inclusive, e.g. ``"30 deg"``."""

    @model_validator(mode="after")
    def _has_a_direction(self) -> Self:
        _must_point(self, "along")
        return self


class FaceSelection(Part):
    """Faces of the mesh's boundary that satisfy all given conditions."""

    plane: Plane | None = None
    """In this plane."""
    box: Box | None = None
    """In this box."""
    facing: Facing | None = None
    """Facing this direction."""
    side: Literal["left", "right"] | None = None
    """On the cells of this fold, which `sides` must define."""

    @model_validator(mode="after")
    def _has_a_condition(self) -> Self:
        if all(getattr(self, name) is None for name in type(self).model_fields):
            raise problem('must have one of plane, box, facing, side; the whole boundary is "boundary".')
        return self


def select(
    selection: FaceSelection, points: _Reals, faces: _Integers, face_side: _Integers
) -> NDArray[np.bool_]:
    """Which faces (f) are selected.

    Parameters
    ----------
    selection : FaceSelection
    points : (n, 3) m
    faces : (f, 3) or (f, 6) rows of `points`, corners first, oriented outward
    face_side : (f) 0 none, 1 left, 2 right: of the face's cell
    """
    chosen = np.ones(len(faces), dtype=bool)
    nodes = points[faces]  # (f, 3 or 6, 3)
    size = float(np.ptp(points, axis=0).max())
    if (plane := selection.plane) is not None:
        normal = np.asarray(plane.normal) / np.linalg.norm(plane.normal)
        within = plane.within or 1e-6 * size
        chosen &= (np.abs((nodes - np.asarray(plane.point)) @ normal) <= within).all(axis=1)
    if (box := selection.box) is not None:
        for axis, name in enumerate("xyz"):
            if (limits := getattr(box, name)) is not None:
                at = nodes[:, :, axis]
                chosen &= ((at >= limits[0] - 1e-9 * size) & (at <= limits[1] + 1e-9 * size)).all(axis=1)
    if (facing := selection.facing) is not None:
        along = np.asarray(facing.along) / np.linalg.norm(facing.along)
        normals = np.cross(nodes[:, 1] - nodes[:, 0], nodes[:, 2] - nodes[:, 0])
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        chosen &= normals @ along >= np.cos(facing.within) - 1e-9
    if selection.side is not None:
        chosen &= face_side == {"left": 1, "right": 2}[selection.side]
    return chosen


def _must_point(part: Part, field: str) -> None:
    if not any(getattr(part, field)):
        raise problem("must not be zero.", field, value=list(getattr(part, field)))
