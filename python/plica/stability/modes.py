"""Modes of vibration of a scene's tissue, without air and contact."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from plica import _engine
from plica.errors import InvalidInput, SceneError
from plica.runs.build import build_simulation, fixed_components, whole_tissue
from plica.runs.nodal_matrices import NodalMatrices, ritz
from plica.runs.scene_mesh import scene_mesh
from plica.scene.scene import Scene
from plica.scene.symmetry import nearest_image
from plica.units import whole_number

__all__ = ["Eigenmodes", "basis_of", "eigenmodes"]

Floats = NDArray[np.float64]

_MOST = 2000
_PLANES = ("x", "y")  # planes of symmetry, by the coordinate that is 0 there
_EVEN = 0.99  # how like its mirror image, or unlike, a shape is that has a symmetry
_SAME_PLACE = 1e-6  # of the mesh's extent


@dataclass(frozen=True)
class Eigenmodes:
    """Undamped modes of vibration K phi = (2 pi f)^2 M phi, by rising frequency."""

    frequency: Floats
    """(k) Hz"""
    damping_ratio: Floats
    """(k) - phi^T C phi / (2 omega) of the tissue's viscosity, phi^T M phi = 1."""
    residual: Floats
    """(k) - ``|K phi - omega^2 M phi| / |K phi|`` at the unknowns that are free."""
    modal_mass: Floats
    """(k) kg, phi^T M phi of the shape whose largest displacement is 1."""
    left_right: tuple[str, ...]
    """(k) "even" where the shape is its mirror image in x = 0, "odd" where it is minus that, "mixed", or ""
    if the mesh has no such symmetry."""
    front_back: tuple[str, ...]
    """(k) The same for y = 0."""
    shape: Floats
    """(k, n, 3) - scaled so that the largest displacement of a node is 1."""


def eigenmodes(scene: Scene, count: int = 20, mesh: _engine.TetMesh | None = None) -> Eigenmodes:
    """The modes of vibration of lowest frequency.

    Parameters
    ----------
    scene : Scene
        Of which mesh, tissue, supports and ``time.mass`` count. With a symmetry modes are those of its
        symmetric displacements, otherwise all.
    count : int
    mesh : TetMesh, optional
        The scene's mesh, if it is already built.

    Raises
    ------
    InvalidInput
        If a rigid motion is possible, or the scene has no more unknowns than modes are asked for.
    """
    from plica.runs.basis import reduction_basis

    whole_number("eigenmodes", "count", count, 1, _MOST)
    mesh = scene_mesh(scene) if mesh is None else mesh
    fixed = fixed_components(scene, mesh)
    airless = whole_tissue(scene).replace(dict.fromkeys(("airflow", "trachea", "tract")))
    simulation = build_simulation(airless, mesh)
    matrices = NodalMatrices(simulation, fixed)
    free = int(matrices.free.sum())
    if count >= free:
        raise InvalidInput(
            f"eigenmodes: count = {count}; must be < {free}, the scene's unknowns. Ask for fewer modes."
        )
    with basis_of(scene, "eigenmodes", "count"):
        basis = reduction_basis(simulation, mesh, fixed, modes=count, symmetry=scene.symmetry)
    squares, shapes = ritz(matrices, basis)
    return _described(scene, mesh, matrices, squares[:count], shapes[:, :count])


@contextmanager
def basis_of(scene: Scene, where: str, count: str) -> Iterator[None]:
    """Errors of `reduction_basis` in the words of who asks for `count` modes."""
    try:
        yield
    except InvalidInput as error:
        text = str(error)
        if not text.startswith("reduce: "):
            raise
        if "rigid motion" in text:
            raise SceneError(
                f"{scene.source}: supports let a body move without strain; must hold it for modes of "
                "vibration. Hold more of its nodes."
            ) from None
        raise InvalidInput(text.replace("reduce: modes", f"{where}: {count}")) from None


def _described(
    scene: Scene, mesh: _engine.TetMesh, matrices: NodalMatrices, squares: Floats, shapes: Floats
) -> Eigenmodes:
    free = matrices.free
    elastic, inertial = matrices.stiffness @ shapes, matrices.mass @ shapes
    left = np.linalg.norm((elastic - squares * inertial)[free], axis=0)
    damping = np.zeros(len(squares))
    if scene.reduction is not None and scene.reduction.damping_ratio is not None:
        damping[:] = scene.reduction.damping_ratio
    elif matrices.viscosity is not None:
        damping = np.einsum("ij,ij->j", shapes, matrices.viscosity @ shapes) / (2 * np.sqrt(squares))
    fields = shapes.T.reshape(len(squares), -1, 3)
    largest = np.linalg.norm(fields, axis=2).max(axis=1)
    points = np.asarray(mesh.points)
    parities = [_parity(fields, inertial, points, axis) for axis in range(2)]
    return Eigenmodes(
        frequency=np.sqrt(squares) / (2 * np.pi),
        damping_ratio=damping,
        residual=left / np.linalg.norm(elastic[free], axis=0),
        modal_mass=1 / largest**2,
        left_right=parities[0],
        front_back=parities[1],
        shape=fields / largest[:, None, None],
    )


def _parity(fields: Floats, inertial: Floats, points: Floats, axis: int) -> tuple[str, ...]:
    """What each shape (k, n, 3), phi^T M phi = 1, is to its mirror image in the plane of this coordinate."""
    image = nearest_image(points, axis)
    signs = np.where(np.arange(3) == axis, -1.0, 1.0)
    extent = float(np.ptp(points, axis=0).max())
    if np.abs(points[image] - signs * points).max() > _SAME_PLACE * extent:
        return ("",) * len(fields)
    mirrored = (signs * fields[:, image]).reshape(len(fields), -1)
    alike = np.einsum("kj,jk->k", mirrored, inertial)
    return tuple("even" if a > _EVEN else "odd" if a < -_EVEN else "mixed" for a in alike)
