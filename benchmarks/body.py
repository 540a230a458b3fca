"""A body of one tissue with its matrices: what the benchmarks without a scene file have in common."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np
from scipy.sparse import csc_array, csr_array

from plica.bench import body
from plica.bench.body import SCHEMES

__all__ = ["SCHEMES", "Body", "held"]


class Body(body.Body):
    """A mesh of one material with held components."""

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
