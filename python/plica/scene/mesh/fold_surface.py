"""The surface of folds that differ: where it is, how a mesh is moved to it, and which cells a lesion has."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plica.scene.mesh.lesion import Chink, Lesion
from plica.tetrahedron import shape_functions

__all__ = ["FoldSurface", "lesion_shares", "sides_of_nodes"]

Floats = NDArray[np.float64]

_ON_SURFACE = 1e-9  # m, below which a depth is roundoff
_CUTS = 10  # of a cell that a lesion's border may cut: 505 parts


class FoldSurface:
    """The surface of both folds at rest, and what moves a mesh of like folds there. Only x is moved.

    A fold of another gap, and a chink, move tissue by a share that falls evenly from the surface to the wall;
    above and below the medial surface it falls to 0 up to where the airway is wide. What protrudes moves the
    lesion alone, from its bottom on.

    Parameters
    ----------
    shape : mapping
        Of the larynx of like folds, `Folds.shape`.
    aside : tuple of float
        By how much (m) the left and the right fold lie further aside in the middle.
    chink : Chink, optional
    lesions : sequence of tuple
        Each with the y and z (m) of its middle.
    """

    def __init__(
        self,
        shape: Mapping[str, Any],
        aside: tuple[float, float],
        chink: Chink | None,
        lesions: Sequence[tuple[Lesion, tuple[float, float]]],
    ) -> None:
        self.lesions = lesions
        self._further, self._chink = aside, chink
        self._sections = np.asarray(shape["sections"])  # (k, 2): z, half-width
        self._major, self._radius = float(shape["major"]), float(shape["radius"])
        first, last = shape["layers_from_section"], shape["layers_to_section"]
        wide = max(last + 1, len(self._sections) - 2)
        self._heights = self._sections[[first - 1, first, last, wide], 0]

    def _like(self, y: Floats, z: Floats) -> Floats:
        """Half-width (m) of the glottis before its folds differ; 0 in front of it and behind."""
        return np.asarray(np.interp(z, *self._sections.T) * self._round(y))

    def _round(self, y: Floats) -> Floats:
        return np.sqrt(np.maximum(1 - (y / self._major) ** 2, 0.0))

    def _aside(self, sign: float, y: Floats, z: Floats) -> Floats:
        """By how much (m) this fold lies further aside."""
        moved = self._further[int(sign > 0)] * self._round(y)
        if self._chink is not None:
            moved = moved + self._chink.half_width(y + self._major)
        share = np.interp(z, self._heights, (0.0, 1.0, 1.0, 0.0))
        return np.asarray(moved * share * share * (3 - 2 * share) * (np.abs(y) < self._major))

    def without_lesions(self, sign: float, y: Floats, z: Floats) -> Floats:
        """sign x (m) of a fold's surface before anything protrudes."""
        return self._like(y, z) + self._aside(sign, y, z)

    def at(self, sign: float, y: Floats, z: Floats) -> Floats:
        """sign x (m) of a fold's surface."""
        surface = self.without_lesions(sign, y, z)
        for lesion, middle in self.lesions:
            if lesion.sign == sign:
                surface = surface - lesion.bump(y, z, middle)
        return surface

    def moved(self, points: Floats, share: float = 1.0) -> Floats:
        """Points (n, 3) m of a mesh of like folds where those of these are, or a share of the way there."""
        x, y, z = points.T
        found = points.copy()
        wall = np.sqrt(np.maximum(self._radius**2 - y**2, 0.0))
        for sign in (-1.0, 1.0):
            own = sign * x > 0
            out = sign * x[own]
            at = (y[own], z[own])
            aside = share * self._aside(sign, *at)
            depth, thick = out - self._like(*at), wall[own] - self._like(*at)
            out = out + aside * np.clip(1 - np.maximum(depth, 0.0) / np.maximum(thick, _ON_SURFACE), 0, 1)
            depth = out - self._like(*at) - aside
            depth[depth < _ON_SURFACE] = 0.0
            move = np.zeros_like(out)
            for lesion, middle in self.lesions:
                if lesion.sign == sign and lesion.protrusion > 0:
                    reach = np.maximum(lesion.reach(*at, middle), _ON_SURFACE)
                    move += share * lesion.bump(*at, middle) * np.maximum(1 - depth / reach, 0.0) ** 2
            found[own, 0] = np.where((aside == 0) & (move == 0), x[own], sign * (out - move))
        return found


def lesion_shares(
    surface: FoldSurface, points: Floats, cells: NDArray[np.int32], cell_side: NDArray[np.int32]
) -> list[tuple[NDArray[np.intp], Floats]]:
    """Of each lesion its cells, and by which share of their volume they are in it.

    Parameters
    ----------
    surface : FoldSurface
    points : (n, 3) m
        At rest.
    cells : (m, 4 or 10)
    cell_side : (m) 1 left, 2 right
    """
    middles, volumes = _parts(_CUTS)
    shapes = shape_functions(middles) if cells.shape[1] == 10 else middles
    found = []
    for lesion, middle in surface.lesions:
        near = np.flatnonzero(
            (cell_side == (1 if lesion.sign < 0 else 2)) & _near(lesion, middle, points[cells])
        )
        places = np.einsum("ka,mai->mki", shapes, points[cells[near]])
        x, y, z = np.moveaxis(places, -1, 0)
        reach = lesion.reach(y, z, middle)
        inside = (reach > 0) & (lesion.sign * x - surface.without_lesions(lesion.sign, y, z) <= reach)
        share = (inside @ volumes) / volumes.sum()
        found.append((near[share > 0], share[share > 0]))
    return found


def _near(lesion: Lesion, middle: tuple[float, float], corners: Floats) -> NDArray[np.bool_]:
    """Which cells (m), of nodes (m, any, 3), may have a part in the lesion, by their extent along y and z."""
    half = 0.5 * np.asarray(lesion.size[:2])
    low, high = (np.asarray(f(corners[..., 1:], axis=1)) for f in (np.min, np.max))
    return np.asarray(((low < middle + half) & (high > middle - half)).all(axis=1))


@cache
def _parts(cuts: int) -> tuple[Floats, NDArray[np.int64]]:
    """Middles (k, 4), barycentric, and volumes (k), of their least one, of the tetrahedra and octahedra into
    which planes along its faces, `cuts` to each height, divide a tetrahedron. The order of its corners does
    not matter: a lesion and its mirror image have the same shares."""
    middles, volumes = [], []
    for kind, volume in ((1, 1), (2, 4), (3, 1)):  # upright, octahedron, upside down
        first = np.array([corner for corner in product(range(cuts), repeat=3) if sum(corner) <= cuts - kind])
        corners = np.column_stack((first, cuts - kind - first.sum(axis=1)))
        middles.append((corners + kind / 4) / cuts)
        volumes.append(np.full(len(corners), volume))
    return np.concatenate(middles), np.concatenate(volumes)


def sides_of_nodes(cells: NDArray[np.int32], cell_side: NDArray[np.int32], count: int) -> Floats:
    """-1 for each node of the left fold, 1 of the right one, 0 of both (n)."""
    sides = np.zeros((2, count))
    for k in (0, 1):
        sides[k, cells[cell_side == k + 1]] = 1.0
    return np.asarray(sides[1] - sides[0])
