"""Uniform refinement: every tetrahedron is divided into eight, every face of a surface into four.

The shape is unchanged: straight cells stay straight, and the eight children of a quadratic cell use its
quadratic map, so that curved sides are kept.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from plica import _engine
from plica.scene.mesh.changed import changed_mesh
from plica.tetrahedron import EDGES, shape_functions

__all__ = ["refined"]

# By nodes of a quadratic cell: a tetrahedron at each corner, and four around the line from node 6 to node 8
# through the remaining octahedron.
_CHILDREN = np.array(
    [
        (0, 4, 6, 7),
        (4, 1, 5, 8),
        (6, 5, 2, 9),
        (7, 8, 9, 3),
        (6, 8, 4, 5),
        (6, 8, 5, 9),
        (6, 8, 9, 7),
        (6, 8, 7, 4),
    ]
)
_FACE_CHILDREN = np.array([(0, 3, 5), (3, 1, 4), (5, 4, 2), (3, 4, 5)])  # of a six-node face


def refined(mesh: Any) -> _engine.TetMesh:
    """A mesh of the same order and shape with eight tetrahedra for each, and the same names.

    Parameters
    ----------
    mesh : TetMesh
        Of linear or quadratic tetrahedra.

    Raises
    ------
    InvalidInput
        If a quadratic cell is so curved that one of its children is invalid.
    """
    parent = mesh if np.asarray(mesh.cells).shape[1] == 10 else _engine.to_quadratic(mesh)
    cells = np.asarray(parent.cells)
    linear = _engine.TetMesh(
        points=np.asarray(parent.points),
        cells=cells[:, _CHILDREN].reshape(-1, 4),
        cell_layer=np.repeat(np.asarray(parent.cell_layer), len(_CHILDREN)),
        cell_side=np.repeat(np.asarray(parent.cell_side), len(_CHILDREN)),
        layer_names=list(parent.layer_names),
        surfaces={
            name: np.asarray(faces)[:, _FACE_CHILDREN].reshape(-1, 3)
            for name, faces in parent.surfaces.items()
        },
        node_sets={name: np.asarray(nodes) for name, nodes in parent.node_sets.items()},
    )
    if parent is mesh:
        linear = _on_the_map(linear, parent)
    _engine.check_mesh(linear)
    return linear


def _on_the_map(linear: _engine.TetMesh, parent: Any) -> _engine.TetMesh:
    """Quadratic cells with edge midpoints from the map of the parent."""
    fine = _engine.to_quadratic(linear)
    cells, points = np.asarray(parent.cells), np.array(fine.points)
    corners = np.eye(4)
    nodes = np.vstack([corners, *(0.5 * (corners[[a]] + corners[[b]]) for a, b in EDGES)])  # in the parent
    for number, child in enumerate(_CHILDREN):
        middles = np.array([0.5 * (nodes[child[a]] + nodes[child[b]]) for a, b in EDGES])
        of_child = np.asarray(fine.cells)[number :: len(_CHILDREN), 4:]
        points[of_child] = np.einsum(
            "ka,mai->mki", shape_functions(middles), np.asarray(parent.points)[cells]
        )
    return changed_mesh(fine, points=points)
