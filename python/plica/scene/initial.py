"""Displacement and velocity at t = 0."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from plica.errors import InvalidInput, SceneError, nearest, one_of
from plica.scene.held import MeshArrays, places_at_rest
from plica.scene.mesh.changed import changed_mesh
from plica.scene.mesh.fold_surface import sides_of_nodes
from plica.scene.mesh.parts import Larynx
from plica.scene.opening import Glottis, opening_pattern
from plica.scene.scene import Scene

__all__ = ["initial_fields"]

_Reals = NDArray[np.float64]


def initial_fields(
    scene: Scene, mesh: MeshArrays, fixed: NDArray[np.bool_]
) -> tuple[_Reals | None, _Reals | None]:
    """Displacement m and velocity m/s, (n, 3) each, or None if zero; zero where `fixed` (n, 3)."""
    if scene.initial is None:
        return None, None
    points, at_rest = np.asarray(mesh.points), places_at_rest(mesh)
    initial = scene.initial
    found: list[_Reals | None] = []
    for name, size, uniform in (
        ("displacement", initial.opening_displacement, initial.displacement),
        ("velocity", initial.opening_velocity, initial.velocity),
    ):
        field = np.zeros_like(points)
        if size is not None:
            glottis = _glottis(scene, mesh, f"initial.opening_{name}")
            field += size * opening_pattern(at_rest, glottis, _sides(scene, mesh))
        nodes = {
            region: _nodes_of(region, mesh, f"{scene.source}: initial.{name}.{region}") for region in uniform
        }
        for fold in nodes.keys() - set(mesh.layer_names):
            field[nodes[fold]] = uniform[fold]
        field[_between_folds(mesh, uniform)] = 0.0
        for layer in mesh.layer_names:  # in the order of the mesh, not of the scene
            if layer in nodes:
                field[nodes[layer]] = uniform[layer]
        field[fixed] = 0.0
        found.append(field if field.any() else None)
    return found[0], found[1]


def _sides(scene: Scene, mesh: MeshArrays) -> _Reals | None:
    """To which fold nodes belong (n) where a lesion may stand across the middle plane; None elsewhere."""
    folds = scene.mesh.folds if isinstance(scene.mesh, Larynx) else None
    if folds is None or not folds.lesions:
        return None
    return sides_of_nodes(np.asarray(mesh.cells), np.asarray(mesh.cell_side), len(mesh.points))


def _glottis(scene: Scene, mesh: MeshArrays, key: str) -> Glottis:
    if isinstance(scene.mesh, Larynx):
        return Glottis.of_larynx(scene.mesh)
    try:
        unstretched = mesh if mesh.rest is None else changed_mesh(mesh, points=mesh.rest, rest=None)
        return Glottis.of_mesh(unstretched, "airway" if scene.airflow is None else scene.airflow.surface)
    except InvalidInput as error:
        raise SceneError(f"{scene.source}: {key} {error}") from None


def _regions(mesh: MeshArrays) -> dict[str, NDArray[np.bool_]]:
    """Names and cells (m) of the layers and, if the mesh has sides, of the folds; layers take precedence."""
    layer, side = np.asarray(mesh.cell_layer), np.asarray(mesh.cell_side)
    folds = {name: side == number for number, name in ((1, "left"), (2, "right")) if (side == number).any()}
    return folds | {name: layer == k for k, name in enumerate(mesh.layer_names)}


def _nodes_of(region: str, mesh: MeshArrays, where: str) -> NDArray[np.int32]:
    regions = _regions(mesh)
    if region not in regions:
        hint = nearest(region, regions)
        raise SceneError(f"{where} is not a layer or fold of the mesh; must be {one_of(regions)}.{hint}")
    return np.unique(np.asarray(mesh.cells)[regions[region]])


def _between_folds(mesh: MeshArrays, uniform: Mapping[str, object]) -> NDArray[np.int32]:
    """Nodes shared by both folds, which stay at rest if each fold has its own value."""
    if not {"left", "right"} <= uniform.keys() - set(mesh.layer_names):
        return np.empty(0, dtype=np.int32)
    left, right = (_nodes_of(fold, mesh, "") for fold in ("left", "right"))
    return np.intersect1d(left, right)
