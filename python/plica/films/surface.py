"""The surface of a mesh of tetrahedra as flat triangles that move with its nodes."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from plica._engine import interpolated
from plica.camera.visible_faces import lattice, shapes
from plica.tetrahedron import EDGES

if TYPE_CHECKING:
    from scipy import sparse

    from plica.films.motion import FilmableMesh

__all__ = ["Surface", "bulge", "faces_of", "rim", "skin", "surface_of"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Rows = NDArray[np.int32]

_CORNERS = ((1, 2, 3, 0), (0, 3, 2, 1), (0, 1, 3, 2), (0, 2, 1, 3))  # of a face, and the one opposite
_MIDDLE = {edge: 4 + k for k, edge in enumerate(EDGES)}


@dataclass(frozen=True)
class Surface:
    """Triangles whose corners are fixed combinations of nodes.

    Attributes
    ----------
    nodes : (k) numbers of the mesh's nodes that it needs
    weights : (v, k) sparse
        Corners are ``weights @ positions[nodes]``.
    triangles : (t, 3) rows of corners, anticlockwise seen from outside
    faces : (f, 3) or (f, 6) rows of `nodes`: the faces that the triangles approximate, equally many for each
    divisions : of the faces' sides
    """

    nodes: Ints
    weights: sparse.csr_array
    triangles: Rows
    faces: Rows
    divisions: int

    def corners(self, positions: Floats) -> Floats:
        """(v, 3) corners from positions (k, 3) of `nodes`."""
        return np.asarray(self.weights @ positions)

    def places(self, shown: Rows, share: Floats) -> Floats:
        """(p, 2) coordinates (r, s) in their faces, of shares (p, 3) in flat triangles (p)."""
        return interpolated(share, self._own_corners(shown), lattice(self.divisions))

    def flat(self, shown: Rows, share: Floats) -> Floats:
        """(p, 3 or 6) weights of the faces' nodes at shares (p, 3) in flat triangles (p)."""
        weights = shapes(self.faces.shape[1], lattice(self.divisions))
        return interpolated(share, self._own_corners(shown), weights)

    def _own_corners(self, shown: Rows) -> Rows:
        """(p, 3) rows of `lattice` of flat triangles (p)."""
        return _triangles(self.divisions)[shown % self.divisions**2]


def faces_of(mesh: FilmableMesh, surface: str) -> Ints:
    """The visible faces: the mesh's surface of this name, or its whole surface if there is none."""
    if surface in mesh.surfaces:
        return np.asarray(mesh.surfaces[surface], dtype=np.int64)
    return skin(np.asarray(mesh.points, dtype=float), np.asarray(mesh.cells))


def rim(corners: Floats, triangles: Rows) -> Ints:
    """Corners (v, 3) at open edges in the upper half: the upper end of an airway; all of a closed skin."""
    edges = np.sort(
        np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1
    )
    found, count = np.unique(edges, axis=0, return_counts=True)
    ends = np.unique(found[count == 1])
    z = corners[:, 2]
    upper = ends[z[ends] > 0.5 * (z.min() + z.max())]
    return upper if upper.size else np.arange(len(corners))


def skin(points: Floats, cells: NDArray[Any]) -> Ints:
    """Faces that belong to one cell only: (f, 3), or (f, 6) with the mid-side nodes of 12, 23, 31; outward.

    points (n, 3) m; cells (m, 4) or (m, 10).
    """
    faces, opposite = [], []
    for *corners, other in _CORNERS:
        picked = list(corners)
        if cells.shape[1] == 10:
            sides = [(corners[k], corners[(k + 1) % 3]) for k in range(3)]
            picked += [_MIDDLE[min(side), max(side)] for side in sides]
        faces.append(cells[:, picked])
        opposite.append(cells[:, other])
    all_faces, others = np.concatenate(faces).astype(np.int64), np.concatenate(opposite)
    keys = np.sort(all_faces[:, :3], axis=1)
    _, first, count = np.unique(keys, axis=0, return_index=True, return_counts=True)
    chosen = np.sort(first[count == 1])
    found, inside = all_faces[chosen], others[chosen]
    a, b, c = (points[found[:, k]] for k in range(3))
    volume = np.einsum("ij,ij->i", np.cross(b - a, c - a), points[inside] - a)
    order = [1, 0, 2] if cells.shape[1] == 4 else [1, 0, 2, 3, 5, 4]
    found[volume > 0] = found[volume > 0][:, order]
    return np.asarray(found)


def bulge(points: Floats, faces: Ints) -> float:
    """Largest distance of a mid-side node from the middle of its side, m; 0 for flat faces."""
    if faces.shape[1] == 3:
        return 0.0
    middles = [
        points[faces[:, 3 + k]] - 0.5 * (points[faces[:, k]] + points[faces[:, (k + 1) % 3]])
        for k in range(3)
    ]
    return float(np.linalg.norm(np.concatenate(middles), axis=1).max(initial=0.0))


def surface_of(faces: Ints, divisions: int) -> Surface:
    """Each face as divisions^2 flat triangles that share corners with their neighbours.

    The corners of the triangles lie on a six-node face; between them the distance is up to
    bulge / divisions^2.
    """
    from scipy import sparse

    values = shapes(faces.shape[1], lattice(divisions))  # (p, 3 or 6)
    nodes, local = np.unique(faces, return_inverse=True)
    local = local.reshape(faces.shape)
    count, each = len(faces), len(values)
    rows = np.repeat(np.arange(count * each), faces.shape[1])
    columns = np.repeat(local[:, None, :], each, axis=1).ravel()
    weights = sparse.csr_array(
        (np.tile(values.ravel(), count), (rows, columns)), shape=(count * each, len(nodes))
    )
    triangles = (each * np.arange(count)[:, None, None] + _triangles(divisions)).reshape(-1, 3)
    # Corners with the same weights are merged (compared by their products with random numbers); surfaces
    # that touch stay separate.
    label = np.random.default_rng(0).uniform(1.0, 2.0, (len(nodes), 2))
    grid = np.round((weights @ label) / 1e-9)
    _, first, merged = np.unique(grid, axis=0, return_index=True, return_inverse=True)
    whole = sparse.csr_array(weights[first])
    return Surface(
        nodes, whole, merged.ravel().astype(np.int32)[triangles], np.asarray(local, dtype=np.int32), divisions
    )


@cache
def _triangles(n: int) -> Rows:
    """(n^2, 3) rows of `lattice`."""
    start = np.concatenate([[0], np.cumsum(np.arange(n + 1, 0, -1))])
    found = []
    for j in range(n):
        for i in range(n - j):
            a, b = start[j] + i, start[j + 1] + i
            found.append((a, a + 1, b))
            if i + j < n - 1:
                found.append((a + 1, b + 1, b))
    return np.array(found, dtype=np.int32)
