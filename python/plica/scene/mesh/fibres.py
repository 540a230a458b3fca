"""Directions of fibres in the images of a mirrored mesh."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from plica.scene.held import MeshArrays
from plica.scene.mesh.mirror import MIRROR_PLANES
from plica.scene.mesh.parts import Mesh, MeshFile
from plica.scene.tissue import Tissue, TissueSide

__all__ = ["mirrored_fibres"]

_Vector = tuple[float, float, float]


def mirrored_fibres(
    part: Mesh,
    mesh: MeshArrays,
    cells: NDArray[np.bool_],
    tissue: Tissue,
    side: Literal["none", "left", "right"],
) -> list[tuple[str, NDArray[np.bool_], _Vector | None]]:
    """The images of these cells (m) by the direction that the fibre of their tissue has there.

    A fibre of the tissue is that of the file's part, mirrored as the part is; one that is given for a side is
    mirrored in y = 0 alone. A fibre and its opposite are one: what is divided is what they are not.

    Parameters
    ----------
    part : Mesh
        The mesh of the scene.
    mesh : MeshArrays
        The same, built: the cells of the part, then those of its images (`mirrored`).
    cells : (m)
    tissue : Tissue
    side : str
        Side of the cells; "none": of all cells, or of those without a side.

    Returns
    -------
    list of tuple
        What to add to the name of the material, e.g. ".left.front", the cells (m), and the fibre; None: as in
        the scene.
    """
    override: TissueSide | None = None if side == "none" else getattr(tissue, side)
    given = None if override is None else override.fibre
    fibre, of_side = given or tissue.fibre, given is not None
    if not isinstance(part, MeshFile) or part.mirror is None or fibre is None:
        return [("", cells, None)]
    planes = MIRROR_PLANES[part.mirror]
    turned = [axis for axis in range(planes) if not (of_side and axis == 0) and _turns(fibre, axis)]
    copy = np.repeat(np.arange(1 << planes), len(cells) >> planes)
    found = []
    for k in range(1 << len(turned)):
        mirrored_in = [axis for j, axis in enumerate(turned) if k >> j & 1]
        own = cells & np.all([(copy >> axis & 1 == 1) == (axis in mirrored_in) for axis in turned], axis=0)
        x, y, z = (-component if axis in mirrored_in else component for axis, component in enumerate(fibre))
        if own.any():
            found.append((_ending(mesh, cells, own, turned), own, (x, y, z) if mirrored_in else None))
    return found if turned else [("", cells, None)]


def _turns(fibre: _Vector, axis: int) -> bool:
    """Whether a mirror across this axis changes the line of the fibre."""
    return fibre[axis] != 0 and any(fibre[:axis] + fibre[axis + 1 :])


def _ending(mesh: MeshArrays, cells: NDArray[np.bool_], own: NDArray[np.bool_], axes: Sequence[int]) -> str:
    """Where of some cells (m) these (m) are, along the axes that divide them."""
    ending = ""
    for axis in axes:
        above = np.asarray(mesh.points)[np.asarray(mesh.cells)[:, :4], axis].mean(axis=1) > 0
        if len(np.unique(above[cells])) == 2:
            ending += "." + (("left", "right"), ("back", "front"))[axis][int(above[own][0])]
    return ending
