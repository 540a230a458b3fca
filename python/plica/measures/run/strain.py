"""The strain of the tissue at nodes, of a displacement: that of the waveforms `strain_999` and
`strain_largest`, which the engine reads off at points within the cells."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from scipy import sparse

from plica import _engine
from plica.measures.mesh_data import MeshData
from plica.measures.record import Array, Floats
from plica.measures.scene_text import scene_tables

__all__ = ["NodalStrain", "is_finite"]


def is_finite(scene_text: str) -> bool:
    """Whether the tissue of a scene is at finite strain, which is then Green and Lagrange's."""
    return "strain" in scene_tables(scene_text)


class NodalStrain:
    """Largest principal strain's magnitude, by the mesh in its reference position.

    Parameters
    ----------
    mesh : MeshData
    green : bool
        Green and Lagrange's strain, else the small strain.
    """

    def __init__(self, mesh: MeshData, *, green: bool) -> None:
        self._cells = np.asarray(mesh.cells)
        points = np.asarray(mesh.points, dtype=float)
        self._gauge = _engine.StrainGauge(_engine.TetMesh(points=points, cells=self._cells), green=green)
        self.volumes: Floats = self._gauge.volumes().reshape(len(self._cells), -1)
        self._nodes = len(points)

    def at_points(self, displacement: Array) -> Floats:
        """(m, 1) or (m, 4): at the points of each cell, which stand for `volumes` (m^3); displacement (n, 3)
        m."""
        found = self._gauge.at_points(np.asarray(displacement, dtype=float))
        return np.asarray(found.reshape(self.volumes.shape))

    def at_nodes(self, displacement: Array) -> Floats:
        """(n) mean of the cells that meet at each node, weighted by volume; 0 at nodes of no cell."""
        return np.asarray(self._mean @ (self.at_points(displacement) * self.volumes).sum(axis=1))

    @cached_property
    def _mean(self) -> sparse.csr_array:
        """(n, m) from the integrals over cells to the means at nodes."""
        count, corners = self._cells.shape
        at = (self._cells.ravel(), np.repeat(np.arange(count), corners))
        touching = sparse.csr_array((np.ones(at[0].size), at), shape=(self._nodes, count))
        volume = touching @ self.volumes.sum(axis=1)
        return sparse.csr_array(sparse.diags_array(1 / np.where(volume > 0, volume, 1.0)) @ touching)
