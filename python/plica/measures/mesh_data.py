"""The protocol of a mesh that measures use, of the engine or stored."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Protocol

import numpy as np

from plica.measures.record import Array

__all__ = ["MeshData", "flat_faces", "toward_right"]

_FLAT = {3: ((0, 1, 2),), 6: ((0, 3, 5), (3, 1, 4), (5, 4, 2), (3, 4, 5))}  # of a face with nodes 12, 23, 31


class MeshData(Protocol):
    """A mesh in its reference position."""

    @property
    def points(self) -> Array:
        """(n, 3) m, reference positions."""

    @property
    def cells(self) -> Array:
        """(m, 4) or (m, 10) node numbers."""

    @property
    def cell_layer(self) -> Array:
        """(m) position in `layer_names`."""

    @property
    def layer_names(self) -> Sequence[str]:
        """Names of the layers, e.g. body, ligament, cover."""

    @property
    def surfaces(self) -> Mapping[str, Array]:
        """Named boundary faces, (f, 3) or (f, 6) node numbers."""


def flat_faces(faces: Array) -> Array:
    """Triangles (f, 1 or 4, 3) between the nodes of faces (f, 3 or 6): a curved one has four, as it faces."""
    faces = np.asarray(faces)
    return faces[:, _FLAT[faces.shape[1]]]


def toward_right(points: Array, cells: Array, side: Array) -> int:
    """1 where x points to the right fold, and y to the front; -1 where they point to the left fold and to the
    back; 0 without a left and a right fold.

    Parameters
    ----------
    points : (n, 3) m
    cells : (m, 4 or 10)
    side : (m)
        0 none, 1 left, 2 right.
    """
    points, cells, side = np.asarray(points), np.asarray(cells), np.asarray(side)
    if not ((side == 1).any() and (side == 2).any()):
        return 0
    left, right = (float(points[cells[side == k, :4], 0].mean()) for k in (1, 2))
    return -1 if right < left else 1
