"""Folds of the shape M5 (Scherer et al. 2001), as meshes of a quarter that a scene mirrors.

A section is, from the wall upward: an inferior face at 40 degrees, an arc (entrance), a straight part, an
arc (exit) and a flat top. In the cast variant both arcs meet without a straight part; in the static one it is
there, and may be inclined. Lengths in mm: `lateral` from the wall, z up; the mesh has x from the midplane.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Self

import meshio
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq
from scipy.spatial import Delaunay

import plica
from benchmarks.validation.extrusion import extruded, extruded_edges

__all__ = ["M5", "Quarter", "scene", "section_mesh", "write_quarter"]

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

DEPTH, HEIGHT, LENGTH = 8.4, 10.5, 17.0  # mm
INFERIOR, EXIT_RADIUS = np.radians(40), 0.987
_UP, _BACK = np.radians(90), np.radians(180)
_CENTRE = 0.62  # of the height, on the wall: towards it the section's rings shrink


@dataclass(frozen=True)
class M5:
    """A section by its entrance radius (mm), the direction of its straight part (rad, 90 degrees: up) and the
    length of that (mm)."""

    entrance_radius: float
    direction: float
    straight: float

    @classmethod
    def cast(cls) -> Self:
        """Entrance radius 6.0 mm, height 10.5 mm: the direction in which both arcs meet follows."""

        def excess(direction: float) -> float:
            return cls(6.0, direction, 0.0).height - HEIGHT

        return cls(6.0, brentq(excess, INFERIOR, _UP), 0.0)

    @classmethod
    def static(cls, straight: float | None = None, included_angle: float = 0.0) -> Self:
        """Entrance radius 1.5 mm. The angle (rad) between both folds is positive where the glottis diverges;
        without a length of the straight part the height is 10.5 mm."""
        direction = _UP + included_angle / 2
        if straight is None:
            straight = (HEIGHT - cls(1.5, direction, 0.0).height) / _rise(direction)
        return cls(1.5, direction, straight)

    @property
    def inferior(self) -> float:
        """mm, length of the inferior face: it begins at the wall."""
        arcs = self.entrance_radius * (np.sin(min(self.direction, _UP)) - np.sin(INFERIOR))
        after = 0.0
        if self.direction < _UP:
            after = self.straight * np.cos(self.direction) + EXIT_RADIUS * (1 - np.sin(self.direction))
        return float((DEPTH - arcs - after) / np.cos(INFERIOR))

    @property
    def height(self) -> float:
        """mm"""
        return float(self.corners()[-1, 1])

    def corners(self) -> Floats:
        """(6, 2) mm, lateral and z: the ends of the five parts."""
        return np.array([part[0] for part in self._parts(1, 1, 1, 1)] + [(0.0, self._top())])

    def outline(self, edge: float) -> Floats:
        """(k, 2) mm, lateral and z from the wall to the wall, with edges of that length at the glottis and up
        to 2.5 times as long at the wall."""
        turn = self.direction - INFERIOR
        parts = self._parts(
            _count(self.inferior, 1.75 * edge),
            _count(self.entrance_radius * turn, edge),
            _count(self.straight, edge),
            max(3, _count(EXIT_RADIUS * (_BACK - self.direction), edge)),
        )
        last = parts[-1][-1]
        inward = 1 - _graded(_count(last[0], 1.75 * edge))
        top = np.stack((last[0] * inward, np.full(len(inward), last[1])), axis=1)
        return np.concatenate([part[:-1] for part in parts] + [top])

    def _top(self) -> float:
        return float(self._parts(1, 1, 1, 1)[-2][-1, 1])

    def _parts(self, *edges: int) -> list[Floats]:
        """Points of the parts, each from the end of the one before; the top is its first point alone."""
        face = self.inferior * (1 - _graded(edges[0])[::-1])
        begin = np.stack((face * np.cos(INFERIOR), face * np.sin(INFERIOR)), axis=1)
        entrance = _arc(begin[-1], self.entrance_radius, INFERIOR, self.direction, edges[1])
        along = np.linspace(0, self.straight, edges[2] + 1)[:, None]
        wall = entrance[-1] + along * (np.cos(self.direction), np.sin(self.direction))
        leave = _arc(wall[-1], EXIT_RADIUS, self.direction, _BACK, edges[3])
        return [begin, entrance, wall, leave, leave[-1:]]


def _rise(direction: float) -> float:
    """Height that a mm of straight part adds; an inclined one shortens the inferior face."""
    inclined = min(direction, _UP)
    return float(np.sin(direction) - np.cos(inclined) * np.tan(INFERIOR))


def _count(length: float, edge: float) -> int:
    return max(1, round(length / edge)) if length > 0 else 0


def _graded(edges: int) -> Floats:
    """(edges + 1) from 0 to 1, the last edge 2.5 times as long as the first."""
    steps = np.geomspace(1, 2.5, edges)
    return np.concatenate(([0.0], np.cumsum(steps) / steps.sum()))


def _arc(start: Floats, radius: float, first: float, last: float, edges: int) -> Floats:
    """A convex arc by its directions at both ends."""
    at = np.linspace(first, last, edges + 1)
    turned = np.stack((np.sin(at) - np.sin(first), np.cos(first) - np.cos(at)), axis=1)
    return start + radius * turned


def section_mesh(
    shape: M5, edge: float, cover: float | None = None
) -> tuple[Floats, Integers, NDArray[np.bool_], int]:
    """Nodes (n, 2), triangles, which of them are of the cover, and the number of nodes of the airway, which
    come first. Rings of nodes shrink from the airway towards a centre on the wall."""
    outline = shape.outline(edge)
    centre = np.array([0.0, _CENTRE * shape.height])
    rings = [outline]
    inner, begin = outline, 1.0
    if cover is not None:
        inner = _inside(outline, centre, cover)
        between = max(1, round(cover / edge))
        rings += [outline + (inner - outline) * k / between for k in range(1, between + 1)]
    while (begin := begin - 1.3 * edge * (1 + 1.5 * (1 - begin)) / DEPTH) > 0.12:
        ring = centre + begin * (inner - centre)
        rings.append(_thinned(ring, 0.8 * edge * (1 + 1.5 * (1 - begin))))
    nodes = np.concatenate([*rings, centre[None, :]])
    triangles = Delaunay(nodes).simplices.astype(np.int64)
    corners = nodes[triangles]
    doubled = np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1]))
    triangles = triangles[doubled > 1e-6 * edge**2]
    covered = np.zeros(len(triangles), dtype=bool)
    if cover is not None:
        covered = _distance(nodes[triangles].mean(axis=1), outline) < cover
    return nodes, triangles, covered, len(outline)


def _inside(outline: Floats, centre: Floats, distance: float) -> Floats:
    """The outline's nodes moved towards the centre until they are at a distance from all of it."""
    low, high = np.zeros(len(outline)), np.ones(len(outline))
    for _ in range(50):
        middle = 0.5 * (low + high)
        near = _distance(outline + middle[:, None] * (centre - outline), outline) < distance
        low, high = np.where(near, middle, low), np.where(near, high, middle)
    return outline + high[:, None] * (centre - outline)


def _distance(points: Floats, outline: Floats) -> Floats:
    """Of points (k, 2) to the polygon through the outline's nodes."""
    start, along = outline[:-1], np.diff(outline, axis=0)
    away = points[:, None, :] - start
    at = np.clip((away * along).sum(axis=2) / (along**2).sum(axis=1), 0, 1)
    return np.asarray(np.linalg.norm(away - at[:, :, None] * along, axis=2).min(axis=1))


def _thinned(ring: Floats, least: float) -> Floats:
    """Without nodes that are nearer to the one before than that; both ends stay."""
    kept = [ring[0]]
    for node in ring[1:-1]:
        if min(np.linalg.norm(node - kept[-1]), np.linalg.norm(node - ring[-1])) >= least:
            kept.append(node)
    return np.array([*kept, ring[-1]])


@dataclass(frozen=True)
class Quarter:
    """What a mesh is made of: the shape, the gap between both folds (mm), the edge at the glottis (mm), the
    number of cells along half the length, the thickness of a cover (mm), if there is one, and the length."""

    shape: M5
    gap: float = 0.1
    edge: float = 1.2
    along: int = 4
    cover: float | None = None
    length: float = LENGTH


def write_quarter(quarter: Quarter, path: Path) -> Path:
    """The front half of the right fold in mm, with the surfaces `airway`, `wall` and `front`.

    The flat top is no part of `airway`: it has many x at one height, and no pressure without a tract.
    """
    nodes, triangles, covered, airway = section_mesh(quarter.shape, quarter.edge, quarter.cover)
    section = nodes * (-1, 1) + (quarter.gap / 2 + nodes[:, 0].max(), 0)
    levels = np.linspace(0, quarter.length / 2, quarter.along + 1)
    points, cells = extruded(section, triangles, levels)
    wall = np.flatnonzero(nodes[:, 0] < 1e-9)
    wall = wall[np.argsort(nodes[wall, 1])]
    run = np.arange(airway - np.count_nonzero(nodes[:airway, 1] > quarter.shape.height - 1e-9) + 1)
    surfaces = {
        "airway": extruded_edges(np.stack((run[:-1], run[1:]), axis=1), len(nodes), len(levels)),
        "wall": extruded_edges(np.stack((wall[:-1], wall[1:]), axis=1), len(nodes), len(levels)),
        "front": triangles + quarter.along * len(nodes),
    }
    layer = np.tile(np.where(covered, 2, 1), 3 * quarter.along)
    write_labelled(path, points, cells, layer, surfaces)
    return path


def write_labelled(
    path: Path, points: Floats, cells: Integers, layer: Integers, surfaces: dict[str, Integers]
) -> None:
    """A file as Gmsh writes it: layers 1, `body`, and 2, `cover`, and surfaces by their names."""
    labels = [layer, *(np.full(len(faces), 11 + k) for k, faces in enumerate(surfaces.values()))]
    names = {"body": np.array([1, 3]), "cover": np.array([2, 3])}
    meshio.Mesh(
        points,
        [("tetra", cells), *(("triangle", faces) for faces in surfaces.values())],
        cell_data={"gmsh:physical": labels, "gmsh:geometrical": [np.ones(len(one), int) for one in labels]},
        field_data=names | {name: np.array([11 + k, 2]) for k, name in enumerate(surfaces)},
    ).write(path, file_format="gmsh22")


def scene(
    path: Path, body: plica.Tissue, cover: plica.Tissue | None = None, mirror: str = "quarter", order: int = 2
) -> plica.Scene:
    """A scene of a mesh of `write_quarter`, whose airflow's pressure is found by `plica.onset`."""
    tissue = {"body": body} if cover is None else {"body": body, "cover": cover}
    mesh = plica.MeshFile(
        file=path,
        unit="mm",
        mirror=mirror,
        order=order,
        layers={name: name for name in tissue},
        surfaces={name: name for name in ("airway", "wall", "front")},
    )
    return plica.Scene(
        mesh,
        tissue,
        supports=plica.Supports(fixed=["wall", "front"]),
        airflow=plica.Airflow(),
        symmetry="quarter" if mirror == "quarter" else "half",
        time=plica.Stepping(step="50 us", duration="50 ms"),
    )
