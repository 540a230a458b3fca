"""The engine's materials where folds have lesions."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from plica import _engine
from plica.scene.held import places_at_rest
from plica.scene.lesion_cells import lesions_with_cells
from plica.scene.mesh.lesion import Lesion
from plica.scene.scene import Scene

__all__ = ["lesion_cells", "lesion_text", "with_lesions"]

_MOST = 0.5  # share of a cell from which a picture has it in the lesion


def with_lesions(
    scene: Scene,
    mesh: _engine.TetMesh,
    materials: list[_engine.Material],
    names: list[str],
    cell_material: NDArray[np.int32],
) -> NDArray[np.int32]:
    """The material of each cell (m) where lesions change it; adds those to the lists."""
    of_cell: dict[int, list[tuple[int, Lesion, float]]] = {}
    for k, (lesion, cells, shares) in enumerate(lesions_with_cells(scene, mesh)):
        for cell, share in zip(cells.tolist(), shares.tolist(), strict=True):
            of_cell.setdefault(cell, []).append((k, lesion, share))
    found = cell_material.copy()
    made: dict[tuple[object, ...], int] = {}
    for cell, parts in sorted(of_cell.items()):
        base = int(cell_material[cell])
        key = (base, *((k, share) for k, _, share in parts))
        if key not in made:
            made[key] = len(materials)
            materials.append(_changed(materials[base], [(lesion, share) for _, lesion, share in parts]))
            names.append(f"{names[base]}.lesion.{len(made)}")
        found[cell] = made[key]
    return found


def _changed(tissue: _engine.Material, parts: list[tuple[Lesion, float]]) -> _engine.Material:
    """The mean of a tissue and of lesions that have these shares of it; where those that give a density have
    more than all of it, the density is the mean of theirs."""
    stiffness = viscosity = 1.0
    heavier = taken = 0.0
    for lesion, share in parts:
        stiffness *= 1 + share * (lesion.stiffness - 1)
        viscosity *= 1 + share * (lesion.viscosity - 1)
        if lesion.density is not None:
            heavier += share * (lesion.density - tissue.density)
            taken += share
    own = tissue.elasticity
    if isinstance(own, _engine.Isotropic):
        elasticity: Any = _engine.Isotropic(E=stiffness * own.E, nu=own.nu)
    else:
        elasticity = _engine.TransverselyIsotropic(
            E=stiffness * own.E,
            nu=own.nu,
            E_fibre=stiffness * own.E_fibre,
            nu_fibre=own.nu_fibre,
            mu_fibre=stiffness * own.mu_fibre,
            mu=None if own.mu is None else stiffness * own.mu,
            fibre=own.fibre,
        )
    return _engine.Material(
        elasticity,
        density=tissue.density + heavier / max(taken, 1.0),
        viscosity=viscosity * tissue.viscosity,
        stiffening=tissue.stiffening,
        matrix_stiffening=tissue.matrix_stiffening,
        active_stress=tissue.active_stress,
    )


def lesion_cells(scene: Scene, mesh: _engine.TetMesh) -> list[NDArray[np.intp]]:
    """The cells that lie in each lesion by more than half."""
    return [cells[shares > _MOST] for _, cells, shares in lesions_with_cells(scene, mesh)]


def lesion_text(scene: Scene, mesh: _engine.TetMesh) -> str:
    """A line on each lesion of a scene; empty without one."""
    volumes = np.asarray(_engine.signed_volumes(places_at_rest(mesh), mesh.cells))
    return "".join(
        f"\nlesion {k} ({lesion.fold}): {1e9 * float(shares @ volumes[cells]):.3g} mm^3 of tissue in "
        f"{len(cells)} tetrahedra, {np.count_nonzero(shares == 1)} of them all within"
        for k, (lesion, cells, shares) in enumerate(lesions_with_cells(scene, mesh))
    )
