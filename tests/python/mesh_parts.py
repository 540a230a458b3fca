"""Parts of a larynx as mesh files: one fold, or a quarter, as a mesher would write them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import meshio
import numpy as np
from numpy.typing import NDArray

import plica
from plica import _engine

__all__ = ["mirrored_larynx", "write_fold", "write_part"]

Floats = NDArray[np.float64]
AIRWAY, WALL = 11, 12


def write_part(
    mesh: _engine.TetMesh, path: Path, planes: int, signs: tuple[int, int] = (1, 1)
) -> dict[str, Any]:
    """Write the cells of a mesh with x of this sign and, with two planes, y of this sign, with labels of the
    layers, of the airway and, where the mesh has a wall, of this. Returns what a MeshFile of it needs."""
    points, cells = np.asarray(mesh.points), np.asarray(mesh.cells)
    centre = points[cells[:, :4]].mean(axis=1)
    own = np.all([centre[:, axis] * signs[axis] > 0 for axis in range(planes)], axis=0)
    used, cells = np.unique(cells[own], return_inverse=True)
    cells = cells.reshape(-1, np.asarray(mesh.cells).shape[1])
    number = np.full(len(points), -1)
    number[used] = np.arange(len(used))
    outer = np.asarray(_engine.boundary(mesh.cells)[0])
    named = {AIRWAY: np.asarray(mesh.surfaces["airway"])}
    if "wall" in mesh.node_sets:
        named[WALL] = outer[np.isin(outer, np.asarray(mesh.node_sets["wall"])).all(axis=1)]
    parts = {label: number[faces] for label, faces in named.items()}
    parts = {label: faces[(faces >= 0).all(axis=1)] for label, faces in parts.items()}
    cell, face = ("tetra10", "triangle6") if cells.shape[1] == 10 else ("tetra", "triangle")
    meshio.Mesh(
        points[used],
        [(cell, cells), *((face, faces) for faces in parts.values())],
        cell_data={
            "label": [
                np.asarray(mesh.cell_layer)[own] + 1,
                *(np.full(len(faces), label) for label, faces in parts.items()),
            ]
        },
    ).write(path)
    surfaces = {"airway": AIRWAY} | ({"wall": WALL} if WALL in parts else {})
    return {
        "file": path,
        "layers": {name: k + 1 for k, name in enumerate(mesh.layer_names)},
        "surfaces": surfaces,
        "order": mesh.order,
    }


def mirrored_larynx(
    larynx: plica.Larynx, path: Path, mirror: str, signs: tuple[int, int] = (1, 1)
) -> plica.MeshFile:
    """The part of a larynx from a file, to be mirrored."""
    fields = write_part(plica.build_mesh(larynx), path, {"fold": 1, "quarter": 2}[mirror], signs)
    return plica.MeshFile(mirror=mirror, **fields)


def write_fold(
    path: Path,
    *,
    gap: Callable[[Floats, Floats], Floats] = lambda y, z: np.full_like(y, 0.2),
    y: tuple[float, float] = (0.0, 12.0),
    divisions: tuple[int, int, int] = (4, 6, 8),
) -> dict[str, Any]:
    """Write the right one of two folds that are extruded along y, in mm, 8 mm deep and high.

    The lower half of its medial surface slopes by 50 degrees, the upper half is vertical, `gap` (of y and z,
    (n) each) from x = 0.
    Labels: 1 the inner half (cover) and 2 the outer half (body); 11 the airway, 12 the lateral side, 13 the
    end at the smallest y, 14 that at the largest. Returns what a MeshFile of it needs.
    """
    block = plica.build_mesh(plica.Block(size=(1.0, 1.0, 1.0), divisions=divisions))
    u, v, w = np.asarray(block.points).T
    along, height = y[0] + (y[1] - y[0]) * v, 8.0 * w
    medial = gap(along, height) + np.tan(np.radians(50)) * np.maximum(4.0 - height, 0.0)
    points = np.column_stack((medial + u * (9.0 - medial), along, height))
    cells = np.asarray(block.cells)
    inner = u[cells].mean(axis=1) < 0.5
    kinds = {11: ("x_min",), 12: ("x_max",), 13: ("y_min",), 14: ("y_max",)}
    faces = {label: np.concatenate([block.surfaces[one] for one in of]) for label, of in kinds.items()}
    meshio.Mesh(
        points,
        [("tetra", cells), *(("triangle", one) for one in faces.values())],
        cell_data={
            "label": [np.where(inner, 1, 2), *(np.full(len(one), label) for label, one in faces.items())]
        },
    ).write(path)
    return {
        "file": path,
        "unit": "mm",
        "layers": {"cover": 1, "body": 2},
        "surfaces": {"airway": 11, "lateral": 12, "ends": (13, 14)},
    }
