"""The equation of the section pressures in small oscillations, of all displacements, for tests."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.linalg import splu

import plica
from plica.runs.build import build_simulation, equilibrium_branch, fixed_components
from plica.scene.mesh.build import build_mesh

__all__ = ["SectionPressures"]


class SectionPressures:
    """det(1 - dP/da G(s)) with the compliance G of the areas at a complex frequency, of all displacements."""

    def __init__(self, scene: plica.Scene, pressure: float) -> None:
        mesh = build_mesh(scene.mesh)
        simulation = build_simulation(scene, mesh)
        self.free = ~fixed_components(scene, mesh).ravel()
        self.M, self.C, self.K = (
            csr_array(m)[self.free][:, self.free]
            for m in (simulation.mass, simulation.viscosity, simulation.stiffness)
        )
        branch = equilibrium_branch(scene, mesh)
        rest = branch.at(pressure)
        self.slope = np.asarray(rest.tangent.pressure_by_area)
        self.tangent = rest.tangent
        self.B = branch.patterns.toarray()[self.free].astype(complex)
        spacing = np.asarray(branch.flow.width_spacing())
        of_x = (
            (spacing[:, None] * branch.width_map.toarray())
            .reshape(len(self.slope), -1, len(mesh.points))
            .sum(1)
        )
        A = np.zeros((len(self.slope), self.free.size))
        A[:, 0::3] = of_x
        self.A = A[:, self.free]

    def determinant(self, s: complex, impedances: Any = None) -> complex:
        """With impedances (below, above) as functions of s: of the pressures at both ends, too."""
        matrix = (s * s * self.M + s * self.C + self.K).tocsc()
        moved = splu(matrix).solve(self.B)
        areas = self.A @ moved
        count = len(self.slope)
        drop = np.concatenate((np.zeros(count), (1.0, -1.0)))
        of_sections = self.slope @ areas + np.outer(self.tangent.pressure_by_drop, drop)
        of_sections[:, -1] += 1
        if impedances is None:
            return complex(np.linalg.det(np.eye(count) - of_sections[:, :count]))
        flow = self.tangent.flow_by_area @ areas + self.tangent.flow_by_drop * drop
        displaced = s * (self.B.T @ moved)
        shares = np.asarray(self.tangent.from_below)
        below = -impedances[0](s) * (flow + displaced[-2] + shares @ displaced[:count])
        above = impedances[1](s) * (flow - displaced[-1] - (1 - shares) @ displaced[:count])
        return complex(np.linalg.det(np.eye(count + 2) - np.vstack((of_sections, below, above))))

    def root(self, guess: complex, impedances: Any = None) -> complex:
        """By the secant method."""
        a, b = guess * (1 + 1e-4), guess
        f_a, f_b = self.determinant(a, impedances), self.determinant(b, impedances)
        for _ in range(20):
            a, b, f_a = b, b - f_b * (b - a) / (f_b - f_a), f_b
            if abs(b - a) < 1e-10 * abs(b):
                return b
            f_b = self.determinant(b, impedances)
        raise AssertionError("no root")
