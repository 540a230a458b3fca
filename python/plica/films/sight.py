"""What a camera sees of a mesh's surface, apart from its shading."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plica._engine import interpolated, within_hull
from plica.camera.pose import Camera
from plica.camera.visible_faces import meet, refined, shapes
from plica.films.motion import FilmableMesh
from plica.films.raster import Raster, highest, rasterise
from plica.films.surface import Surface, bulge, faces_of, rim, surface_of

__all__ = ["Hull", "Sight", "View"]

Floats = NDArray[np.float64]
Ints = NDArray[Any]
Mask = NDArray[np.bool_]

_FLAT = 0.1  # px, by which a flat triangle may lie off a curved face
_DIVISIONS = (2, 12)  # of a curved face's sides
_ROUND = 1e-6  # px
_HIDDEN = 1e-3  # px: points behind another surface by less are visible


class Hull:
    """The convex hull of points (n, 2), column and row in px."""

    def __init__(self, points: Floats) -> None:
        from scipy.spatial import ConvexHull

        self._sides: Floats = ConvexHull(points).equations  # a x + b y + c <= 0 inside

    def holds(self, places: Floats) -> Mask:
        """(p) whether places (p, 2) lie in it."""
        return within_hull(self._sides, places)

    def pixels(self, shape: tuple[int, int]) -> Mask:
        """(h, w) pixels whose centres lie in it, row by row between its sides."""
        a, b, c = self._sides.T
        level = b * np.arange(shape[0])[:, None] + c
        with np.errstate(divide="ignore", invalid="ignore"):
            end = -level / a
        right = np.where(a > 0, end, np.inf).min(axis=1)
        left = np.where(a < 0, end, -np.inf).max(axis=1)
        left[((a == 0) & (level > 0)).any(axis=1)] = np.inf  # above or below a level side
        x = np.arange(shape[1])
        return np.asarray((x >= left[:, None]) & (x <= right[:, None]))


@dataclass(frozen=True)
class View:
    """The surface at one time.

    Attributes
    ----------
    nodes, corners : (k, 3), (v, 3)
        Column px, row px, height m of the surface's nodes and of its triangles' corners.
    opening : Hull
        Through which the surface is seen: the upper end of the airway.
    raster : Raster
        Which flat triangle the pixels' centres show.
    shown : (p, 3 or 6) rows of the nodes of the face that each of the raster's pixels shows
    weights : (p, 3 or 6) of them
    """

    nodes: Floats
    corners: Floats
    opening: Hull
    raster: Raster
    shown: Ints
    weights: Floats

    def of(self, values: Floats) -> Floats:
        """(p, c) values (k, c) at the nodes, interpolated to the raster's pixels."""
        return interpolated(self.weights, self.shown, values)


class Sight:
    """The surface of a mesh as a camera sees it.

    Parameters
    ----------
    mesh : FilmableMesh
    camera : Camera
    surface : str
        Name of the mesh's surface that is visible; all of its skin if it has none of this name.

    Attributes
    ----------
    camera : Camera
    surface : Surface
        The surface as flat triangles, fine enough for the camera's pixels.
    points, rest : (k, 3), (v, 3) m
        Its nodes and its corners at rest.
    """

    def __init__(self, mesh: FilmableMesh, camera: Camera, surface: str = "airway") -> None:
        self.camera = camera
        points = np.asarray(mesh.points, dtype=float)
        faces = faces_of(mesh, surface)
        off = bulge(points, faces) / camera.pixel / _FLAT
        divisions = 1 if faces.shape[1] == 3 else int(np.clip(np.ceil(np.sqrt(off)), *_DIVISIONS))
        self.surface: Surface = surface_of(faces, divisions)
        self.points = points[self.surface.nodes]
        self.rest = self.surface.corners(self.points)
        self._rim = rim(self.rest, self.surface.triangles)

    def nodes(self, displacement: Floats) -> Floats:
        """(k, 3) column px, row px and height m under a displacement (k, 3) m of the surface's nodes."""
        return self.camera.project(self.points + displacement)

    def view(self, nodes: Floats) -> View:
        """The surface with its nodes at these positions (k, 3).

        The flat triangles decide which face a pixel shows; the position on a curved face is then computed on
        the face itself. At an outline that the curved faces do not reach, the flat triangle's point is kept,
        with an error of up to 0.1 px.
        """
        surface = self.surface
        corners = surface.corners(nodes)
        opening = Hull(corners[self._rim, :2])
        raster = rasterise(corners, surface.triangles, opening.pixels(self.camera.shape))
        face = raster.shown // surface.divisions**2
        if surface.faces.shape[1] == 6:
            face, weights = self._curved(nodes, raster, face)
        else:
            weights = raster.share
        return View(nodes, corners, opening, raster, surface.faces[face], weights)

    def _curved(self, nodes: Floats, raster: Raster, face: Ints) -> tuple[Ints, Floats]:
        """Faces (p) and weights (p, 6) where the lines of sight meet the curved faces."""
        faces, width = self.surface.faces, self.camera.width
        pixels = np.column_stack([raster.pixels % width, raster.pixels // width]).astype(float)
        start = self.surface.places(raster.shown, raster.share)
        place, found = refined(nodes, faces, face, pixels, start)
        lost = np.flatnonzero(~found)  # most are near an edge: they lie on the adjacent face
        met = meet(nodes, faces, pixels[lost])
        there = met.face >= 0
        face[lost[there]], place[lost[there]] = met.face[there], met.place[there]
        found[lost[there]] = True
        weights = shapes(6, place)
        flat = np.flatnonzero(~found)
        weights[flat] = self.surface.flat(raster.shown[flat], raster.share[flat])
        return face, weights

    def still_visible(self, moved: Floats, shown: NDArray[Any], then: View) -> Mask:
        """(p) whether points (p, 3) in px, px and m of the triangles `shown` (p) are visible in a view.

        Visible: inside the picture and the opening, facing the camera, and not occluded.
        """
        height, width = self.camera.shape
        least, most = np.array([-_ROUND, -_ROUND]), np.array([width - 1, height - 1]) + _ROUND
        inside = ((moved[:, :2] >= least) & (moved[:, :2] <= most)).all(axis=1)
        inside &= then.opening.holds(moved[:, :2])
        corners, triangles = then.corners, self.surface.triangles
        a, b, c = (corners[triangles[shown, k], :2] for k in range(3))
        turn = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (c[:, 0] - a[:, 0]) * (b[:, 1] - a[:, 1])
        seen = inside & (turn < 0)  # rows count downwards
        above = highest(moved[seen, :2], corners, triangles, self.camera.shape) - moved[seen, 2]
        seen[seen] = above <= _HIDDEN * self.camera.pixel
        return np.asarray(seen)

    def around(self) -> Floats:
        """(h * w, 3) m, points at the pixels of a plane at the height of the surface's upper end at rest."""
        height, width = self.camera.shape
        projection = self.camera.projection
        y, x = np.mgrid[:height, :width].astype(float)
        sight = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1) - projection[:, 3]
        place = sight @ np.linalg.inv(projection[:, :3]).T
        towards = self.camera.axes[2]
        return np.asarray(place + ((self.rest[:, 2].max() - place[:, 2]) / towards[2])[:, None] * towards)
