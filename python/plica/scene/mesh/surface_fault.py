"""Why surfaces of a mesh cannot be the walls of the airway or the two sides of a contact.

What is found explains why; whoever asks refuses.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from plica.measures.mesh_data import MeshData

__all__ = ["airway_fault", "contact_fault", "selecting"]

_Reals = NDArray[np.float64]
_Integers = NDArray[np.integer]

_AXES = "Are x lateral, y from back to front and z upward?"
_ROUND_OFF = 1e-9  # of the surface's area, and of its root


def selecting(name: str) -> str:
    """The advice on a surface that is not the walls of the airway."""
    return f"Select in mesh.surfaces.{name} the walls of the airway alone, by label, box, plane or facing."


def airway_fault(mesh: MeshData, name: str) -> str:
    """What keeps a surface from being the walls of the airway, between two folds that face each other along x
    (a sentence with its advice); empty if nothing is found.

    Parameters
    ----------
    mesh : MeshData
    name : str
        Of its surface.
    """
    faces = np.asarray(mesh.surfaces[name])
    area, centre = _vector_areas(mesh, faces)
    size = float(np.linalg.norm(area, axis=1).sum())
    select = selecting(name)
    if _is_closed(faces):
        return f"{_closed(faces, size)}; must be open below and above, where the air comes and goes. {select}"
    across = area[:, 0]
    for fold, toward, walls in (("right", "smaller", across < 0), ("left", "larger", across > 0)):
        if abs(float(across[walls].sum())) <= _ROUND_OFF * size:
            return (
                f"none of its {len(faces)} faces ({size:.3g} m^2) looks toward {toward} x, so that the "
                f"{fold} fold is missing; must have both folds, which face each other along x. "
                f"{select} {_AXES}"
            )
    smaller, larger = (
        float(np.average(centre[walls, 0], weights=np.abs(across[walls])))
        for walls in (across > 0, across < 0)
    )
    if smaller - larger > _ROUND_OFF * float(np.sqrt(size)):  # folds that touch do face each other
        return (
            f"its walls look away from each other: those that look toward larger x are at x = {smaller:.3g} "
            f"m, the others at {larger:.3g} m (means); must face each other, as the walls of a channel do, "
            f"not the outside of the tissue. {select} {_AXES}"
        )
    return ""


def contact_fault(mesh: MeshData, names: Sequence[str], direction: Sequence[float] | None) -> str:
    """What keeps the first and the second surface from facing each other (a sentence that begins with a key
    of the contact, with its advice); empty if nothing is found.

    Parameters
    ----------
    mesh : MeshData
    names : (2) str
        Of the first and the second surface.
    direction : (3), optional
        Along which they must face each other; any without.
    """
    faces = [np.asarray(mesh.surfaces[name]) for name in names]
    own = [{tuple(corners) for corners in np.sort(part[:, :3], axis=1).tolist()} for part in faces]
    if common := len(own[0] & own[1]):
        return (
            f'second = "{names[1]}": it has {common} of its {len(own[1])} faces in common with first = '
            f'"{names[0]}"; must have none. Give each side faces of its own in mesh.surfaces.'
        )
    areas, centres = zip(*(_vector_areas(mesh, part) for part in faces), strict=True)
    sizes = [np.linalg.norm(area, axis=1) for area in areas]
    means = [np.average(centre, axis=0, weights=size) for centre, size in zip(centres, sizes, strict=True)]
    for k, key in enumerate(("first", "second")):
        other, size = 1 - k, float(sizes[k].sum())
        where = f'{key} = "{names[k]}"'
        select = f"Select in mesh.surfaces.{names[k]} the faces that can touch {names[other]} alone."
        if _is_closed(faces[k]):
            return f"{where}: {_closed(faces[k], size)}; must be one side of a gap. {select}"
        normal = areas[k].sum(axis=0) / size
        if normal @ (means[other] - means[k]) <= _ROUND_OFF * np.linalg.norm(means[other] - means[k]):
            return (
                f"{where}: its mean normal {_text(normal)} does not point from its centre {_text(means[k])} "
                f'm to that of "{names[other]}", {_text(means[other])} m; must, as the surfaces must face '
                f"each other. {select}"
            )
    if direction is not None:
        facing = areas[0].sum(axis=0) / sizes[0].sum() - areas[1].sum(axis=0) / sizes[1].sum()
        facing /= np.linalg.norm(facing)
        cosine = abs(float(facing @ direction) / float(np.linalg.norm(direction)))
        if cosine < np.sqrt(0.5):
            return (
                f"direction = {_text(direction)}: it is {np.degrees(np.arccos(cosine)):.3g} degrees off the "
                f"mean normals of the surfaces, {_text(facing)}; must be the direction in which they face "
                "each other. Set contact.direction, or with an airflow turn the mesh: x is lateral."
            )
    return ""


def _vector_areas(mesh: MeshData, faces: _Integers) -> tuple[_Reals, _Reals]:
    """(f, 3) m^2 outward, and (f, 3) m the centres of the faces, by their corners."""
    corners = np.asarray(mesh.points, dtype=float)[faces[:, :3]]
    return 0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), corners.mean(axis=1)


def _is_closed(faces: _Integers) -> bool:
    """Whether every edge is of two faces: the surface has no rim."""
    edges = np.sort(np.concatenate([faces[:, [a, b]] for a, b in ((0, 1), (1, 2), (0, 2))]), axis=1)
    return bool((np.unique(edges, axis=0, return_counts=True)[1] == 2).all())


def _closed(faces: _Integers, size: float) -> str:
    return f"its {len(faces)} faces ({size:.3g} m^2) enclose tissue, as all of the boundary does"


def _text(vector: Sequence[float] | _Reals) -> str:
    return "(" + ", ".join(f"{component + 0.0:.3g}" for component in np.round(vector, 12)) + ")"
