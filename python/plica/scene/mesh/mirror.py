"""One fold, or a quarter of a larynx, mirrored to all of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from plica import _engine
from plica.errors import SceneError
from plica.scene.mesh.parts import BOUNDARY, MeshFile
from plica.tetrahedron import EDGES

__all__ = ["MIRROR_PLANES", "mirrored"]

_Reals = NDArray[np.float64]
_Integers = NDArray[np.int32]
_Faces = dict[str, _Integers]

MIRROR_PLANES = {"fold": 1, "quarter": 2}
"""In how many planes a part is mirrored: x = 0; y = 0, too."""
_ON_PLANE = 1e-6  # of the mesh's extent: what files of few digits leave
_ALMOST = 1e-3  # mean edges: nearer faces are a cut that is not flat, not walls of a gap
# Corners 0 and 2 exchanged: node 6 stays between them and 8 opposite, the line about which cells are refined.
_IMAGE_OF_CELL = {4: [2, 1, 0, 3], 10: [2, 1, 0, 3, 5, 4, 6, 9, 8, 7]}
_IMAGE_OF_FACE = {3: [0, 2, 1], 6: [0, 2, 1, 5, 4, 3]}


def mirrored(part: _engine.TetMesh, mesh: MeshFile, where: str) -> _engine.TetMesh:
    """The part and its images in x = 0 and, of a quarter, in y = 0, in one mesh.

    Nodes and cells of the part come first, in their order; then those of its image in x = 0; then the images
    of both in y = 0. Nodes in a plane (within a millionth of the mesh's extent, moved into it) are their own
    images, so that faces in a plane join both sides to one tissue. Each surface has the faces of all images,
    but for those in a plane, which are inside; NAME_left (x < 0) and NAME_right are those of one fold.

    Raises
    ------
    SceneError
        If the part lies on both sides of a plane, does not end in it as a cut must, or a surface lies in it.
    InvalidInput
        If the part is no valid mesh.
    """
    assert mesh.mirror is not None
    _engine.check_mesh(part)
    planes = MIRROR_PLANES[mesh.mirror]

    def fail(text: str) -> SceneError:
        return SceneError(f'{where}: mesh.mirror = "{mesh.mirror}": {mesh.file.name} {text}')

    points, cells = np.array(part.points), np.asarray(part.cells)
    extent = float(np.ptp(points, axis=0).max())
    for axis in range(planes):
        _require_one_side(points, axis, _ON_PLANE * extent, fail)
        points[np.abs(points[:, axis]) <= _ON_PLANE * extent, axis] = 0.0
    for axis in range(planes):
        _require_cut(points, cells, axis, fail)
    surfaces = _outside(part.surfaces, points[:, :planes] == 0, mesh, where)
    for axis in range(planes):
        points, cells, surfaces = _with_image(points, cells, surfaces, axis)
    surfaces = _by_fold(points, surfaces)
    left = points[cells[:, :4], 0].mean(axis=1) < 0
    return _engine.TetMesh(
        points=points,
        cells=cells,
        cell_layer=np.tile(np.asarray(part.cell_layer), 1 << planes),
        cell_side=np.where(left, 1, 2).astype(np.int32),
        layer_names=list(part.layer_names),
        surfaces=surfaces,
        node_sets={name: np.unique(faces) for name, faces in surfaces.items()},
    )


def _require_one_side(points: _Reals, axis: int, tolerance: float, fail: Callable[[str], SceneError]) -> None:
    low, high = (int(find(points[:, axis])) for find in (np.argmin, np.argmax))
    if points[low, axis] < -tolerance and points[high, axis] > tolerance:
        either = (
            "move it if it has one fold, or leave mirror out if it has both",
            'or if it is all of a fold, use mirror = "fold"',
        )[axis]
        raise fail(
            f"lies on both sides of {_plane(axis)}: {_node(points, low)} and {_node(points, high)}; must lie "
            f"on one. Cut it in that plane, {either}."
        )


def _require_cut(points: _Reals, cells: _Integers, axis: int, fail: Callable[[str], SceneError]) -> None:
    """Raise unless the cells end at the plane in whole faces, or beside it."""
    distance = np.abs(points[:, axis])
    on = distance == 0
    if cells.shape[1] == 10:
        _require_straight(points, cells, on, axis, fail)
    faces = np.asarray(_engine.boundary(cells)[0])
    in_plane = on[faces].all(axis=1)
    ends = np.asarray([points[cells[:, b]] - points[cells[:, a]] for a, b in EDGES])
    almost = _ALMOST * float(np.linalg.norm(ends, axis=2).mean())
    beside = ~in_plane & (distance[faces].max(axis=1) <= almost)
    if beside.any():
        node = int(faces[beside][0][np.argmax(distance[faces[beside][0]])])
        raise fail(
            f"almost ends in {_plane(axis)}: {_node(points, node)}, of {int(beside.sum())} faces; must end "
            f"in it, or at least {almost:.2g} m beside it. Cut it flat, and write the file with more digits."
        )
    if axis == 0:
        _require_near(points, fail)
    else:
        _require_joined(points, faces[in_plane], fail)


def _require_near(points: _Reals, fail: Callable[[str], SceneError]) -> None:
    distance, width = float(np.abs(points[:, 0]).min()), float(np.ptp(points[:, 0]))
    if distance > width:
        raise fail(
            f"is {distance:.3g} m from {_plane(0)}, further than it is wide ({width:.3g} m); the plane must "
            "be the midplane between the folds. Move the mesh."
        )


def _require_joined(points: _Reals, cut: _Integers, fail: Callable[[str], SceneError]) -> None:
    """Raise unless the faces of the cut in y = 0 have all nodes there, and are some."""
    distance = np.abs(points[:, 1])
    if not len(cut):
        raise fail(
            f"has no face in {_plane(1)}, where a quarter is cut from the fold; must have some. Nearest is "
            f"{_node(points, int(distance.argmin()))}. Move the mesh, or if it is all of a fold, "
            'use mirror = "fold".'
        )
    hinged = np.setdiff1d(np.flatnonzero(distance == 0), cut)
    if len(hinged):
        raise fail(
            f"meets {_plane(1)} in {_node(points, int(hinged[0]))} without a face there; must end in it in "
            "faces, as only these hold both sides together. Cut it in that plane."
        )


def _require_straight(
    points: _Reals, cells: _Integers, on: NDArray[np.bool_], axis: int, fail: Callable[[str], SceneError]
) -> None:
    """Raise if a quadratic edge begins and ends in the plane, but is curved out of it."""
    for k, (a, b) in enumerate(EDGES):
        curved = on[cells[:, a]] & on[cells[:, b]] & ~on[cells[:, 4 + k]]
        if curved.any():
            ends = cells[int(np.argmax(curved))]
            raise fail(
                f"has the edge between nodes {ends[a]} and {ends[b]} in {_plane(axis)}, but its mid-side "
                f"{_node(points, int(ends[4 + k]))} beside it; must be in it. Cut it flat."
            )


def _outside(surfaces: Mapping[str, _Integers], on: NDArray[np.bool_], mesh: MeshFile, where: str) -> _Faces:
    """The faces that lie in none of the planes, of `on` (n, planes); labelled ones must not lie there."""
    found = {}
    for name, every in surfaces.items():
        faces = np.asarray(every)
        counts = [int(on[faces, axis].all(axis=1).sum()) for axis in range(on.shape[1])]
        kept = faces[~np.any([on[faces, axis].all(axis=1) for axis in range(on.shape[1])], axis=0)]
        if len(kept) < len(faces) and (_is_labelled(mesh, name) or not len(kept)):
            axis = int(np.argmax(counts))
            touching = ", or if the folds touch at rest, leave a small gap between them" if axis == 0 else ""
            raise SceneError(
                f"{where}: mesh.surfaces.{name} has {counts[axis]} of its {len(faces)} faces in "
                f"{_plane(axis)}, which mesh.mirror makes the inside of one tissue; must have none there, as "
                f"no support, load or air can be there. Leave them out of it{touching}."
            )
        _require_rim(name, kept, on[:, 0], where)
        found[name] = kept
    return found


def _is_labelled(mesh: MeshFile, name: str) -> bool:
    wanted = mesh.surfaces[name]
    return isinstance(wanted, tuple) and wanted != (BOUNDARY,)


def _require_rim(name: str, faces: _Integers, on: NDArray[np.bool_], where: str) -> None:
    """Raise where a surface touches the plane x = 0 in an edge that two of its faces have."""
    edges = np.sort(np.concatenate([faces[:, [k, (k + 1) % 3]] for k in range(3)]), axis=1)
    edges, count = np.unique(edges[on[edges].all(axis=1)], axis=0, return_counts=True)
    if (count > 1).any():
        a, b = edges[count > 1][0]
        raise SceneError(
            f"{where}: mesh.surfaces.{name} touches {_plane(0)} in the edge between the nodes {a} and {b}, "
            "which mesh.mirror gives to both folds; must only end there. Is x = 0 the midplane between the "
            "folds? If so, leave a small gap beside it."
        )


def _with_image(
    points: _Reals, cells: _Integers, surfaces: _Faces, axis: int
) -> tuple[_Reals, _Integers, _Faces]:
    """Points, cells and surfaces with their images in a plane behind them."""
    off = points[:, axis] != 0
    image = np.arange(len(points), dtype=np.int32)
    image[off] = len(points) + np.arange(off.sum(), dtype=np.int32)
    sign = np.where(np.arange(3) == axis, -1.0, 1.0)
    both = {
        name: np.concatenate([faces, image[faces][:, _IMAGE_OF_FACE[faces.shape[1]]]])
        for name, faces in surfaces.items()
    }
    turned = image[cells][:, _IMAGE_OF_CELL[cells.shape[1]]]
    return np.concatenate([points, points[off] * sign]), np.concatenate([cells, turned]), both


def _by_fold(points: _Reals, surfaces: _Faces) -> _Faces:
    """Each surface, and its faces of the left (x < 0) and of the right fold."""
    found: _Faces = {}
    for name, faces in surfaces.items():
        left = points[faces[:, :3], 0].mean(axis=1) < 0
        found |= {name: faces, f"{name}_left": faces[left], f"{name}_right": faces[~left]}
    return found


def _plane(axis: int) -> str:
    return f"the plane {'xy'[axis]} = 0"


def _node(points: _Reals, node: int) -> str:
    return f"node {node} at ({', '.join(f'{coordinate:.4g}' for coordinate in points[node])}) m"
