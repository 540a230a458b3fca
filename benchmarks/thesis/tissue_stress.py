"""Stress in linear tetrahedra from the motion of their nodes."""

from __future__ import annotations

from typing import Any

import numpy as np

from plica import _engine as engine


class TissueStress:
    """Kelvin-Voigt stress, S = D E + eta E', of linear tetrahedra; one value a cell.

    points (n, 3) m, cells (m, 4), materials of the engine, cell_material (m).
    """

    def __init__(
        self, points: np.ndarray, cells: np.ndarray, materials: list[Any], cell_material: np.ndarray
    ) -> None:
        edges = points[cells[:, 1:]] - points[cells[:, :1]]
        inner = np.linalg.inv(edges).transpose(0, 2, 1)  # gradients of the last three shape functions
        self._gradient = np.concatenate((-inner.sum(axis=1, keepdims=True), inner), axis=1)
        self._cells = cells
        self._stiffness = np.array([engine.elasticity_matrix(m) for m in materials])[cell_material]
        self._viscosity = np.array([m.viscosity for m in materials])[cell_material]

    def _strain(self, field: np.ndarray) -> np.ndarray:
        """(m, 3, 3), symmetric gradient of a nodal field (n, 3)."""
        gradient = np.einsum("mai,maj->mij", field[self._cells], self._gradient)
        return 0.5 * (gradient + gradient.transpose(0, 2, 1))

    def tensor(self, displacement: np.ndarray, velocity: np.ndarray) -> np.ndarray:
        """(m, 3, 3) Pa."""
        rows, columns = [0, 1, 2, 0, 1, 2], [0, 1, 2, 1, 2, 0]  # xx, yy, zz, xy, yz, zx
        voigt = self._strain(displacement)[:, rows, columns] * [1, 1, 1, 2, 2, 2]
        elastic = np.einsum("mij,mj->mi", self._stiffness, voigt)
        stress = self._viscosity[:, None, None] * self._strain(velocity)
        stress[:, rows, columns] += elastic
        stress[:, columns[3:], rows[3:]] += elastic[:, 3:]
        return stress

    def least_principal(self, displacement: np.ndarray, velocity: np.ndarray) -> np.ndarray:
        """(m) Pa, negative where compressed."""
        return np.linalg.eigvalsh(self.tensor(displacement, velocity))[:, 0]
