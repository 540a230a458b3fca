"""The basis of a reduced scene: principal components of a motion, modes of vibration, static responses."""

from __future__ import annotations

from collections.abc import Callable
from numbers import Integral
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, eye_array

from plica import _engine
from plica.errors import InvalidInput, SolveFailed
from plica.scene.symmetry import mirrored_mean, nearest_image, symmetry_planes

__all__ = ["contact_nodes", "reduction_basis"]

Floats = NDArray[np.float64]

COMPONENTS, MODES, CONTACT_VECTORS = 150, 200, 100  # defaults; the mesh may have fewer
PRESSURE_VECTORS = 40  # from the responses to the pressures of the airflow's sections


def reduction_basis(
    full: _engine.Simulation,
    mesh: _engine.TetMesh,
    fixed: NDArray[np.bool_],
    *,
    motion: NDArray[np.floating[Any]] | None = None,
    components: int | None = None,
    modes: int | None = 0,
    contact_vectors: int | None = 0,
    surface: str | None = None,
    sides: tuple[NDArray[np.int32], NDArray[np.int32]] | None = None,
    reach: float = np.inf,
    symmetry: str | None = None,
    on_start: Callable[[], None] | None = None,
) -> Floats:
    """A basis (3 n, vectors) of displacements, zero where they are fixed.

    Parameters
    ----------
    full : Simulation
        The simulation without reduction, which provides the matrices.
    mesh : TetMesh
    fixed : (n, 3) bool
        Fixed components.
    motion : (frames, n, 3) m, optional
        Displacements of a full run.
    components : int, optional
        Number of its principal components, those with the most elastic energy. None: 150, or as many as it
        has frames.
    modes : int or None
        Number of undamped vibration modes of lowest frequency, K phi = omega^2 M phi. None: 200, or as many
        as there are; with a motion 0.
    contact_vectors : int or None
        Number of static responses to forces along the normals of the contact's nodes: the combinations with
        the most elastic energy. None: 100, or as many as there are; with a motion or without sides 0.
    surface : str, optional
        Surface of the airflow: adds, from the static responses to the pressure of each section and to that
        below, the 40 combinations with the most elastic energy.
    sides : pair of (f, 3) int, optional
        Triangles of the contact surfaces.
    reach : float
        [m] Largest distance at rest of nodes with contact vectors from the other surface.
    symmetry : str, optional
        Of the vectors, as a scene's, which must be symmetric: modes and contact vectors are those of its
        symmetric displacements, of the motion the symmetric part is used.
    on_start : callable, optional
        Called once the requested numbers are known to be available.

    Raises
    ------
    InvalidInput
        If more vectors are requested than there are, or a rigid motion is possible.
    """
    for name, number in (("modes", modes), ("contact_vectors", contact_vectors)):
        if number is not None and (not isinstance(number, Integral) or number < 0):
            raise InvalidInput(f"reduce: {name} = {number}; must be a whole number >= 0.")
    free, points = ~fixed.ravel(), np.asarray(mesh.points)
    planes = symmetry_planes(symmetry)
    symmetric = _Symmetric(points, planes, free)
    count = symmetric.count
    if motion is not None:
        modes, contact_vectors = modes or 0, contact_vectors or 0
    forces = None
    if sides is not None and contact_vectors != 0:
        forces = symmetric.forces(_contact_forces(points, sides, reach, free))
    if contact_vectors is None:
        contact_vectors = 0 if forces is None else min(CONTACT_VECTORS, forces.shape[1], count)
    if modes is None:
        modes = min(MODES, count - contact_vectors)
    if contact_vectors and (forces is None or contact_vectors > forces.shape[1]):
        raise InvalidInput(
            f"reduce: contact_vectors = {contact_vectors}; must be <= "
            f"{0 if forces is None else forces.shape[1]}, the free nodes of the contact within its reach. "
            "The default is at most that."
        )
    if modes + contact_vectors > count:
        raise InvalidInput(
            f"reduce: modes = {modes} with {contact_vectors} contact vectors; must be <= "
            f"{count - contact_vectors}, the scene's unknowns without these."
        )
    K, M = (_matrix(values, free) for values in (full.stiffness, full.mass))
    try:
        solver = _engine.StaticSolver(full)
    except SolveFailed:
        raise InvalidInput(
            "reduce: a rigid motion is possible; must have supports that prevent it, as static responses "
            "need them."
        ) from None

    def solve(forces: Floats) -> Floats:
        everywhere = np.zeros((free.size, forces.shape[1]), order="F")
        everywhere[free] = forces
        found: Floats = solver.solve(everywhere)[free]
        return found

    columns = []
    if motion is not None:
        fields = mirrored_mean(motion, points, planes).reshape(len(motion), -1)[:, free].T
        count = min(COMPONENTS, len(motion)) if components is None else components
        columns.append(_principal_components(K, fields, count))
    if on_start is not None:
        on_start()
    columns.append(symmetric.lowest_modes(K, M, solve, modes))
    if surface is not None:
        loads = _engine.pressure_patterns(mesh, mesh.surfaces[surface], full.section_height)
        loads = np.ascontiguousarray(np.asarray(loads)[free])
        columns.append(_most_energetic(loads, solve(loads), min(PRESSURE_VECTORS, loads.shape[1])))
    if contact_vectors and forces is not None:
        columns.append(_most_energetic(forces, solve(forces), contact_vectors))
    basis = np.zeros((free.size, sum(column.shape[1] for column in columns)))
    basis[free] = np.hstack(columns)
    # Removes round-off outside the symmetry.
    fields = mirrored_mean(basis.T.reshape(-1, *fixed.shape), points, planes)
    return fields.reshape(-1, free.size).T


class _Symmetric:
    """Symmetric displacements q of free nodes, u = S q; of no planes all, S = 1.

    S has a column for each component of one node of those that are mirrored to each other: the mean of its
    unit displacement's images, orthogonal to the others.
    """

    def __init__(self, points: Floats, planes: int, free: NDArray[np.bool_]) -> None:
        self.spread: Any = None
        self.count = int(free.sum())
        if planes == 0:
            return
        nodes = np.arange(len(points))
        first, spread = nodes.copy(), eye_array(free.size, format="csr")
        for axis in range(planes):
            image = nearest_image(points, axis)
            signs = np.where(np.arange(3) == axis, -1.0, 1.0)
            rows, columns = (3 * of[:, None] + np.arange(3) for of in (nodes, image))
            values = np.broadcast_to(signs, rows.shape)
            mirror = csr_array((values.ravel(), (rows.ravel(), columns.ravel())), shape=2 * (free.size,))
            spread = 0.5 * (spread + mirror @ spread)
            first = np.minimum(first, first[image])
        taken = np.repeat(first == nodes, 3) & (spread.diagonal() > 0) & free
        self.spread = spread.tocsc()[:, taken][free]
        self.squares = np.asarray(self.spread.multiply(self.spread).sum(axis=0)).ravel()
        self.count = int(taken.sum())

    def forces(self, forces: Floats) -> Floats:
        """The symmetric part of forces (unknowns, any), those alike left out."""
        if self.spread is None:
            return forces
        found: Floats = self.spread @ ((self.spread.T @ forces) / self.squares[:, None])
        size = np.linalg.norm(found, axis=0)
        keys = np.round(found[:, size > 0] / size[size > 0], 9)
        keys *= np.sign(keys[np.abs(keys).argmax(axis=0), np.arange(keys.shape[1])])
        return np.ascontiguousarray(
            found[:, size > 0][:, np.sort(np.unique(keys, axis=1, return_index=True)[1])]
        )

    def lowest_modes(self, K: Any, M: Any, solve: Any, count: int) -> Floats:
        if self.spread is None:
            return _lowest_modes(K, M, solve, count)
        S = self.spread

        def solve_part(forces: Floats) -> Floats:
            found: Floats = (S.T @ solve(S @ (forces / self.squares[:, None]))) / self.squares[:, None]
            return found

        shapes: Floats = S @ _lowest_modes((S.T @ K @ S).tocsc(), (S.T @ M @ S).tocsc(), solve_part, count)
        return shapes


def contact_nodes(
    points: Floats, sides: tuple[NDArray[np.int32], NDArray[np.int32]], reach: float
) -> tuple[NDArray[np.intp], Floats]:
    """Nodes of two surfaces within `reach` (m) of the other surface at rest, and their normals."""
    from scipy.spatial import cKDTree

    nodes, normals = [], []
    for own, other in (sides, sides[::-1]):
        normal = np.zeros_like(points)
        a, b, c = (points[own[:, k]] for k in range(3))
        for k in range(3):
            np.add.at(normal, own[:, k], np.cross(b - a, c - a))
        found = np.unique(own)
        near = cKDTree(points[np.unique(other)]).query(points[found])[0] <= reach
        found = found[near]
        nodes.append(found)
        normals.append(normal[found] / np.linalg.norm(normal[found], axis=1, keepdims=True))
    return np.concatenate(nodes), np.concatenate(normals)


def _matrix(values: Any, free: NDArray[np.bool_]) -> Any:
    return csr_array(values, shape=(free.size, free.size))[free][:, free].tocsc()


def _lowest_modes(K: Any, M: Any, solve: Any, count: int) -> Floats:
    size = K.shape[0]
    if count == 0:
        return np.zeros((size, 0))
    if count >= size - 1:
        return np.eye(size)
    from scipy.sparse.linalg import LinearOperator, eigsh

    inverse = LinearOperator((size, size), matvec=lambda f: solve(f.reshape(-1, 1))[:, 0], dtype=float)
    start = np.random.default_rng(0).standard_normal(size)
    squares, found = eigsh(K, count, M, sigma=0.0, OPinv=inverse, v0=start, tol=1e-8)
    ascending: Floats = found[:, np.argsort(squares)]
    return ascending


def _principal_components(K: Any, motion: NDArray[np.floating[Any]], count: int) -> Floats:
    """(unknowns, count) principal components of displacements (unknowns, frames) with the most elastic
    energy."""
    if not 1 <= count <= motion.shape[1]:
        raise InvalidInput(
            f"reduce: components = {count}; must be in [1, {motion.shape[1]}], the stored frames of "
            "the run. Set a shorter output.every or an earlier output.start of it."
        )
    fields: Floats = motion.astype(float)
    _, directions = np.linalg.eigh(fields.T @ (K @ fields))
    strongest: Floats = fields @ directions[:, -count:]
    return strongest


def _contact_forces(
    points: Floats,
    sides: tuple[NDArray[np.int32], NDArray[np.int32]],
    reach: float,
    free: NDArray[np.bool_],
) -> Floats:
    """Unit forces (unknowns, any) along the normals of the contact's free nodes."""
    nodes, normals = contact_nodes(points, sides, reach)
    forces = np.zeros((free.size, len(nodes)))
    for k in range(3):
        forces[3 * nodes + k, np.arange(len(nodes))] = normals[:, k]
    forces = forces[free]
    return np.ascontiguousarray(forces[:, np.abs(forces).sum(axis=0) > 0])


def _most_energetic(forces: Floats, responses: Floats, count: int) -> Floats:
    """The combinations of static responses (unknowns, any) to forces with the most elastic energy."""
    _, directions = np.linalg.eigh(forces.T @ responses)
    strongest: Floats = responses @ directions[:, -count:]
    return strongest
