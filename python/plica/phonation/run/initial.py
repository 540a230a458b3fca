"""Displacement and velocity at t = 0."""

from __future__ import annotations

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
    """The lateral opening pattern of `Initial`, (n, 3), of size one at the upper glottal edge."""
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
    """Height at which the minor half-axis first reaches `minor`, going through (z, minor half-axis) rows."""
    for (z0, m0), (z1, m1) in pairwise(sections):
        if m1 >= minor:
            return float(z0 + (z1 - z0) * (minor - m0) / (m1 - m0))
    return float(sections[-1, 0])


def initial_fields(
    scene: Scene, mesh: _engine.TetMesh, fixed: NDArray[np.bool_]
) -> tuple[_Reals | None, _Reals | None]:
    """Displacement m and velocity m/s, (n, 3) each, or None where at rest; zero where `fixed` (n, 3)."""
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
        for layer, value in uniform.items():
            if layer not in mesh.layer_names:
                hint = nearest(layer, mesh.layer_names)
                where = f"{scene.source}: initial.{name}.{layer}"
                raise SceneError(
                    f"{where} is not a layer of the mesh; must be {one_of(mesh.layer_names)}.{hint}"
                )
            cells = np.asarray(mesh.cells)[np.asarray(mesh.cell_layer) == mesh.layer_names.index(layer)]
            field[np.unique(cells)] = value
        field[fixed] = 0.0
        found.append(field if field.any() else None)
    return found[0], found[1]
