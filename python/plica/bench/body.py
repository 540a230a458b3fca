"""A body of one tissue in the engine: what benchmarks without a scene file have in common."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plica import _engine as engine

__all__ = ["SCHEMES", "Body", "mass_columns"]

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


def mass_columns(simulation: engine.Simulation) -> NDArray[np.float64]:
    """Sums over the columns of the mass matrix (3 n,): what each velocity adds to the momentum along it."""
    data, columns, _ = simulation.mass
    return np.asarray(np.bincount(columns, weights=data), float)
