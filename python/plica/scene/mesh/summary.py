"""Summary of a mesh (counts, quality, volumes), and writing it for other programs."""

from __future__ import annotations

import contextlib
import io
import os
import tempfile
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from plica import _engine
from plica.errors import InvalidInput, library
from plica.measures.contour import narrowest_gap
from plica.measures.mesh_data import toward_right
from plica.storage.files import storage_errors
from plica.tetrahedron import EDGES

__all__ = ["dihedral_angles", "mesh_summary", "quality", "write_mesh"]


def quality(points: NDArray[np.float64], cells: NDArray[np.int32]) -> NDArray[np.float64]:
    """Mean-ratio quality 12 (3 V)^(2/3) / (sum of squared edges), (m); 1 for a regular tetrahedron."""
    volumes = _engine.signed_volumes(points, cells)
    squares = sum(((points[cells[:, a]] - points[cells[:, b]]) ** 2).sum(axis=1) for a, b in EDGES)
    return np.asarray(12 * np.cbrt(3 * np.abs(volumes)) ** 2 / squares)


def dihedral_angles(points: NDArray[np.float64], cells: NDArray[np.int32]) -> NDArray[np.float64]:
    """Dihedral angles of each cell at its six edges, degrees (m, 6); quadratic cells by their corners."""
    angles = []
    for a, b in EDGES:
        c, d = (k for k in range(4) if k not in (a, b))
        along = points[cells[:, b]] - points[cells[:, a]]
        first, second = (np.cross(along, points[cells[:, k]] - points[cells[:, a]]) for k in (c, d))
        angles.append(
            np.arctan2(np.linalg.norm(np.cross(first, second), axis=1), (first * second).sum(axis=1))
        )
    return np.asarray(np.degrees(np.stack(angles, axis=1)))


def mesh_summary(mesh: _engine.TetMesh) -> str:
    """Counts, extent, quality, layers, surfaces and node sets, as text."""
    points, cells = np.asarray(mesh.points), np.asarray(mesh.cells)
    volumes = np.asarray(_engine.signed_volumes(points, cells))
    ratio = quality(points, cells)
    kind = "quadratic" if mesh.order == 2 else "linear"
    extent = " x ".join(f"{1e3 * length:.4g}" for length in np.ptp(points, axis=0))
    low, middle = ratio.min(), np.median(ratio)
    angles = dihedral_angles(points, cells)
    flattest = int(angles.min(axis=1).argmin())
    held = (
        f", {3 * (len(points) - len(wall))} with the wall held" if (wall := _wall(mesh)) is not None else ""
    )
    lines = [
        f"{len(cells)} {kind} tetrahedra, {len(points)} nodes, {3 * len(points)} displacement components "
        f"before supports{held}, {extent} mm",
        f"quality (mean ratio, 1 is best): least {low:.3f} in cell {ratio.argmin()}, median {middle:.3f}",
        f"dihedral angles: {angles.min():.1f} (cell {flattest}) to {angles.max():.1f} degrees",
        *_curved(mesh, points, cells),
        "",
        *_axes(mesh),
        *_posture(mesh),
        f"{'layer':<20}{'tetrahedra':>12}{'left':>10}{'right':>10}{'volume':>16}",
    ]
    layer, side = np.asarray(mesh.cell_layer), np.asarray(mesh.cell_side)
    for number, name in enumerate(mesh.layer_names):
        own = layer == number
        counts = f"{own.sum():>12}{(own & (side == 1)).sum():>10}{(own & (side == 2)).sum():>10}"
        lines.append(f"{name:<20}{counts}{1e9 * volumes[own].sum():>11.2f} mm^3")
    lines.append("")
    lines += [f"surface {name:<20}{len(faces):>8} faces" for name, faces in mesh.surfaces.items()]
    lines += [f"node set {name:<19}{len(nodes):>8} nodes" for name, nodes in mesh.node_sets.items()]
    return "\n".join(lines)


def _axes(mesh: _engine.TetMesh) -> list[str]:
    """Lines on the directions of a mesh with a left and a right fold and what joins them; none for others."""
    cells, side = np.asarray(mesh.cells), np.asarray(mesh.cell_side)
    if not (direction := toward_right(mesh.points, mesh.cells, side)):
        return []
    sign = "-" if direction < 0 else ""
    shared = len(np.intersect1d(cells[side == 1], cells[side == 2]))
    return [
        f"directions: {sign}x to the right fold, {sign}y to the front (anterior), z up, as the air goes",
        f"the folds share {shared or 'no'} node{'' if shared < 2 else 's'}",
        "",
    ]


def _posture(mesh: _engine.TetMesh) -> list[str]:
    """Lines on what a posture has made of the airway; none without one."""
    if mesh.rest is None:
        return []
    airway = mesh.surfaces.get("airway")
    if airway is None:
        return ["at a posture", ""]
    faces, shapes = np.asarray(airway), [np.asarray(places) for places in (mesh.rest, mesh.points)]
    long = [1e3 * float(np.ptp(x[np.unique(faces), 1])) for x in shapes]
    narrow = [1e3 * narrowest_gap(x, faces) for x in shapes]
    return [
        f"at a posture: airway {long[1]:.4g} mm long, at rest {long[0]:.4g}; in its middle plane at least "
        f"{narrow[1]:.3g} mm wide, at rest {narrow[0]:.3g}",
        "",
    ]


def _wall(mesh: _engine.TetMesh) -> NDArray[np.int32] | None:
    sets = mesh.node_sets
    return np.asarray(sets["wall"]) if "wall" in sets else None


def _curved(mesh: _engine.TetMesh, points: NDArray[np.float64], cells: NDArray[np.int32]) -> list[str]:
    """A line on the curvature of quadratic cells; none for linear ones."""
    if mesh.order == 1:
        return []
    ratio = np.asarray(_engine.least_jacobian_ratios(points, cells))
    return [
        f"curved sides: {(ratio < 1 - 1e-9).sum()} cells; det dx/dxi at least {ratio.min():.3f} of the "
        f"straight cell's, in cell {ratio.argmin()}"
    ]


def write_mesh(mesh: _engine.TetMesh, path: Path) -> None:
    """Write the mesh with the numbers of its layers and sides as cell data, in the format of the suffix.

    Surfaces, node sets and the names of layers are not written.
    """
    meshio = library("meshio", "mesh", f"{path.name}")
    if not path.name.lower().endswith(tuple(meshio.extension_to_filetypes)):
        raise InvalidInput(f"{path}: must have the suffix of a mesh format, e.g. .vtu, .vtk, .msh or .xdmf.")
    kind = "tetra10" if mesh.order == 2 else "tetra"
    data = {"layer": [np.asarray(mesh.cell_layer)], "side": [np.asarray(mesh.cell_side)]}
    if path.suffix == ".msh":
        data = {"gmsh:physical": data["layer"], "gmsh:geometrical": data["side"]}
    made = meshio.Mesh(np.asarray(mesh.points), [(kind, np.asarray(mesh.cells))], cell_data=data)
    with (
        storage_errors(path),
        tempfile.TemporaryDirectory(prefix=f".{path.name}.", dir=path.parent) as drafts,
        contextlib.redirect_stdout(io.StringIO()),
        contextlib.redirect_stderr(io.StringIO()),
    ):
        draft = Path(drafts, path.name)
        try:
            if path.suffix == ".msh":
                made.write(draft, file_format="gmsh22")
            else:
                made.write(draft)
        except (meshio.WriteError, meshio.ReadError) as error:
            raise InvalidInput(f"{path}: cannot be written as a mesh: {error}") from None
        for part in sorted(draft.parent.iterdir(), key=draft.__eq__):  # formats with a second file: this last
            os.replace(part, path.with_name(part.name))
