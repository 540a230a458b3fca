"""What a mesh is like: counts, quality, volumes; and writing it for other programs."""

from __future__ import annotations

import contextlib
import io
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from plica import _engine
from plica.errors import InvalidInput
from plica.storage.files import storage_errors

__all__ = ["mesh_summary", "quality", "write_mesh"]

_EDGES = ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3))


def quality(points: NDArray[np.float64], cells: NDArray[np.int32]) -> NDArray[np.float64]:
    """Mean-ratio quality 12 (3 V)^(2/3) / (sum of squared edges), (m); 1 for a regular tetrahedron."""
    volumes = _engine.signed_volumes(points, cells)
    squares = sum(((points[cells[:, a]] - points[cells[:, b]]) ** 2).sum(axis=1) for a, b in _EDGES)
    return np.asarray(12 * np.cbrt(3 * np.abs(volumes)) ** 2 / squares)


def mesh_summary(mesh: _engine.TetMesh) -> str:
    """Counts, extent, quality, layers, surfaces and node sets as a text."""
    points, cells = np.asarray(mesh.points), np.asarray(mesh.cells)
    volumes = np.asarray(_engine.signed_volumes(points, cells))
    ratio = quality(points, cells)
    kind = "quadratic" if mesh.order == 2 else "linear"
    extent = " x ".join(f"{1e3 * length:.4g}" for length in np.ptp(points, axis=0))
    low, middle = ratio.min(), np.median(ratio)
    lines = [
        f"{len(cells)} {kind} tetrahedra, {len(points)} nodes, {3 * len(points)} displacement components "
        f"before supports, {extent} mm",
        f"quality (mean ratio, 1 is best): least {low:.3f} in cell {ratio.argmin()}, median {middle:.3f}",
        "",
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


def write_mesh(mesh: _engine.TetMesh, path: Path) -> None:
    """Write the mesh with the numbers of its layers and sides as cell data, in the format of the suffix.

    Surfaces, node sets and the names of layers are not written.
    """
    import meshio

    kind = "tetra10" if mesh.order == 2 else "tetra"
    data = {"layer": [np.asarray(mesh.cell_layer)], "side": [np.asarray(mesh.cell_side)]}
    if path.suffix == ".msh":
        data = {"gmsh:physical": data["layer"], "gmsh:geometrical": data["side"]}
    made = meshio.Mesh(np.asarray(mesh.points), [(kind, np.asarray(mesh.cells))], cell_data=data)
    with (
        storage_errors(path),
        contextlib.redirect_stdout(io.StringIO()),
        contextlib.redirect_stderr(io.StringIO()),
    ):
        try:
            if path.suffix == ".msh":
                made.write(path, file_format="gmsh22")
            else:
                made.write(path)
        except (meshio.WriteError, meshio.ReadError) as error:
            raise InvalidInput(f"{path}: cannot be written as a mesh: {error}") from None
