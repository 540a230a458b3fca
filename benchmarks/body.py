"""A body of one tissue in the engine: what the benchmarks without a scene file have in common."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from scipy.sparse import csc_array, csr_array

from plica import _engine as engine

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
    fixed: np.ndarray  # (n, 3) bool

    def simulation(self, **parts: Any) -> Any:
        """A simulation of the body; `parts` as engine.Simulation takes them: scheme, step, contact, ..."""
        layer_of_cell = np.zeros(len(self.mesh.cells), int)
        return engine.Simulation(self.mesh, [self.material], ["tissue"], layer_of_cell, self.fixed, **parts)

    @cached_property
    def free(self) -> np.ndarray:
        """Numbers of the free unknowns."""
        return np.flatnonzero(~self.fixed.ravel())

    def on_free(self, matrix: Any) -> csc_array:
        """A matrix of the engine on the free unknowns."""
        n = self.fixed.size
        return csr_array(matrix, shape=(n, n))[self.free][:, self.free].tocsc()

    def field(self, values: np.ndarray) -> np.ndarray:
        """Nodal values (n, 3) from those of the free unknowns; zero where held."""
        full = np.zeros(self.fixed.size)
        full[self.free] = values
        return full.reshape(-1, 3)


def held(mesh: Any, node_set: str) -> np.ndarray:
    """Components (n, 3) that are held where a node set is held entirely."""
    fixed = np.zeros((len(mesh.points), 3), bool)
    fixed[mesh.node_sets[node_set]] = True
    return fixed


def advanced(simulation: Any, steps: int) -> Any:
    """The waveforms of that many steps; raises what ends the run before."""
    result = simulation.advance(steps)
    if len(result["time"]) < steps:
        simulation.advance(1)
    return result
