"""The glottal edge of a mesh as a camera sees it, and the points of its surface at the pixels."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from plica._engine import TetMesh
from plica.camera.pose import Camera
from plica.films.sight import Sight, View
from plica.larynx_fit.cross_section import CrossSection, Rays

__all__ = ["MeshSeen", "glottal_edge"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

_RAYS = 720
_NEAR = 1.2  # in the rays' units, with the glottis' edge at 1: sides beyond cannot bound the opening
_BATCH = 60  # rays at a time


@dataclass(frozen=True)
class MeshSeen:
    """A larynx as a camera sees it: its nodes in the picture, and the picture's pixels on its surface."""

    mesh: TetMesh
    camera: Camera
    z_from: float
    """m, height of the folds' upper edge."""
    z_to: float
    """m, height at which the superior surface ends."""

    @cached_property
    def superior(self) -> Ints:
        """(k) nodes of the superior surface: of the airway's, between the heights z3 and z4."""
        nodes = np.unique(np.asarray(self.mesh.surfaces["airway"]))
        z = np.asarray(self.mesh.points)[nodes, 2]
        off = 1e-6 * (self.z_to - self.z_from)
        return np.asarray(nodes[(z >= self.z_from - off) & (z <= self.z_to + off)], dtype=np.int64)

    @cached_property
    def pixels(self) -> Floats:
        """(k, 2) column and row, px, of the nodes `superior`."""
        return self.camera.project(np.asarray(self.mesh.points, dtype=float)[self.superior])[:, :2]

    @cached_property
    def places(self) -> Floats:
        """(h, w, 3) m, point of the airway's surface at each pixel's centre; NaN without surface."""
        found = np.full((*self.camera.shape, 3), np.nan)
        found.reshape(-1, 3)[self._view.raster.pixels] = self._view.of(self._sight.points)
        return found

    @cached_property
    def visible(self) -> NDArray[np.bool_]:
        """(k) whether the nodes `superior` lie in the picture and are not occluded."""
        from plica.films.raster import highest

        seen = self.camera.project(np.asarray(self.mesh.points, dtype=float)[self.superior])
        height, width = self.camera.shape
        inside: NDArray[np.bool_] = np.all(
            (seen[:, :2] >= 0) & (seen[:, :2] <= [width - 1, height - 1]), axis=1
        )
        top = highest(seen[inside, :2], self._view.corners, self._sight.surface.triangles, self.camera.shape)
        inside[inside] = top <= seen[inside, 2] + 0.05 * self.camera.pixel
        return inside

    @cached_property
    def _sight(self) -> Sight:
        return Sight(self.mesh, self.camera)

    @cached_property
    def _view(self) -> View:
        return self._sight.view(self._sight.nodes(np.zeros((len(self._sight.surface.nodes), 3))))

    @property
    def rest(self) -> Floats:
        """(v, 3) m of the airway's surface as flat triangles."""
        return self._sight.rest

    @property
    def corners(self) -> tuple[Floats, NDArray[np.int32]]:
        """(v, 2) px and (t, 3): the airway's surface as flat triangles in the picture."""
        return self._view.corners[:, :2], self._sight.surface.triangles


def glottal_edge(seen: MeshSeen, section: CrossSection) -> Floats:
    """(k, 2) px: the edge of the opening that the camera sees through the mesh, to P0.

    Along rays from the glottis' middle, in units in which the glottis is round, the first intersection with a
    side of the airway's triangles; exact if the opening is star-shaped about the middle.
    """
    corners, triangles = seen.corners
    place = section.from_centre(corners)
    sides = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    sides = np.unique(np.sort(sides, axis=1), axis=0)
    a, b = place[sides[:, 0]], place[sides[:, 1]]
    along = b - a
    nearest = np.clip(-(a * along).sum(axis=1) / np.maximum((along**2).sum(axis=1), 1e-300), 0.0, 1.0)
    near = np.linalg.norm(a + nearest[:, None] * along, axis=1) < _NEAR
    a, along = a[near], along[near]
    turn = a[:, 0] * along[:, 1] - a[:, 1] * along[:, 0]
    rays = Rays.of(_RAYS)
    reach = np.full(_RAYS, np.inf)
    for part in np.array_split(np.arange(_RAYS), _RAYS // _BATCH):
        d = rays.direction[part, None]
        across = d[..., 0] * along[:, 1] - d[..., 1] * along[:, 0]
        with np.errstate(divide="ignore", invalid="ignore"):
            share = (a[:, 0] * d[..., 1] - a[:, 1] * d[..., 0]) / across
        ray, side = np.nonzero((share >= -1e-9) & (share <= 1 + 1e-9))
        far = turn[side] / across[ray, side]
        np.minimum.at(reach, part[ray], np.where(far > 0, far, np.inf))
    return section.outline(rays, section.cut(rays, reach))
