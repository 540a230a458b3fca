"""Which cells of a mesh the lesions of its folds have a part in."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from plica.errors import SceneError, nearest, one_of
from plica.scene.held import MeshArrays, places_at_rest
from plica.scene.mesh.fold_surface import lesion_shares
from plica.scene.mesh.lesion import Lesion
from plica.scene.mesh.parts import Larynx

if TYPE_CHECKING:
    from plica.scene.scene import Scene

__all__ = ["lesions_with_cells"]


def lesions_with_cells(
    scene: Scene, mesh: MeshArrays
) -> list[tuple[Lesion, NDArray[np.intp], NDArray[np.float64]]]:
    """Each lesion of a scene with the cells of its layers, and by which share of its volume each is in it.

    Raises
    ------
    SceneError
        If a lesion names a layer that the mesh does not have, or no tissue is in it.
    """
    folds = scene.mesh.folds if isinstance(scene.mesh, Larynx) else None
    if folds is None or not folds.lesions:
        return []
    cells, side = np.asarray(mesh.cells), np.asarray(mesh.cell_side)
    shares = lesion_shares(folds.surface(), places_at_rest(mesh), cells, side)
    found = []
    for k, (lesion, (own, share)) in enumerate(zip(folds.lesions, shares, strict=True)):
        where = f"{scene.source}: mesh.folds.lesions[{k}]"
        if lesion.layers is not None:
            names = list(mesh.layer_names)
            for j, name in enumerate(lesion.layers):
                if name not in names:
                    raise SceneError(
                        f'{where}.layers[{j}] = "{name}"; must be {one_of(names)}.{nearest(name, names)}'
                    )
            wanted = [names.index(name) for name in lesion.layers]
            chosen = np.isin(np.asarray(mesh.cell_layer)[own], wanted)
            own, share = own[chosen], share[chosen]
        if not len(own):
            raise SceneError(
                f"{where}.size: no tissue of the mesh is in the lesion; must be larger, or the mesh finer."
            )
        found.append((lesion, own, share))
    return found
