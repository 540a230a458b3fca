"""A block of isotropic tissue as plica, scikit-fem and NGSolve assemble it, on the same tetrahedra.

The block of the exact shear mode (R7): D x L x T, u along L alone, u = sin(a x) cos(b z) with a = pi / 2D
and b = pi / T: it is fixed on x = 0, and its other two components are held there and on both ends of L. Its
strain energy is mu / 2 (a^2 + b^2) D L T / 4, its kinetic energy at unit rate rho / 2 D L T / 4, and it
swings at omega^2 = mu / rho (a^2 + b^2).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import pi, sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from benchmarks.harness.case_record import Level
from plica import _engine as engine

__all__ = [
    "DENSITY",
    "MASS",
    "MATERIAL",
    "OMEGA",
    "STRAIN_ENERGY",
    "Array",
    "Assembled",
    "discrete_mode",
    "mesh_of",
    "ngsolve_assembly",
    "of_plica",
    "plica_assembly",
    "scikit_fem_assembly",
]

Array = NDArray[np.float64]

D, T, L = 10e-3, 7e-3, 16e-3  # m
MU, NU, DENSITY = 10e3, 0.3, 1040.0  # Pa, -, kg/m^3
LAME = 2 * MU * NU / (1 - 2 * NU)
MATERIAL = engine.Material(engine.Isotropic(2 * MU * (1 + NU), NU), DENSITY, 0.0)
ACROSS, ALONG = pi / (2 * D), pi / T  # 1/m
STRAIN_ENERGY = 0.5 * MU * (ACROSS**2 + ALONG**2) * D * L * T / 4  # J/m^2, of amplitude 1 m
MASS = DENSITY * D * L * T / 4  # kg
OMEGA = sqrt(MU / DENSITY * (ACROSS**2 + ALONG**2))  # rad/s
HELD = {0: ("x_min", "y_min", "y_max"), 1: ("x_min",), 2: ("x_min", "y_min", "y_max")}


@dataclass(frozen=True)
class Unknowns:
    """What is known of the unknowns in their order, which is that of who assembled."""

    mode: Array
    """The exact mode."""
    turn: Array
    """An infinitesimal turn about z."""
    free: NDArray[np.intp]
    """Numbers of those that are not held."""


@dataclass(frozen=True)
class Assembled:
    """Matrices on all unknowns, whoever made them and in whichever order."""

    stiffness: Any
    mass: Any
    unknowns: Callable[[], Unknowns]
    """Called after the time was taken."""

    def on_free(self) -> tuple[Any, Any]:
        """K and M without what is held, CSC."""
        free = self.unknowns().free
        stiffness, mass = (matrix.tocsr()[free][:, free].tocsc() for matrix in (self.stiffness, self.mass))
        return stiffness, mass


def mesh_of(level: Level, order: int | None = None) -> Any:
    """The mesh of a level: so many cells along each edge, six tetrahedra each."""
    cells = int(level["cells"])
    mesh = engine.block_mesh(corner=(0, 0, 0), size=(D, L, T), divisions=(cells, cells, cells))
    quadratic = level["elements"] == "quadratic" if order is None else order == 2
    return engine.to_quadratic(mesh) if quadratic else mesh


def plica_assembly(level: Level) -> Callable[[], Assembled]:
    """By `plica._engine.Assembly`."""
    mesh = mesh_of(level)
    return lambda: of_plica(mesh)


def of_plica(mesh: Any) -> Assembled:
    """The matrices of a mesh."""
    assembly = engine.Assembly(mesh, [MATERIAL], ["tissue"], np.zeros(len(mesh.cells), np.int32))
    size = 3 * len(mesh.points)
    stiffness, mass = (
        csr_array(matrix, shape=(size, size)) for matrix in (assembly.stiffness(), assembly.mass())
    )
    places = np.repeat(np.asarray(mesh.points), 3, axis=0)
    axes = np.tile(np.arange(3), len(mesh.points))
    return Assembled(stiffness, mass, lambda: _of_values(places, axes))


def scikit_fem_assembly(level: Level) -> Callable[[], Assembled]:
    """By scikit-fem's own elasticity form."""
    import skfem
    from skfem.helpers import dot
    from skfem.models.elasticity import linear_elasticity

    tets = mesh_of(level, order=1)
    mesh = skfem.MeshTet(np.asarray(tets.points).T.copy(), np.asarray(tets.cells, np.int64).T.copy())
    element = skfem.ElementTetP2() if level["elements"] == "quadratic" else skfem.ElementTetP1()

    def run() -> Assembled:
        basis = skfem.Basis(mesh, skfem.ElementVector(element))
        stiffness = linear_elasticity(LAME, MU).assemble(basis)
        mass = skfem.BilinearForm(lambda u, v, w: DENSITY * dot(u, v)).assemble(basis)
        return Assembled(stiffness, mass, lambda: _of_values(basis.doflocs.T, _axes(basis)))

    return run


def _axes(basis: Any) -> NDArray[np.int_]:
    """Of each unknown of scikit-fem, values of one component at corners and at the middles of edges."""
    axes = np.empty(basis.N, int)
    for numbers in (basis.nodal_dofs, basis.edge_dofs):
        for axis, of_axis in enumerate(numbers):
            axes[of_axis] = axis
    return axes


def ngsolve_assembly(level: Level) -> Callable[[], Assembled]:
    """By NGSolve's symbolic forms, with as many threads as the engine has."""
    import ngsolve as ng

    ng.SetNumThreads(engine.threads())
    mesh = _ngsolve_mesh(level)
    order = 2 if level["elements"] == "quadratic" else 1
    held = {f"dirichlet{axis}": "|".join(HELD[k]) for k, axis in enumerate("xyz")}

    def run() -> Assembled:
        with ng.TaskManager():
            space = ng.VectorH1(mesh, order=order, **held)
            u, v = space.TnT()
            strain, tested = ng.Sym(ng.Grad(u)), ng.Sym(ng.Grad(v))
            stress = 2 * MU * strain + LAME * ng.Trace(strain) * ng.Id(3)
            stiffness = ng.BilinearForm(ng.InnerProduct(stress, tested) * ng.dx).Assemble()
            mass = ng.BilinearForm(DENSITY * ng.InnerProduct(u, v) * ng.dx).Assemble()
        size = space.ndof
        K, M = (
            csr_array(tuple(map(np.array, form.mat.CSR())), shape=(size, size)) for form in (stiffness, mass)
        )

        def unknowns() -> Unknowns:
            shape = ng.sin(ACROSS * ng.x) * ng.cos(ALONG * ng.z)
            mode, turn = (_interpolated(mesh, order, field) for field in ((0, shape, 0), (-ng.y, ng.x, 0)))
            return Unknowns(mode, turn, np.flatnonzero(np.array(list(space.FreeDofs()), bool)))

        return Assembled(K, M, unknowns)

    return run


def _interpolated(mesh: Any, order: int, field: tuple[Any, Any, Any]) -> Array:
    """Coefficients in NGSolve's space, in which nothing is held: what is held would not be set."""
    import ngsolve as ng

    function = ng.GridFunction(ng.VectorH1(mesh, order=order))
    function.Interpolate(ng.CoefficientFunction(field))
    return np.array(function.vec.FV().NumPy())


def _ngsolve_mesh(level: Level) -> Any:
    import ngsolve as ng
    from netgen import meshing

    tets = mesh_of(level, order=1)
    mesh = meshing.Mesh(dim=3)
    numbers = [mesh.Add(meshing.MeshPoint(meshing.Pnt(*map(float, point)))) for point in tets.points]
    for k, (name, faces) in enumerate(tets.surfaces.items(), start=1):
        side = mesh.Add(meshing.FaceDescriptor(surfnr=k, domin=1, bc=k))
        mesh.SetBCName(k - 1, name)
        for face in np.asarray(faces):
            mesh.Add(meshing.Element2D(side, [numbers[node] for node in face]))
    for cell in np.asarray(tets.cells):
        mesh.Add(meshing.Element3D(1, [numbers[node] for node in cell]))
    return ng.Mesh(mesh)


def _of_values(places: Array, axes: NDArray[np.int_]) -> Unknowns:
    """Of unknowns that are values along an axis at a place."""
    x, y, z = places.T
    mode = np.where(axes == 1, np.sin(ACROSS * x) * np.cos(ALONG * z), 0.0)
    turn = np.where(axes == 0, -y, np.where(axes == 1, x, 0.0))
    at = {"x_min": x < 1e-6 * D, "y_min": y < 1e-6 * L, "y_max": y > (1 - 1e-6) * L}
    held = np.zeros(len(x), bool)
    for axis, names in HELD.items():
        for name in names:
            held |= (axes == axis) & at[name]
    return Unknowns(mode, turn, np.flatnonzero(~held))


def discrete_mode(made: Assembled) -> tuple[Array, float]:
    """The mode of the matrices next to the exact one, on the free unknowns; rad/s.

    By shift and invert about the exact frequency (ARPACK, SuperLU).
    """
    from scipy.sparse.linalg import eigsh

    stiffness, mass = made.on_free()
    unknowns = made.unknowns()
    exact = unknowns.mode[unknowns.free]
    values, modes = eigsh(stiffness, k=4, M=mass, sigma=OMEGA**2, v0=exact)
    best = int(np.argmax(np.abs(modes.T @ (mass @ exact))))
    return np.asarray(modes[:, best]), sqrt(float(values[best]))
