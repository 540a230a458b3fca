"""The engine's materials of a scene's tissue."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from plica import _engine
from plica.errors import InvalidInput, SceneError, nearest, one_of
from plica.runs.lesions import with_lesions
from plica.scene.mesh.fibres import mirrored_fibres
from plica.scene.scene import Scene
from plica.scene.tissue import Tissue

__all__ = ["located", "materials_of", "place_text"]

Side = Literal["none", "left", "right"]
_SIDES: tuple[Side, ...] = ("none", "left", "right")


def located(scene: Scene, error: InvalidInput) -> SceneError:
    """The same error, which says of which scene."""
    if isinstance(error, SceneError):
        return error
    return SceneError(f"{scene.source}: {str(error).replace('Simulation: step =', 'time.step =')}")


def place_text(point: NDArray[np.float64]) -> str:
    """A place in m, as messages have it."""
    return "[" + ", ".join(f"{coordinate:g}" for coordinate in point) + "]"


def materials_of(
    scene: Scene, mesh: _engine.TetMesh
) -> tuple[list[_engine.Material], list[str], NDArray[np.int32]]:
    """Materials, their names, e.g. ``cover.left``, and the material of each cell (m).

    In the images of a mirrored mesh the fibre is mirrored too: where that is another direction, they have a
    material of their own, e.g. ``cover.left.front``. A fibre given for one side is that of this side. Cells
    of a lesion have one for each share that they have of it, ``cover.lesion.1``, behind all others.
    """
    layers = mesh.layer_names
    for layer in scene.tissue:
        _known_layer(scene, layer, layers)
    cell_layer, cell_side = np.asarray(mesh.cell_layer), np.asarray(mesh.cell_side)
    cell_material = np.full(len(cell_layer), -1, dtype=np.int32)
    materials, names = [], []
    for number, layer in enumerate(layers):
        cells = cell_layer == number
        if layer not in scene.tissue:
            if not cells.any():
                continue
            given = ", ".join(scene.tissue)
            first = int(cells.argmax())
            centre = np.asarray(mesh.points)[np.asarray(mesh.cells)[first, :4]].mean(axis=0)
            raise SceneError(
                f"{scene.source}: tissue.{layer} is missing: {cells.sum()} tetrahedra of the mesh are in "
                f"that layer, the first is cell {first} at {place_text(centre)} m; the scene has {given}."
            )
        tissue = scene.tissue[layer]
        one = tissue.left is None and tissue.right is None
        for code, side in enumerate(_SIDES):
            chosen = cells if one else cells & (cell_side == code)
            if (one and code > 0) or not chosen.any():
                continue
            name = layer if one or side == "none" else f"{layer}.{side}"
            own = tissue.on(side)
            for ending, image, fibre in mirrored_fibres(scene.mesh, mesh, chosen, tissue, side):
                changed = own if fibre is None else own.replace({"fibre": fibre})
                materials.append(_material(scene, changed, layer, name + ending))
                names.append(name + ending)
                cell_material[image] = len(names) - 1
        for side in ("left", "right"):
            if getattr(tissue, side) is not None and not (cells & (cell_side == _SIDES.index(side))).any():
                raise SceneError(
                    f"{scene.source}: tissue.{layer}.{side} has no tetrahedra; the mesh must define which "
                    "belong to that side. See mesh.sides."
                )
    return materials, names, with_lesions(scene, mesh, materials, names, cell_material)


def _known_layer(scene: Scene, layer: str, layers: list[str]) -> None:
    if layer not in layers:
        hint = nearest(layer, layers)
        raise SceneError(
            f"{scene.source}: tissue.{layer} is not a layer of the mesh; must be {one_of(layers)}.{hint}"
        )


def _material(scene: Scene, tissue: Tissue, layer: str, name: str) -> _engine.Material:
    if tissue.E_fibre is None:
        elasticity: Any = _engine.Isotropic(E=tissue.E, nu=tissue.nu)
    else:
        fields: dict[str, Any] = {"nu_fibre": tissue.nu_fibre, "mu_fibre": tissue.mu_fibre}
        optional = {"mu": tissue.mu_transverse, "fibre": tissue.fibre}
        fields |= {field: value for field, value in optional.items() if value is not None}
        elasticity = _engine.TransverselyIsotropic(E=tissue.E, nu=tissue.nu, E_fibre=tissue.E_fibre, **fields)
    active = {} if scene.posture is None else scene.posture.active_stress
    material = _engine.Material(
        elasticity,
        density=tissue.density,
        viscosity=tissue.viscosity,
        stiffening=tissue.stiffening,
        matrix_stiffening=tissue.matrix_stiffening,
        active_stress=active.get(layer, 0.0),
    )
    try:
        material.validate(f"tissue.{name}")
    except InvalidInput as error:
        raise located(scene, error) from None
    return material
