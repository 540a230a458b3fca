"""A body of one tissue in the engine, without a scene file."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array, csr_array

from plica import _engine as engine

__all__ = ["SCHEMES", "Body", "block", "facing", "free_block", "held", "mass_columns"]

Array = NDArray[np.float64]

SCHEMES: dict[str, Any] = {
    "HHT(-0.3)": engine.HilberHughesTaylor(alpha=-0.3),
    "HHT(-1/3)": engine.HilberHughesTaylor(alpha=-1 / 3),
    "HHT(-0.1)": engine.HilberHughesTaylor(alpha=-0.1),
    "trapezoidal": engine.Newmark(),
    "Newmark(1, 3/2)": engine.Newmark(beta=1.0, gamma=1.5),
}


@dataclass(frozen=True)
class Body:
    """A mesh of one material with held components."""

    mesh: Any
    material: Any
    fixed: NDArray[np.bool_]  # (n, 3)

    def simulation(self, **parts: Any) -> engine.Simulation:
        """A simulation of the body; `parts` as engine.Simulation takes them: scheme, step, contact, ..."""
        layer_of_cell = np.zeros(len(self.mesh.cells), int)
        return engine.Simulation(self.mesh, [self.material], ["tissue"], layer_of_cell, self.fixed, **parts)

    @cached_property
    def assembly(self) -> engine.Assembly:
        """Its matrices, on all unknowns."""
        return engine.Assembly(
            self.mesh, [self.material], ["tissue"], np.zeros(len(self.mesh.cells), np.int32)
        )

    @cached_property
    def free(self) -> NDArray[np.intp]:
        """Numbers of the free unknowns."""
        return np.flatnonzero(~self.fixed.ravel())

    def whole(self, matrix: Any) -> csr_array:
        """A matrix of the engine, (3 n, 3 n)."""
        return csr_array(matrix, shape=(self.fixed.size, self.fixed.size))

    def on_free(self, matrix: Any) -> csc_array:
        """A matrix of the engine on the free unknowns."""
        return self.whole(matrix)[self.free][:, self.free].tocsc()

    def field(self, values: Array) -> Array:
        """Nodal values (n, 3) from those of the free unknowns; zero where held."""
        full = np.zeros(self.fixed.size)
        full[self.free] = values
        return full.reshape(-1, 3)

    def hold(self, node_set: str, *components: int) -> Body:
        """The same with components (default: all) of a node set held."""
        fixed = self.fixed.copy()
        fixed[np.ix_(self.mesh.node_sets[node_set], components or (0, 1, 2))] = True
        return Body(self.mesh, self.material, fixed)


def held(mesh: Any, node_set: str) -> NDArray[np.bool_]:
    """Components (n, 3) that are held where a node set is held entirely."""
    fixed = np.zeros((len(mesh.points), 3), bool)
    fixed[mesh.node_sets[node_set]] = True
    return fixed


def facing(left: Any, right: Any) -> tuple[Any, NDArray[np.bool_], Any]:
    """Two blocks in one mesh, as a. and b., which nodes are the right one's, and the air between them."""
    mesh = engine.combine(left, right, "a.", "b.")
    airway = engine.matched_airway(mesh.points, mesh.surfaces["a.x_max"], mesh.surfaces["b.x_min"], (1, 0, 0))
    return mesh, np.arange(len(mesh.points)) >= len(left.points), airway


def mass_columns(simulation: engine.Simulation) -> NDArray[np.float64]:
    """Sums over the columns of the mass matrix (3 n,): what each velocity adds to the momentum along it."""
    data, columns, _ = simulation.mass
    return np.asarray(np.bincount(columns, weights=data), float)


def block(size: tuple[float, float, float], divisions: tuple[int, int, int], order: int) -> Any:
    """A block from the origin, of linear (1) or quadratic (2) tetrahedra."""
    mesh = engine.block_mesh(corner=(0, 0, 0), size=size, divisions=divisions)
    return engine.to_quadratic(mesh) if order == 2 else mesh


def free_block(
    elasticity: Any,
    size: tuple[float, float, float],
    divisions: tuple[int, int, int],
    order: int,
    *,
    density: float = 1040.0,
    viscosity: float = 0.0,
) -> Body:
    """A block without supports."""
    mesh = block(size, divisions, order)
    return Body(mesh, engine.Material(elasticity, density, viscosity), np.zeros((len(mesh.points), 3), bool))
