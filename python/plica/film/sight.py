"""What a camera sees of a mesh's skin, whatever it looks like."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plica.film.motion import FilmableMesh
from plica.film.outline import Hull
from plica.film.raster import Raster, highest, rasterise
from plica.film.surface import Surface, bulge, faces_of, rim, surface_of
from plica.view.camera import Camera

__all__ = ["Sight", "View"]

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

_FLAT = 0.1  # px, by which a flat triangle may lie off a curved face
_DIVISIONS = (2, 12)  # of a curved face's sides
_ROUND = 1e-6  # px
_HIDDEN = 1e-3  # px: what is behind something else by less is seen


@dataclass(frozen=True)
class View:
    """The skin at one time.

    Attributes
    ----------
    corners : (v, 3)
        Column px, row px, height m.
    opening : Hull
        That it is seen through: the upper end of the airway.
    raster : Raster
        Which triangle the pixels' centres show.
    """

    corners: Floats
    opening: Hull
    raster: Raster


class Sight:
    """A camera before a mesh.

    Attributes
    ----------
    camera : Camera
    surface : Surface
        The skin as flat triangles, fine enough for the camera's pixels.
    rest : (v, 3) m
        Its corners at rest.
    """

    def __init__(self, mesh: FilmableMesh, camera: Camera) -> None:
        self.camera = camera
        points = np.asarray(mesh.points, dtype=float)
        faces = faces_of(mesh)
        off = bulge(points, faces) / camera.pixel / _FLAT
        divisions = 1 if faces.shape[1] == 3 else int(np.clip(np.ceil(np.sqrt(off)), *_DIVISIONS))
        self.surface: Surface = surface_of(faces, divisions)
        self._points = points[self.surface.nodes]
        self.rest = self.surface.corners(self._points)
        self._rim = rim(self.rest, self.surface.triangles)

    def corners(self, displacement: Floats) -> Floats:
        """(v, 3) column px, row px and height m under a displacement (k, 3) m of the surface's nodes."""
        return self.camera.project(self.surface.corners(self._points + displacement))

    def view(self, corners: Floats) -> View:
        """The skin at these corners."""
        opening = Hull(corners[self._rim, :2])
        within = opening.pixels(self.camera.shape)
        return View(corners, opening, rasterise(corners, self.surface.triangles, within))

    def again(self, moved: Floats, shown: NDArray[Any], then: View) -> Mask:
        """(p) whether points (p, 3) in px, px and m of the triangles `shown` (p) are seen in a view.

        That is inside the picture and the opening, facing the camera, and behind nothing else.
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
        """(h * w, 3) m, what the pixels show of a plane as high as the skin is at rest."""
        height, width = self.camera.shape
        projection = self.camera.projection
        y, x = np.mgrid[:height, :width].astype(float)
        sight = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1) - projection[:, 3]
        place = sight @ np.linalg.inv(projection[:, :3]).T
        towards = self.camera.axes[2]
        return np.asarray(place + ((self.rest[:, 2].max() - place[:, 2]) / towards[2])[:, None] * towards)
