"""Matrices of all nodes of a simulation, and its motion in the span of a basis."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from plica import _engine

__all__ = ["NodalMatrices", "ritz"]

Floats = NDArray[np.float64]


class NodalMatrices:
    """M, K and C (3 n, 3 n) of a simulation's free unknowns."""

    def __init__(self, simulation: _engine.Simulation, fixed: NDArray[np.bool_]) -> None:
        from scipy.sparse import csr_array

        self.free = ~fixed.ravel()
        shape = (self.free.size, self.free.size)

        def of(values: Any) -> Any:
            return csr_array(values, shape=shape)

        self.mass, self.stiffness = of(simulation.mass), of(simulation.stiffness)
        viscosity = simulation.viscosity
        self.viscosity = None if viscosity is None else of(viscosity)


def ritz(matrices: NodalMatrices, basis: Floats) -> tuple[Floats, Floats]:
    """Squares of frequencies (r) 1/s^2, ascending, and shapes (3 n, r), Phi^T M Phi = 1, in the span of a
    basis."""
    from scipy.linalg import eigh

    basis = basis / np.linalg.norm(basis, axis=0)
    M, K = (basis.T @ (matrix @ basis) for matrix in (matrices.mass, matrices.stiffness))
    scale = 1 / np.sqrt(np.diag(M))
    weights, axes = np.linalg.eigh(M * scale[:, None] * scale)
    kept = weights > 1e-12 * weights[-1]  # directions that repeat others to 1e-6
    combined = (scale[:, None] * axes[:, kept]) / np.sqrt(weights[kept])
    squares, turned = eigh(combined.T @ K @ combined)
    return squares, basis @ (combined @ turned)
