"""Matrices of an elastic block, and what follows from them: strain energy, natural frequency.

The block of the exact shear mode (R7): D x L x T, u along L alone, u = sin(a x) cos(b z) with a = pi / 2D
and b = pi / T: it is fixed on x = 0, and its other two components are held there and on both ends of L. Its
strain energy is mu / 2 (a^2 + b^2) D L T / 4, its kinetic energy at unit rate rho / 2 D L T / 4, and it
swings at omega^2 = mu / rho (a^2 + b^2).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import pi, sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array, csr_array

from plica import _engine as engine
from plica.bench.case import Case, Claim, Method
from plica.bench.record import Level, Row

__all__ = ["CASES", "Matrices", "block", "plica_matrices", "scikit_fem_matrices"]

Array = NDArray[np.float64]

D, T, L = 10e-3, 7e-3, 16e-3  # m
MU, NU, DENSITY = 10e3, 0.3, 1040.0  # Pa, -, kg/m^3
ACROSS, ALONG = pi / (2 * D), pi / T  # 1/m
STRAIN_ENERGY = 0.5 * MU * (ACROSS**2 + ALONG**2) * D * L * T / 4  # J/m^2, of amplitude 1 m
MASS = DENSITY * D * L * T / 4  # kg
OMEGA = sqrt(MU / DENSITY * (ACROSS**2 + ALONG**2))  # rad/s


class Matrices:
    """K and M on all unknowns, whoever made them, and where and along which axis each unknown is."""

    def __init__(self, stiffness: Any, mass: Any, places: Array, axes: NDArray[np.int_]) -> None:
        self.stiffness, self.mass = stiffness, mass
        self.places, self.axes = places, axes

    def shape(self) -> Array:
        """The mode on the unknowns."""
        along = np.sin(ACROSS * self.places[:, 0]) * np.cos(ALONG * self.places[:, 2])
        return np.where(self.axes == 1, along, 0.0)

    def free(self) -> NDArray[np.intp]:
        """Numbers of the unknowns that are not held."""
        x, y, _ = self.places.T
        held = x < 1e-6 * D
        held |= (self.axes != 1) & ((y < 1e-6 * L) | (y > (1 - 1e-6) * L))
        return np.flatnonzero(~held)


def block(level: Level) -> Any:
    """The mesh of a level: so many cells along each edge, six tetrahedra each."""
    cells = int(level["cells"])
    mesh = engine.block_mesh(corner=(0, 0, 0), size=(D, L, T), divisions=(cells, cells, cells))
    return engine.to_quadratic(mesh) if level["elements"] == "quadratic" else mesh


def plica_matrices(mesh: Any) -> Matrices:
    """From `plica._engine.Assembly`."""
    material = engine.Material(engine.Isotropic(2 * MU * (1 + NU), NU), DENSITY, 0.0)
    assembly = engine.Assembly(mesh, [material], ["tissue"], np.zeros(len(mesh.cells), np.int32))
    size = 3 * len(mesh.points)
    stiffness, mass = (
        csr_array(made, shape=(size, size)) for made in (assembly.stiffness(), assembly.mass())
    )
    places = np.repeat(np.asarray(mesh.points), 3, axis=0)
    return Matrices(stiffness, mass, places, np.tile(np.arange(3), len(mesh.points)))


def scikit_fem_mesh(level: Level) -> Any:
    """The same tetrahedra."""
    import skfem

    mesh = block({**level, "elements": "linear"})
    return skfem.MeshTet(np.asarray(mesh.points).T.copy(), np.asarray(mesh.cells, np.int64).T.copy())


def scikit_fem_matrices(mesh: Any, quadratic: bool) -> Matrices:
    """From scikit-fem's own elasticity form."""
    import skfem
    from skfem.helpers import dot
    from skfem.models.elasticity import linear_elasticity

    element = skfem.ElementTetP2() if quadratic else skfem.ElementTetP1()
    basis = skfem.Basis(mesh, skfem.ElementVector(element))

    stiffness = linear_elasticity(2 * MU * NU / (1 - 2 * NU), MU).assemble(basis)
    mass = skfem.BilinearForm(lambda u, v, w: DENSITY * dot(u, v)).assemble(basis)
    axes = np.empty(basis.N, int)
    for axis in range(3):
        axes[basis.get_dofs(elements=slice(None)).all(f"u^{axis + 1}")] = axis
    return Matrices(stiffness, mass, basis.doflocs.T, axes)


def netgen_mesh(level: Level) -> Any:
    """The same tetrahedra for NGSolve."""
    import ngsolve
    from netgen import meshing

    made = block({**level, "elements": "linear"})
    points, cells = np.asarray(made.points), np.asarray(made.cells)
    mesh = meshing.Mesh(dim=3)
    numbers = [mesh.Add(meshing.MeshPoint(meshing.Pnt(*map(float, point)))) for point in points]
    side = mesh.Add(meshing.FaceDescriptor(surfnr=1, domin=1, bc=1))
    faces, _ = engine.boundary(cells)
    for face in np.asarray(faces):
        mesh.Add(meshing.Element2D(side, [numbers[k] for k in face]))
    for cell in cells:
        mesh.Add(meshing.Element3D(1, [numbers[k] for k in cell[[0, 2, 1, 3]]]))
    return ngsolve.Mesh(mesh)


def _plica(level: Level) -> Callable[[], Matrices]:
    mesh = block(level)
    return lambda: plica_matrices(mesh)


def _scikit_fem(level: Level) -> Callable[[], Matrices]:
    mesh = scikit_fem_mesh(level)
    return lambda: scikit_fem_matrices(mesh, level["elements"] == "quadratic")


def energies(level: Level, made: Matrices, truth: None) -> dict[str, float]:
    """Of the mode's interpolant, over those of the mode; and of a rigid turn."""
    u = made.shape()
    strain = 0.5 * float(u @ (made.stiffness @ u))
    kinetic = 0.5 * float(u @ (made.mass @ u))
    x, y, _ = made.places.T
    turn = np.where(made.axes == 0, -y, np.where(made.axes == 1, x, 0.0))
    rigid = abs(float(turn @ (made.stiffness @ turn)))
    size = float(np.abs(turn) @ (abs(made.stiffness) @ np.abs(turn)))
    return {
        "strain energy": abs(strain / STRAIN_ENERGY - 1),
        "kinetic energy": abs(2 * kinetic / MASS - 1),
        "rigid turn": rigid / size,
    }


def frequency(made: Matrices) -> float:
    """rad/s, of the mode of this shape, by shift and invert about its exact square."""
    from scipy.sparse.linalg import eigsh

    free = made.free()
    stiffness, mass = (csc_array(m)[free][:, free].tocsc() for m in (made.stiffness, made.mass))
    exact = made.shape()[free]
    values, modes = eigsh(stiffness, k=4, M=mass, sigma=OMEGA**2, v0=exact)
    overlap = np.abs(modes.T @ (mass @ exact))
    return sqrt(float(values[int(np.argmax(overlap))]))


def _frequency_of(start: Callable[[Level], Callable[[], Matrices]]) -> Callable[[Level], Callable[[], float]]:
    def prepare(level: Level) -> Callable[[], float]:
        made = start(level)
        return lambda: frequency(made())

    return prepare


def _methods(
    wrap: Callable[[Callable[[Level], Callable[[], Matrices]]], Callable[[Level], Callable[[], Any]]],
) -> tuple[Method, ...]:
    return (
        Method("plica", wrap(_plica)),
        Method("scikit-fem", wrap(_scikit_fem), "skfem", "scikit-fem"),
    )


def _median(rows: Sequence[Row], method: str, threads: int, **level: object) -> float | None:
    for row in rows:
        if row.method == method and row.threads == threads and level.items() <= row.level.items():
            return row.median
    return None


def ten_times(rows: Sequence[Row]) -> bool | None:
    """At 55,566 linear tetrahedra, on one thread."""
    ours, theirs = (
        _median(rows, method, 1, cells=21, elements="linear") for method in ("plica", "scikit-fem")
    )
    return None if ours is None or theirs is None else theirs >= 10 * ours


def falls_with_order(error: str, at_least: float) -> Callable[[Sequence[Row]], bool | None]:
    """Between the two finest meshes of each order the error falls by this share of the order, 2 or 2 p."""

    def holds(rows: Sequence[Row]) -> bool | None:
        orders = []
        for elements, order in (("linear", 2), ("quadratic", 4)):
            found = {
                int(row.level["cells"]): row.errors[error]
                for row in rows
                if row.method == "plica" and row.level["elements"] == elements and not row.failure
            }
            if len(found) < 2:
                return None
            coarse, fine = sorted(found)[-2:]
            first, last = found[coarse], found[fine]
            if first is None or last is None or last <= 0:
                return False
            orders.append(np.log(first / last) / np.log(fine / coarse) / order)
        return bool(min(orders) >= at_least)

    return holds


def _levels(linear: Sequence[int], quadratic: Sequence[int]) -> tuple[Level, ...]:
    pairs = [*((n, "linear") for n in linear), *((n, "quadratic") for n in quadratic)]
    return tuple({"elements": elements, "cells": cells} for cells, elements in pairs)


CASES = (
    Case(
        name="assembly",
        does="Stiffness and mass matrix of a block of isotropic tissue, from a mesh in memory to CSR.",
        reference="energies of a shear mode in closed form (R7)",
        errors={
            "strain energy": "of the mode's interpolant, relative",
            "kinetic energy": "likewise",
            "rigid turn": "energy of an infinitesimal turn, over its terms' size",
        },
        levels={
            "small": _levels((2, 4), (1, 2)),
            "full": _levels((7, 14, 21), (4, 8)),
        },
        methods=_methods(lambda start: start),
        truth=lambda level: None,
        judge=energies,
        claims=(
            Claim(
                "the strain energy's error of plica falls with order 2 and 4",
                falls_with_order("strain energy", 0.9),
            ),
            Claim(
                "at 55,566 linear tetrahedra plica is ten times as fast as scikit-fem", ten_times, timed=True
            ),
        ),
    ),
    Case(
        name="frequency",
        does="The frequency of a shear mode: assembly, then shift and invert about it (ARPACK, SuperLU).",
        reference="closed form (R7)",
        errors={"frequency": "relative"},
        levels={
            "small": _levels((2, 4), (2, 3)),
            "full": _levels((4, 8, 12), (2, 4, 6)),
        },
        methods=_methods(_frequency_of),
        truth=lambda level: None,
        judge=lambda level, found, truth: {"frequency": abs(found / OMEGA - 1)},
        claims=(
            Claim(
                "the frequency's error of plica falls with order 2 and 4", falls_with_order("frequency", 0.9)
            ),
        ),
    ),
)
