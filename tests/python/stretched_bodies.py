"""Small bodies and a voice at finite strain, and their law written a second time."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.sparse import csr_array

import plica
from conftest import THESIS_TISSUE, TINY_LARYNX
from plica import _engine

DENSITY = 1040.0
FIBRED = {"E": 5e3, "nu": 0.4, "E_fibre": 40e3, "nu_fibre": 0.3, "mu_fibre": 10e3}
TRAPEZOIDAL = _engine.Newmark()
STIFFENS = {
    f"tissue.{layer}.{name}": value
    for layer in THESIS_TISSUE
    for name, value in (("stiffening", 2.0), ("matrix_stiffening", 10.0))
}


def block(divisions: tuple[int, int, int], size: tuple[float, float, float], order: int = 1) -> Any:
    mesh = _engine.block_mesh(corner=(0, 0, 0), size=size, divisions=divisions)
    return mesh if order == 1 else _engine.to_quadratic(mesh)


def simulation(mesh: Any, material: Any, fixed: Any, **parts: Any) -> Any:
    given = {
        "scheme": TRAPEZOIDAL,
        "strain": _engine.FiniteStrain(tolerance=1e-10),
        "solver_tolerance": 1e-11,
    }
    layers = np.zeros(len(mesh.cells), dtype=np.int32)
    return _engine.Simulation(mesh, [material], ["bar"], layers, fixed, **given | parts)


class Law:
    """The law as docs/theory/posture.md writes it; its stress by the derivative of W, term by term."""

    def __init__(self, stiffening: float = 0.0, matrix: float = 0.0) -> None:
        young, nu, along, nu_along, mu_along = FIBRED.values()
        k = along * (1 - nu) - 2 * nu_along**2 * young
        self.lame = (nu_along**2 * young + nu * along) * young / ((1 + nu) * k)
        s12, s22, self.mu = young * along * nu_along / k, along**2 * (1 - nu) / k, young / (2 * (1 + nu))
        self.beta, self.e = (s12 - self.lame) / 2, s22 - 2 * s12 + self.lame - 2 * self.mu
        self.shear, self.along, self.k, self.matrix = mu_along - self.mu, along, stiffening, matrix

    def stress(self, F: np.ndarray) -> np.ndarray:
        """First Piola-Kirchhoff, fibres along y; F (..., 3, 3)."""
        one, a = np.eye(3), np.array([0.0, 1.0, 0.0])
        C = np.swapaxes(F, -1, -2) @ F
        E, inverse = (C - one) / 2, np.linalg.inv(C)
        pulled = E @ a
        q, volume = pulled[..., 1], np.log(np.linalg.det(F))
        more = np.where(q > 0, self.along * q * np.expm1(4 * self.k * q**2), 0.0)
        axial = 2 * self.beta * volume + self.e * q + more - 4 * self.shear * q
        outer = pulled[..., :, None] * a + a[:, None] * pulled[..., None, :]
        shape = np.trace(E, axis1=-2, axis2=-1) - volume
        mu = self.mu * (1 + self.matrix * shape)[..., None, None]
        S = mu * (one - inverse) + (self.lame * volume + 2 * self.beta * q)[..., None, None] * inverse
        return F @ (S + axial[..., None, None] * np.outer(a, a) + 2 * self.shear * outer)


def tissue_force(mesh: Any, law: Law) -> tuple[Callable[[np.ndarray], np.ndarray], np.ndarray]:
    """The force (n, 3) N of linear tetrahedra at displacements (n, 3) m, and their volumes (m) m^3."""
    x, cells = np.asarray(mesh.points), np.asarray(mesh.cells)
    edges = np.swapaxes(x[cells[:, 1:]] - x[cells[:, :1]], 1, 2)
    inverse, volume = np.linalg.inv(edges), np.linalg.det(edges) / 6
    gradients = np.concatenate([-inverse.sum(axis=1, keepdims=True), inverse], axis=1)  # (m, 4, 3)

    def force(u: np.ndarray) -> np.ndarray:
        F = np.swapaxes(u[cells], 1, 2) @ gradients + np.eye(3)
        own = volume[:, None, None] * gradients @ np.swapaxes(law.stress(F), 1, 2)
        found = np.zeros_like(u)
        np.add.at(found, cells, own)
        return found

    return force, volume


def angular_momentum(run: Any, mesh: Any) -> np.ndarray:
    values, columns, starts = run.mass
    size = 3 * len(mesh.points)
    momentum = (csr_array((values, columns, starts), shape=(size, size)) @ np.ravel(run.velocity)).reshape(
        -1, 3
    )
    return np.cross(np.asarray(mesh.points) + run.displacement, momentum).sum(axis=0)


def voice(**changes: Any) -> plica.Scene:
    scene = plica.Scene(
        plica.Larynx(larynx="thesis_coarse", options=plica.LarynxOptions(**TINY_LARYNX), order=2),
        {layer: plica.Tissue(**fields) for layer, fields in THESIS_TISSUE.items()},
        time=plica.Stepping(step="50 us", duration="5 ms"),
        airflow=plica.Airflow(subglottal_pressure="0.6 kPa", area=plica.Cut(sections=40)),
        contact=plica.Multipliers(),
        initial=plica.Initial(opening_velocity=-1.2),
        strain="finite",
    )
    return scene.replace(changes)
