"""Which displacement components a scene fixes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import NDArray

from plica.errors import SceneError, nearest, one_of
from plica.measures.mesh_data import MeshData
from plica.measures.record import Array
from plica.scene.mesh.parts import Larynx

if TYPE_CHECKING:
    from plica.scene.scene import Scene

__all__ = ["MeshArrays", "fixed_components", "places_at_rest"]


_SAME = 1e-9  # of the glottis's length, by which its ends may be off


class MeshArrays(MeshData, Protocol):
    """A mesh with its sides and sets of nodes."""

    @property
    def cell_side(self) -> Array:
        """(m) 0 none, 1 left, 2 right."""

    @property
    def node_sets(self) -> Mapping[str, Array]:
        """Named nodes."""

    @property
    def rest(self) -> Array | None:
        """(n, 3) m, before the posture; None without one."""


def places_at_rest(mesh: MeshArrays) -> NDArray[np.float64]:
    """Where the nodes (n, 3) of a mesh are without a posture, m."""
    return np.asarray(mesh.points if mesh.rest is None else mesh.rest, dtype=float)


def fixed_components(scene: Scene, mesh: MeshArrays) -> NDArray[np.bool_]:
    """Which displacement components are fixed, (n, 3)."""
    fixed = np.zeros((len(mesh.points), 3), dtype=bool)
    if scene.supports is None:
        return fixed
    sets = mesh.node_sets
    for k, name in enumerate(scene.supports.fixed):
        if name not in sets:
            hint = nearest(name, sets)
            raise SceneError(f'{scene.source}: supports.fixed[{k}] = "{name}"; must be {one_of(sets)}.{hint}')
        nodes = np.asarray(sets[name])
        if name == "wall" and scene.supports.wall_from_y is not None:
            nodes = nodes[np.abs(places_at_rest(mesh)[nodes, 1]) >= scene.supports.wall_from_y]
            if not len(nodes):
                value = scene.supports.wall_from_y
                raise SceneError(
                    f"{scene.source}: supports.wall_from_y = {value:g} m; must leave a node of the wall."
                )
        fixed[nodes] = True
    if scene.supports.cartilages:
        assert isinstance(scene.mesh, Larynx)
        half_length = float(scene.mesh.all_options()["major"])
        fixed[np.abs(places_at_rest(mesh)[:, 1]) >= half_length * (1 - _SAME)] = True
    for name, components in scene.supports.components.items():
        if name not in sets:
            hint = nearest(name, sets)
            raise SceneError(f"{scene.source}: supports.components.{name}; must be {one_of(sets)}.{hint}")
        for component in components:
            fixed[np.asarray(sets[name]), "xyz".index(component)] = True
    return fixed
