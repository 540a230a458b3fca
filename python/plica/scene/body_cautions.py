"""Cautions on how the bodies of a scene are held and where they are, with airflow or without.

Each function in `CHECKS` is one check and has the name of its caution; docs/cautions.md lists all of them.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from plica import _engine
from plica.errors import SceneError
from plica.measures.caution import Caution
from plica.measures.contour import narrowest_gap, rest_contour
from plica.scene.held import MeshArrays, fixed_components, places_at_rest
from plica.scene.initial import initial_fields
from plica.scene.lesion_cells import lesions_with_cells
from plica.scene.mesh.folds import Folds
from plica.scene.mesh.overlap import find_overlap
from plica.scene.mesh.parts import Larynx, MeshFile
from plica.scene.symmetry import symmetry_planes

if TYPE_CHECKING:
    from plica.scene.scene import Scene

__all__ = ["CHECKS", "Bodies", "body_cautions"]

_FREE_END = 0.5  # share of its area; of an end that is held, edges may be free
_SAME_GAP = 0.2  # of that at rest
_MUCH_OF_A_BUMP = 0.9  # that a node of the mesh has to have
_FEW_CELLS = 2  # of whose tissue a lesion is no patch of its own
_IN_PLANE = 1e-9  # of the mesh's extent
_ACROSS = np.cos(np.pi / 4)  # of the angle between y and the normal of an end's faces


class Bodies:
    """The bodies of a scene: cells that share nodes are one.

    Parameters
    ----------
    scene : Scene
    mesh : TetMesh or RunMesh
        The scene's mesh, built.
    """

    def __init__(self, scene: Scene, mesh: MeshArrays) -> None:
        self.scene, self.mesh = scene, mesh
        self.points = np.asarray(mesh.points, dtype=float)
        self.cells = np.asarray(mesh.cells)
        self.fixed = fixed_components(scene, mesh)

    @cached_property
    def tissue(self) -> _engine.TetMesh:
        """The mesh without labels."""
        return _engine.TetMesh(points=self.points, cells=self.cells)

    @cached_property
    def of_node(self) -> NDArray[np.int32]:
        """(n) lowest node of each node's body."""
        return np.asarray(_engine.body_of_nodes(self.tissue))

    @property
    def count(self) -> int:
        """How many bodies there are."""
        return len(np.unique(self.of_node))

    @cached_property
    def free(self) -> list[tuple[int, bool]]:
        """Lowest node of each body that can move without strain, and whether nothing of it is held, by the
        scene's supports or in its planes of symmetry."""
        held = self.fixed.copy()
        for axis in range(symmetry_planes(self.scene.symmetry)):
            held[np.abs(self.points[:, axis]) <= _IN_PLANE * np.ptp(self.points[:, axis]), axis] = True
        return list(_engine.free_bodies(self.tissue, held))

    def name(self, node: int) -> str:
        """The body of that node in words."""
        own = self.of_node[self.cells[:, 0]] == node
        layers = [self.mesh.layer_names[k] for k in np.unique(np.asarray(self.mesh.cell_layer)[own])]
        named = ", ".join(f'"{layer}"' for layer in layers)
        where = f"layer{'s' if len(layers) > 1 else ''} {named}"
        return f"the body of node {node} at {_place(self.points[node])} m ({where})"


def body_cautions(scene: Scene, mesh: MeshArrays) -> tuple[Caution, ...]:
    """The cautions of `CHECKS` that a scene gives; none for a scene that is refused as its mesh lacks what it
    names."""
    try:
        bodies = Bodies(scene, mesh)
        return tuple(found for check in CHECKS if (found := check(bodies)) is not None)
    except SceneError:
        return ()


def free_body(bodies: Bodies) -> Caution | None:
    """A body of tissue is held by nothing. With an airflow, also one that its supports let shift or turn
    without strain: the air blows it away. Without an airflow free flight is meant where the scene says
    ``supports.fixed = []``, which gives no caution. Only cells that share nodes are one body: coincident
    nodes hold nothing."""
    scene, free = bodies.scene, bodies.free
    if scene.airflow is None:
        free = [(node, unheld) for node, unheld in free if unheld]
        if scene.supports is not None and not scene.supports.components and not scene.supports.fixed:
            return None  # the scene says so: an empty table is refused
    if not free:
        return None
    node, unheld = free[0]
    how = "is held by nothing" if unheld else "can shift or turn without strain"
    whole = "the tissue" if bodies.count == 1 else bodies.name(node)
    seen = f"{whole[0].upper()}{whole[1:]} {how}: it has {_held(bodies, node)} held displacement components"
    if bodies.count > 1:
        seen += f"; {len(free)} of {bodies.count} bodies are free"
    advice = "Hold it in supports: " + _sets(bodies.mesh)
    if isinstance(scene.mesh, MeshFile) and bodies.count > 1:
        several = len(bodies.points) - len(np.unique(bodies.points, axis=0))
        seen += f". {several} nodes of the mesh have the place of another one"
        advice += " Bodies that should be one must share nodes: merge coincident ones in your mesher."
    if scene.airflow is None and unheld:
        advice += " If it shall fly freely, write supports.fixed = []." if len(free) == bodies.count else ""
    return Caution("free_body", f"{seen}.", advice)


def _held(bodies: Bodies, node: int) -> int:
    return int(bodies.fixed[bodies.of_node == node].sum())


def _sets(mesh: MeshArrays) -> str:
    names = list(mesh.node_sets)
    return f"the mesh has the node sets {', '.join(names)}." if names else "name a surface in mesh.surfaces."


def open_ends(bodies: Bodies) -> Caution | None:
    """With an airflow, most of the front or of the back of the tissue, of one of its folds or of one of its
    layers, is free. The airway is closed there in the flow model: no air leaves at its ends, however they
    move. Front and back are the faces of the boundary, but for the airway's, whose normal is within 45
    degrees of y; a third of a face is free for each corner without a held component, and half of the area of
    an end is too much."""
    airflow = bodies.scene.airflow
    if airflow is None or bodies.free:
        return None
    faces, cell = (np.asarray(found) for found in _engine.boundary(bodies.cells))
    faces = faces[:, :3]
    airway = np.asarray(bodies.mesh.surfaces.get(airflow.surface, np.empty((0, 3), int)))[:, :3]
    outside = ~_among(faces, airway)
    u, v = (bodies.points[faces[:, k]] - bodies.points[faces[:, 0]] for k in (1, 2))
    normal = 0.5 * np.cross(u, v)
    area = np.linalg.norm(normal, axis=1)
    unheld = np.asarray(~bodies.fixed.any(axis=1))
    free = unheld[faces].mean(axis=1) * area
    parts = []
    for name, sign in (("smallest", -1.0), ("largest", 1.0)):
        end = outside & (sign * normal[:, 1] >= _ACROSS * area)
        for own, of_part in _open_parts(bodies.mesh, cell, np.where(end, free, 0), np.where(end, area, 0)):
            share = 100 * free[end & of_part].sum() / area[end & of_part].sum()
            parts.append(
                f"{share:.3g} % of the {1e6 * area[end & of_part].sum():.3g} mm^2{own} at the {name} y"
            )
    if not parts:
        return None
    both = all(any(name in part for part in parts) for name in ("smallest", "largest"))
    where = "front and back" if both else "front or back"
    seen = f"The tissue is free at its {where}: no component is held of {' and '.join(parts)}."
    advice = "The flow takes the airway's ends as closed: hold them in supports, " + _sets(bodies.mesh)
    return Caution("open_ends", seen, advice)


def _open_parts(
    mesh: MeshArrays, cell: NDArray[np.int32], free: NDArray[np.float64], area: NDArray[np.float64]
) -> list[tuple[str, NDArray[np.bool_]]]:
    """What is open of an end whose faces (f) have these areas, m^2, and cells: all of it; if that is not, the
    folds that are; if none is, the layers that are."""
    layer, side = np.asarray(mesh.cell_layer)[cell], np.asarray(mesh.cell_side)[cell]
    for several in (
        [("", np.ones(len(cell), dtype=bool))],
        [(f" of the {name} fold", side == k) for k, name in ((1, "left"), (2, "right"))],
        [(f' of layer "{name}"', layer == k) for k, name in enumerate(mesh.layer_names)],
    ):
        found = [(own, part) for own, part in several if free[part].sum() > _FREE_END * area[part].sum()]
        if found:
            return found
    return []


def _among(faces: NDArray[np.int32], others: NDArray[np.int32]) -> NDArray[np.bool_]:
    """Which faces (f, 3) are among others (g, 3), whatever corner comes first."""
    both = np.sort(np.concatenate((faces, others)), axis=1)
    number = np.unique(both, axis=0, return_inverse=True)[1].reshape(-1)
    return np.isin(number[: len(faces)], number[len(faces) :])


def overlapping_bodies(bodies: Bodies) -> Caution | None:
    """Without contact, two bodies overlap at the start: they pass through each other. Cells by their corners,
    which overlap by more than a thousandth of their size (as far as contact holds surfaces apart)."""
    scene = bodies.scene
    if scene.contact is not None or bodies.count < 2:
        return None
    displacement = None
    if scene.initial is not None:
        displacement = initial_fields(scene, bodies.mesh, bodies.fixed)[0]
    x = bodies.points if displacement is None else bodies.points + displacement
    found = find_overlap(x, bodies.cells[:, :4], bodies.of_node[bodies.cells[:, 0]])
    if found is None:
        return None
    depth, one, other = found
    names = [bodies.mesh.layer_names[int(np.asarray(bodies.mesh.cell_layer)[k])] for k in (one, other)]
    layer = [f'layer "{name}"' for name in names]
    centre = _place(x[bodies.cells[one, :4]].mean(axis=0))
    seen = (
        f"Two bodies overlap at the start: cell {one} ({layer[0]}) at {centre} m and cell {other} "
        f"({layer[1]}) are {depth:.3g} m deep in each other, without contact."
    )
    advice = "Move them apart, or give them [contact]; bodies that should be one must share nodes."
    return Caution("overlapping_bodies", seen, advice)


def turned_airway(bodies: Bodies) -> Caution | None:
    """With an airflow, the airway is nowhere as narrow from left to right as from front to back: as of a mesh
    whose axes are others. The flow takes x as lateral, y from back to front and z upward."""
    airflow = bodies.scene.airflow
    if airflow is None or airflow.surface not in bodies.mesh.surfaces or _folds(bodies.scene) is not None:
        return None
    faces = np.asarray(bodies.mesh.surfaces[airflow.surface])[:, :3]
    exchanged = bodies.points[:, [1, 0, 2]], faces[:, ::-1]  # x and y: a mirror image, whose faces turn over
    across, along = (rest_contour(points, of) for points, of in ((bodies.points, faces), exchanged))
    if not (len(across) and len(along)):
        return None  # open at its ends
    width, length = (float((line[:, 2] - line[:, 1]).min()) for line in (across, along))
    if width <= length:
        return None
    seen = (
        f"The airway is at least {1e3 * width:.3g} mm wide along x, but at one height {1e3 * length:.3g} mm "
        "long along y."
    )
    return Caution("turned_airway", seen, "x must be lateral, y from back to front, z upward: turn the mesh.")


def _place(point: NDArray[np.float64]) -> str:
    return "(" + ", ".join(f"{coordinate:.4g}" for coordinate in point) + ")"


def wall_not_held(bodies: Bodies) -> Caution | None:
    """The cartilages of a larynx are held and its wall is not: a table of supports replaces the default, the
    wall, and the folds then hang between both ends alone."""
    supports = bodies.scene.supports
    if supports is None or not supports.cartilages or "wall" in (*supports.fixed, *supports.components):
        return None
    wall = np.asarray(bodies.mesh.node_sets["wall"])
    held = int(bodies.fixed[wall].all(axis=1).sum())
    return Caution(
        "wall_not_held",
        f"supports.cartilages = true holds {held} of the {len(wall)} nodes of the larynx's wall, and nothing "
        "holds the others.",
        'Is that meant? Add supports.fixed = ["wall"].',
    )


def unused_stiffening(bodies: Bodies) -> Caution | None:
    """Tissue is given that stiffens as it is strained, and the scene has neither finite strain nor a posture:
    linear tissue at rest keeps its moduli. It is softer, and a voice of it has another pitch."""
    scene = bodies.scene
    posture = scene.posture
    if scene.strain is not None or (
        posture is not None and (posture.stretch or any(posture.active_stress.values()))
    ):
        return None
    unused = [
        f"tissue.{layer}{side}.{name} = {value:g}"
        for layer, tissue in scene.tissue.items()
        for side, own in (("", tissue), (".left", tissue.left), (".right", tissue.right))
        for name in ("stiffening", "matrix_stiffening")
        if own is not None and (value := getattr(own, name))
    ]
    if not unused:
        return None
    others = f" (and {len(unused) - 1} more)" if len(unused) > 1 else ""
    return Caution(
        "unused_stiffening",
        f"{unused[0]}{others} has no effect: linear tissue keeps the moduli of small strains.",
        'strain = "finite", or a posture, makes it stiffen. Without, a voice has another pitch.',
    )


def unused_friction(bodies: Bodies) -> Caution | None:
    """Friction is given to the contact of mirror images, in a scene with a symmetry: they do not slide along
    each other, so that it does nothing."""
    contact, symmetry = bodies.scene.contact, bodies.scene.symmetry
    if contact is None or contact.friction is None or symmetry is None:
        return None
    points, surfaces = places_at_rest(bodies.mesh), bodies.mesh.surfaces
    if contact.first not in surfaces or contact.second not in surfaces:
        return None  # which is refused
    first, second = (
        np.unique(points[np.unique(surfaces[name])].round(9) + 0.0, axis=0)
        for name in (contact.first, contact.second)
    )
    image = np.unique(first * [-1, 1, 1] + 0.0, axis=0)
    if image.shape != second.shape or not np.allclose(image, second, rtol=0, atol=1e-8):
        return None
    return Caution(
        "unused_friction",
        f'contact.friction = {contact.friction:g} has no effect with symmetry = "{symmetry}": mirror images '
        "do not slide along each other.",
        "Leave it out; or leave symmetry out, where left and right differ.",
    )


def unused_gap(bodies: Bodies) -> Caution | None:
    """A larynx has ``gap``, ``left_gap`` and ``right_gap``, which do not agree: both sides say how far apart
    the folds are, and ``gap`` only how far outward the wall is."""
    folds = _folds(bodies.scene)
    if folds is None or folds.left_gap is None or folds.right_gap is None:
        return None
    both = folds.left_gap + folds.right_gap
    if folds.gap == Folds.model_fields["gap"].default or math.isclose(folds.gap, both):
        return None
    return Caution(
        "unused_gap",
        f"mesh.folds.gap = {1e3 * folds.gap:.4g} mm only sets where the wall is: left_gap and right_gap hold "
        f"the folds {1e3 * both:.4g} mm apart.",
        "Leave gap out, or one of the sides, which then is half of gap.",
    )


def posture_gap(bodies: Bodies) -> Caution | None:
    """The posture makes the glottis more than a fifth narrower or wider than at rest, where it is narrowest
    in its middle plane: tissue that contracts less than what holds it fills the gap, tissue that contracts
    more widens it. The voice then differs by its gap, too."""
    mesh = bodies.mesh
    airway = mesh.surfaces.get("airway")
    if mesh.rest is None or airway is None:
        return None
    rest, now = (1e3 * narrowest_gap(np.asarray(x, dtype=float), airway) for x in (mesh.rest, mesh.points))
    if not abs(now / rest - 1) > _SAME_GAP:
        return None
    return Caution(
        "posture_gap",
        f"At the posture the folds are {now:.3g} mm apart in their middle plane, at rest {rest:.3g} mm.",
        "Is that meant? posture.contraction sets how much what holds the tissue contracts: near the tissue's "
        "own Poisson's ratio the gap stays.",
    )


def unused_lesion(bodies: Bodies) -> Caution | None:
    """A lesion has the tissue around it and does not protrude: it changes nothing."""
    folds = _folds(bodies.scene)
    for k, lesion in enumerate(folds.lesions if folds else ()):
        if not lesion.changes_tissue and not lesion.protrusion:
            return Caution(
                "unused_lesion",
                f"mesh.folds.lesions[{k}] changes nothing: stiffness and viscosity are 1, density is that of "
                "the tissue, protrusion is 0.",
                "Give it one of these, or leave it out.",
            )
    return None


def coarse_lesion(bodies: Bodies) -> Caution | None:
    """A lesion falls between the nodes of the mesh: none is near the top of what protrudes, or the tissue
    that it changes is less than that of two cells."""
    folds = _folds(bodies.scene)
    if folds is None or not folds.lesions:
        return None
    nodes = np.unique(np.asarray(bodies.mesh.surfaces["airway"]))
    _, y, z = places_at_rest(bodies.mesh)[nodes].T
    for k, (lesion, cells, shares) in enumerate(lesions_with_cells(bodies.scene, bodies.mesh)):
        top = float(lesion.bump(y, z, folds.middle_of(lesion)).max())
        tissue = float(shares.sum())
        if top < _MUCH_OF_A_BUMP * lesion.protrusion:
            seen = (
                f"protrudes by {1e3 * lesion.protrusion:.3g} mm, and at no node of the mesh by more than "
                f"{1e3 * top:.3g} mm."
            )
        elif lesion.changes_tissue and tissue < _FEW_CELLS:
            seen = f"has the tissue of {tissue:.2g} cells of the mesh, in parts of {len(cells)}."
        else:
            continue
        return Caution(
            "coarse_lesion",
            f"mesh.folds.lesions[{k}] {seen}",
            "Take more mesh lines around the airway, mesh.options.around, a smaller mesh.options.size, "
            "or a larger lesion.",
        )
    return None


def _folds(scene: Scene) -> Folds | None:
    """The sizes of a parametric larynx; None of another mesh or larynx."""
    return scene.mesh.folds if isinstance(scene.mesh, Larynx) else None


CHECKS: tuple[Callable[[Bodies], Caution | None], ...] = (
    free_body,
    open_ends,
    overlapping_bodies,
    turned_airway,
    wall_not_held,
    unused_stiffening,
    unused_friction,
    unused_gap,
    posture_gap,
    unused_lesion,
    coarse_lesion,
)
