"""Layers of another thickness than the mesh's: how far the estimate would move, which no residual shows."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.linalg import splu
from scipy.spatial import KDTree

from plica import _engine
from plica.identify.likelihood import MarginalLikelihood
from plica.identify.model import MotionModel
from plica.identify.posterior import Posterior
from plica.identify.scoring import NOT_THERE
from plica.phonation.scene.changed_mesh import changed_mesh
from plica.tetrahedron import EDGES
from plica.view.faces import lattice, shapes

__all__ = ["layers_below", "thicker", "thickness_doubts", "thickness_shift"]

Array = NDArray[np.float64]

FACTOR = 1.1
TOLD = 0.5
"""Posterior sd that a shift must have to be told."""
_STEPS = 2  # of scoring; one is off by a factor of two where the problem is not linear
_SAMPLES = 4  # of a side of a face, where the nearest place of the surface is looked for
_STACKED = 0.3  # of the median depth of an interface, below which less than a tenth of its nodes lie
_UNCHANGED = 2.0  # depths of the deepest interface, below which nothing moves


def layers_below(mesh: _engine.TetMesh, surface: str) -> dict[str, NDArray[np.intp]]:
    """The layers under a surface that lie upon another one, from above downward, and the nodes that each
    shares with the next. Layers side by side, whose interface comes up to the surface, are none."""
    cells, of_cell = np.asarray(mesh.cells), np.asarray(mesh.cell_layer)
    depth = _depth(mesh, surface)
    nodes = {int(k): np.unique(cells[of_cell == k]) for k in np.unique(of_cell)}
    order = sorted(nodes, key=lambda k: float(np.median(depth[nodes[k]])))
    found = {}
    for k, below in pairwise(order):
        shared = np.intersect1d(nodes[k], nodes[below])
        if len(shared) and np.quantile(depth[shared], 0.1) > _STACKED * np.median(depth[shared]):
            found[mesh.layer_names[k]] = shared
    return found


def thicker(mesh: _engine.TetMesh, surface: str, layer: str, factor: float = FACTOR) -> _engine.TetMesh:
    """The mesh with a layer of `layers_below` thicker by a factor, at the cost of the deepest tissue.

    The layer's lower side moves away from its upper one, the sides of layers below go along, the surface and
    all beyond twice the depth of the deepest stay, and nodes between follow smoothly (a harmonic motion on
    the cells' edges). Cells and their layers are as they were.
    """
    interfaces = layers_below(mesh, surface)
    points = np.asarray(mesh.points, dtype=float)
    depth = _depth(mesh, surface)
    moved = np.full(points.shape, np.nan)
    deepest = np.median(depth[list(interfaces.values())[-1]])
    moved[depth >= min(_UNCHANGED * deepest, depth.max())] = 0.0
    side = _places(mesh, surface)
    motion = np.zeros(side.shape)
    for name, nodes in interfaces.items():
        nearest = KDTree(side).query(points[nodes])[1]
        motion = motion[nearest]
        if name == layer:
            motion = motion + (factor - 1) * (points[nodes] - side[nearest])
        moved[nodes], side = motion, points[nodes]
    moved[depth == 0] = 0.0
    return changed_mesh(mesh, points=points + _harmonic(mesh, moved))


def _harmonic(mesh: _engine.TetMesh, known: Array) -> Array:
    """(n, 3) of which the known rows stay, and of others each is the mean of its neighbours', weighted by the
    inverse length of the edge between."""
    cells, points = np.asarray(mesh.cells), np.asarray(mesh.points)
    ends = np.concatenate([cells[:, [i, j]] for i, j in EDGES])
    if cells.shape[1] == 10:
        middles = np.concatenate([cells[:, 4 + k] for k in range(6)])
        ends = np.concatenate([np.column_stack([ends[:, side], middles]) for side in (0, 1)])
    ends = np.unique(np.sort(ends, axis=1), axis=0)
    weight = 1 / np.linalg.norm(np.diff(points[ends], axis=1)[:, 0], axis=1)
    n, (i, j) = len(points), ends.T
    graph = sparse.coo_array((np.tile(weight, 2), (np.append(i, j), np.append(j, i))), shape=(n, n)).tocsr()
    laplace = (sparse.diags_array(graph.sum(axis=1)) - graph).tocsr()
    free = np.isnan(known).any(axis=1)
    found = known.copy()
    found[free] = splu(laplace[free][:, free].tocsc()).solve(-laplace[free][:, ~free] @ known[~free])
    return found


def thickness_shift(posterior: Posterior, likelihood: MarginalLikelihood, model: MotionModel) -> Array:
    """(p) By how much log theta would move with the model of other layers: two scoring steps there, each a
    sweep. `likelihood` is that of the posterior, whose error of the flow is kept; levels are found anew."""
    other = MarginalLikelihood(model, likelihood.fixed_noise, flow_error=likelihood.flow_error)
    point, precision = posterior.mean, posterior.prior_sd**-2.0
    for _ in range(_STEPS):
        at = other.evaluate(point)
        slope = at.gradient - precision * (point - posterior.prior_mean)
        point = point + np.linalg.solve(at.information + np.diag(precision), slope)
    return point - posterior.mean


def thickness_doubts(
    posterior: Posterior,
    likelihood: MarginalLikelihood,
    mesh: _engine.TetMesh,
    surface: str,
    model_on: Callable[[_engine.TetMesh], MotionModel],
) -> tuple[str, ...]:
    """In a sentence a layer: which numbers would move by more than half an sd, were it 10 % thicker."""
    told = []
    for layer in layers_below(mesh, surface):
        try:
            shift = thickness_shift(posterior, likelihood, model_on(thicker(mesh, surface, layer)))
        except NOT_THERE as error:
            told.append(f'What a thicker layer "{layer}" would change cannot be told: {error}')
            continue
        parts = [
            f'"{name}" would come out {_change(d, logarithmic)} ({d / sd:+.1f} of its sd)'
            for name, d, sd, logarithmic in zip(
                posterior.names, shift, posterior.sd, likelihood.logarithmic, strict=True
            )
            if abs(d) > TOLD * sd
        ]
        if parts:
            told.append(
                f'The thickness of the layer "{layer}" is taken from the mesh; how well it is known is not '
                f"in the intervals. Were it {100 * (FACTOR - 1):.0f} % thicker, {', '.join(parts)}, and the "
                "residual test need not fail."
            )
    return tuple(told)


def _change(shift: float, logarithmic: bool) -> str:
    if not logarithmic:
        return f"{shift:+.1f} degrees elsewhere"
    return f"{100 * abs(np.expm1(shift)):.0f} % {'higher' if shift > 0 else 'lower'}"


def _places(mesh: _engine.TetMesh, surface: str) -> Array:
    """(k, 3) m, spread over a surface, its nodes among them."""
    points, faces = np.asarray(mesh.points, dtype=float), np.asarray(mesh.surfaces[surface])
    inner = np.einsum("pk,fkc->fpc", shapes(faces.shape[1], lattice(_SAMPLES)), points[faces])
    return np.concatenate([points[np.unique(faces)], inner.reshape(-1, 3)])


def _depth(mesh: _engine.TetMesh, surface: str) -> Array:
    """(n) m from each node to the nearest of these places."""
    return np.asarray(KDTree(_places(mesh, surface)).query(np.asarray(mesh.points, dtype=float))[0])
