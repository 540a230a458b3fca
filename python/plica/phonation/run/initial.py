"""Displacement and velocity at t = 0."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from plica import _engine
from plica.errors import SceneError, nearest, one_of
from plica.phonation.scene.mesh_parts import Larynx
from plica.phonation.scene.mesh_source import larynx_fields
from plica.phonation.scene.scene import Scene

__all__ = ["initial_fields", "opening_pattern"]

_Reals = NDArray[np.float64]


def opening_pattern(points: _Reals, larynx: Larynx) -> _Reals:
    """The lateral opening pattern of `Initial`, (n, 3), equal to one at the upper glottal edge."""
    fields = larynx_fields(larynx)
    b, radius = float(fields["major"]), float(fields["radius"])
    sections = np.asarray(fields["sections"])  # (k, 2): z, minor half-axis, m
    a = sections[:, 1].min()
    edge = np.flatnonzero(sections[:, 1] == a)[-1]
    z_edge = sections[edge, 0]
    z_low = _widened(sections[edge::-1], 4 * a)
    z_high = _widened(sections[edge:], 4 * a)
    x, y, z = points.T
    inside = np.abs(y) < b
    reach = np.where(z <= z_edge, z_low - z_edge, z_high - z_edge)
    ratio = np.clip((z - z_edge) / reach, 0.0, 1.0)
    along = np.where(inside, np.cos(0.5 * np.pi * y / b), 0.0)
    height = 0.5 * (1 + np.cos(np.pi * ratio))
    wall = np.sqrt(np.maximum(radius**2 - y**2, 0.0))
    airway = a * np.sqrt(np.maximum(1 - (y / b) ** 2, 0.0))
    depth = np.clip((wall - np.abs(x)) / np.where(inside, wall - airway, 1.0), 0.0, 1.0)
    pattern = np.zeros_like(points)
    pattern[:, 0] = np.sign(x) * along * height * depth
    return pattern


def _widened(sections: _Reals, minor: float) -> float:
    """Height at which the minor half-axis first reaches `minor` along rows of (z, minor half-axis)."""
    for (z0, m0), (z1, m1) in pairwise(sections):
        if m1 >= minor:
            return float(z0 + (z1 - z0) * (minor - m0) / (m1 - m0))
    return float(sections[-1, 0])


def initial_fields(
    scene: Scene, mesh: _engine.TetMesh, fixed: NDArray[np.bool_]
) -> tuple[_Reals | None, _Reals | None]:
    """Displacement m and velocity m/s, (n, 3) each, or None if zero; zero where `fixed` (n, 3)."""
    if scene.initial is None:
        return None, None
    points = np.asarray(mesh.points)
    initial = scene.initial
    found: list[_Reals | None] = []
    for name, size, uniform in (
        ("displacement", initial.opening_displacement, initial.displacement),
        ("velocity", initial.opening_velocity, initial.velocity),
    ):
        field = np.zeros_like(points)
        if size is not None and isinstance(scene.mesh, Larynx):
            field += size * opening_pattern(points, scene.mesh)
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


def _regions(mesh: _engine.TetMesh) -> dict[str, NDArray[np.bool_]]:
    """Names and cells (m) of the layers and, if the mesh has sides, of the folds; layers take precedence."""
    layer, side = np.asarray(mesh.cell_layer), np.asarray(mesh.cell_side)
    folds = {name: side == number for number, name in ((1, "left"), (2, "right")) if (side == number).any()}
    return folds | {name: layer == k for k, name in enumerate(mesh.layer_names)}


def _nodes_of(region: str, mesh: _engine.TetMesh, where: str) -> NDArray[np.int32]:
    regions = _regions(mesh)
    if region not in regions:
        hint = nearest(region, regions)
        raise SceneError(f"{where} is not a layer or fold of the mesh; must be {one_of(regions)}.{hint}")
    return np.unique(np.asarray(mesh.cells)[regions[region]])


def _between_folds(mesh: _engine.TetMesh, uniform: Mapping[str, object]) -> NDArray[np.int32]:
    """Nodes shared by both folds, which stay at rest if each fold has its own value."""
    if not {"left", "right"} <= uniform.keys() - set(mesh.layer_names):
        return np.empty(0, dtype=np.int32)
    left, right = (_nodes_of(fold, mesh, "") for fold in ("left", "right"))
    return np.intersect1d(left, right)
