"""Matrices and evolution of the free unknowns of a scene without contact."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from plica import _engine
from plica.errors import InvalidInput
from plica.identify.state_space.evolution import Evolution, hht_evolution
from plica.runs.build import fixed_components
from plica.runs.materials import materials_of
from plica.runs.scene_mesh import scene_mesh
from plica.scene.parts import HilberHughesTaylor, Newmark
from plica.scene.scene import Scene

__all__ = ["SceneMatrices", "scene_evolution", "scene_matrices"]

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class SceneMatrices:
    """M, C, K of the free unknowns of a scene, and the indices of these.

    Attributes
    ----------
    mesh : TetMesh
    free : (m,) int
        Indices among the 3 n displacement components, node by node.
    M, C, K : (m, m) sparse
    """

    mesh: _engine.TetMesh
    free: NDArray[np.intp]
    M: sparse.csr_array
    C: sparse.csr_array
    K: sparse.csr_array


def scene_matrices(scene: Scene) -> SceneMatrices:
    """Matrices of a scene without contact. Its airflow and loads are forces, which the caller provides.

    Raises
    ------
    InvalidInput
        If the scene has contact.
    SceneError
        If the scene names something that its mesh does not have.
    """
    if scene.contact is not None:
        raise InvalidInput(
            "scene_matrices: the scene has contact; must have none. Contact is not linear in the state, so "
            "there is no evolution G. Model the forces of frames in which folds touch as unknown inputs."
        )
    mesh = scene_mesh(scene)
    assembly = _engine.Assembly(mesh, *materials_of(scene, mesh))
    free = np.flatnonzero(~fixed_components(scene, mesh).reshape(-1))
    size = 3 * len(mesh.points)

    def of_free(csr: tuple[Array, NDArray[np.int32], NDArray[np.int32]]) -> sparse.csr_array:
        return sparse.csr_array(csr, shape=(size, size))[free][:, free]

    if scene.time.lumped_mass:
        mass = sparse.csr_array(sparse.diags_array(np.repeat(assembly.lumped_mass(), 3)[free]))
    else:
        mass = of_free(assembly.mass())
    return SceneMatrices(mesh, free, mass, of_free(assembly.viscosity()), of_free(assembly.stiffness()))


def scene_evolution(scene: Scene) -> tuple[Evolution, SceneMatrices]:
    """The evolution of a scene without contact over one time step, by the scene's own scheme.

    Raises InvalidInput with central differences.
    """
    matrices = scene_matrices(scene)
    scheme = scene.time.scheme.choice
    options: dict[str, Any] = {"step": float(scene.time.step)}
    if isinstance(scheme, HilberHughesTaylor):
        options["alpha"] = scheme.alpha
    elif isinstance(scheme, Newmark):
        options["newmark"] = scheme.beta, scheme.gamma
    else:
        raise InvalidInput(
            f"{scene.source}: time.scheme = central_differences; must be hht or newmark. Explicit schemes "
            "have no evolution here."
        )
    return hht_evolution(matrices.M, matrices.C, matrices.K, **options), matrices
