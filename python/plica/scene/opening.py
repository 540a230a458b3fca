"""The opening pattern of `Initial`, about the glottis of a parametric larynx or of a mesh."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from plica.errors import InvalidInput
from plica.measures.contour import medial_surface, rest_contour
from plica.measures.thresholds import medial_angle
from plica.scene.held import MeshArrays
from plica.scene.mesh.parts import Larynx
from plica.scene.mesh.surface_fault import airway_fault

__all__ = ["Glottis", "opening_pattern"]

_Reals = NDArray[np.float64]


@dataclass(frozen=True)
class Glottis:
    """What the opening pattern is about; lengths in m.

    Attributes
    ----------
    x, y : float
        Of the midline at the narrowest height, and of the mid-coronal plane.
    contour : (k, 2)
        Height and half the width of the airway in that plane, upward.
    major : float
        Half-length of the airway, along y.
    wall : tuple of float
        Distance from the midline to the wall at smaller and at larger x.
    length : float
        Half-length of the wall, along y.
    """

    x: float
    y: float
    contour: _Reals
    major: float
    wall: tuple[float, float]
    length: float

    @classmethod
    def of_larynx(cls, larynx: Larynx) -> Glottis:
        """That of a parametric larynx."""
        fields = larynx.all_options()
        radius = float(fields["radius"])
        sections = np.asarray(fields["sections"])  # (k, 2): z, minor half-axis, m
        return cls(0.0, 0.0, sections, float(fields["major"]), (radius, radius), radius)

    @classmethod
    def of_mesh(cls, mesh: MeshArrays, surface: str) -> Glottis:
        """That of a mesh, between the two folds of a surface; raises InvalidInput where there is none."""
        if surface not in mesh.surfaces:
            raise InvalidInput(
                f'needs the glottis: the mesh must have a surface "{surface}". Name the airway in '
                "mesh.surfaces."
            )
        if fault := airway_fault(mesh, surface):
            raise InvalidInput(f'needs the glottis; surface "{surface}": {fault}')
        points, faces = np.asarray(mesh.points, dtype=float), np.asarray(mesh.surfaces[surface])
        contour = rest_contour(points, faces)
        y = points[np.unique(faces), 1]
        middle = 0.5 * (y.min() + y.max())
        if not len(contour):
            raise InvalidInput(
                f'needs the glottis: the surface "{surface}" must have two folds that face each other along '
                f"x in the plane y = {middle:.4g} m. Are x lateral, y from back to front and z upward?"
            )
        height, smaller, larger = contour.T
        narrowest = int(np.argmin(larger - smaller))
        least = float(larger[narrowest] - smaller[narrowest])
        if least <= 0:
            raise InvalidInput(
                f"needs an open glottis: the folds are {least:.4g} m apart at z = {height[narrowest]:.4g} m; "
                "must be > 0 m everywhere. Are x lateral, y from back to front and z upward? If so, use "
                "initial.velocity of both folds."
            )
        medial = medial_surface(larger - smaller, height)
        if medial.stop - medial.start < 2:
            raise InvalidInput(
                f"needs a medial surface: at the narrowest place, z = {height[narrowest]:.4g} m, the folds' "
                f"contour in the plane y = {middle:.4g} m must be within {np.degrees(medial_angle):.0f} "
                "degrees of vertical. Use initial.velocity of both folds."
            )
        x = 0.5 * (larger[narrowest] + smaller[narrowest])
        low, high = points.min(axis=0), points.max(axis=0)
        return cls(
            float(x),
            float(middle),
            np.column_stack((height, 0.5 * (larger - smaller))),
            0.5 * float(np.ptp(y)),
            (float(x - low[0]), float(high[0] - x)),
            float(max(middle - low[1], high[1] - middle)),
        )


def opening_pattern(points: _Reals, glottis: Glottis, side: _Reals | None = None) -> _Reals:
    """The lateral opening pattern of `Initial`, (n, 3), equal to one at the superior edge of the medial
    surface. Of points of the folds (n): -1 left, 1 right; default: by the sign of x."""
    b, length, contour = glottis.major, glottis.length, glottis.contour
    edge = medial_surface(2.0 * contour[:, 1], contour[:, 0]).stop - 1
    z_edge, a = contour[edge]
    z_low = _widened(contour[edge::-1], 4 * a)
    z_high = _widened(contour[edge:], 4 * a)
    x, y, z = (points - (glottis.x, glottis.y, 0.0)).T
    inside = np.abs(y) < b
    reach = np.where(z <= z_edge, z_low - z_edge, z_high - z_edge)
    ratio = np.divide(z - z_edge, reach, out=(z != z_edge).astype(float), where=reach != 0)
    along = np.where(inside, np.cos(0.5 * np.pi * y / b), 0.0)
    height = 0.5 * (1 + np.cos(np.pi * np.clip(ratio, 0.0, 1.0)))
    sign = np.sign(x) if side is None else side
    stretch = np.where(sign < 0, *glottis.wall) / length
    wall = stretch * np.sqrt(np.maximum(length**2 - y**2, 0.0))
    airway = a * np.sqrt(np.maximum(1 - (y / b) ** 2, 0.0))
    depth = np.clip((wall - sign * x) / np.where(inside, wall - airway, 1.0), 0.0, 1.0)
    pattern = np.zeros_like(points)
    pattern[:, 0] = sign * along * height * depth
    return pattern


def _widened(contour: _Reals, half_width: float) -> float:
    """Height at which the half-width first reaches a value along rows of (z, half-width)."""
    for (z0, w0), (z1, w1) in pairwise(contour):
        if w1 >= half_width:
            return float(z0 + (z1 - z0) * (half_width - w0) / (w1 - w0))
    return float(contour[-1, 0])
