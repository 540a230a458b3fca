"""Layers of another thickness than the mesh's: how far the estimate would move, which no residual shows."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from plica import _engine
from plica.errors import InvalidInput
from plica.identify.likelihood import MarginalLikelihood
from plica.identify.model import MotionModel
from plica.identify.posterior import Posterior
from plica.phonation.scene.changed_mesh import changed_mesh
from plica.phonation.scene.scene import Scene
from plica.view.faces import lattice, shapes

__all__ = ["layers_below", "thicker", "thickness_doubts", "thickness_shift"]

Array = NDArray[np.float64]

FACTOR = 1.1
TOLD = 0.5
"""Posterior sd that a shift must have to be told."""
_SAMPLES = 4  # of a side of a face, where the nearest place of the surface is looked for
_UNEVEN, _ABOVE = 1.25, 0.75  # of a layer that lies upon another, this share ends within so much of its depth
_UNCHANGED = 2.0  # depths of the deepest layer, below which nothing moves


def layers_below(mesh: _engine.TetMesh, surface: str) -> dict[str, float]:
    """Depth (m) below a surface at which each layer ends that lies upon another, from above downward.

    That is the median distance of the nodes that it shares with the next one, where most of its own lie
    above: layers side by side have no thickness.
    """
    cells, of_cell = np.asarray(mesh.cells), np.asarray(mesh.cell_layer)
    depth = _depth(mesh, surface)[0]
    nodes = {k: np.unique(cells[of_cell == k]) for k in np.unique(of_cell)}
    order = sorted(nodes, key=lambda k: np.median(depth[nodes[k]]))
    found: dict[str, float] = {}
    for k, below in pairwise(order):
        shared = np.intersect1d(nodes[k], nodes[below])
        end = float(np.median(depth[shared])) if len(shared) else 0.0
        if np.mean(depth[nodes[k]] < _UNEVEN * end) > _ABOVE and end > max(found.values(), default=0.0):
            found[mesh.layer_names[k]] = end
    return found


def thicker(mesh: _engine.TetMesh, surface: str, layer: str, factor: float = FACTOR) -> _engine.TetMesh:
    """The mesh with a layer of `layers_below` thicker by a factor, at the cost of the deepest tissue.

    Nodes move along the way to the nearest place of the surface, which stays, as do cells and their layers.
    """
    depths = layers_below(mesh, surface)
    names, knots = list(depths), np.array([0.0, *depths.values()])
    k = names.index(layer)
    moved = knots.copy()
    moved[k + 1 :] += (factor - 1) * (knots[k + 1] - knots[k])
    depth, nearest = _depth(mesh, surface)
    last = min(_UNCHANGED * knots[-1], float(depth.max()))
    wanted = np.interp(depth, [*knots, last], [*moved, last])
    share = np.divide(wanted, depth, out=np.ones_like(depth), where=(depth > 0) & (depth < last))
    points = np.asarray(mesh.points)
    return changed_mesh(mesh, points=nearest + share[:, None] * (points - nearest))


def thickness_shift(
    posterior: Posterior, likelihood: MarginalLikelihood, scene: Scene, mesh: _engine.TetMesh
) -> Array:
    """(p) By how much log theta would move on a mesh of the same nodes and cells, other places: one scoring
    step there, with its own levels of the noise. A sweep.

    `likelihood` is that of the posterior.
    """
    seen = likelihood.model
    model = MotionModel(scene, seen.tissue.parameters, seen.observation, seen.forcing, mesh=mesh)
    other = MarginalLikelihood(model, likelihood.fixed_noise, flow_error=likelihood.flow_error)
    at = other.evaluate(posterior.mean)
    precision = posterior.prior_sd**-2.0
    slope = at.gradient - precision * (posterior.mean - posterior.prior_mean)
    return np.asarray(np.linalg.solve(at.information + np.diag(precision), slope))


def thickness_doubts(
    posterior: Posterior, likelihood: MarginalLikelihood, scene: Scene, mesh: _engine.TetMesh, surface: str
) -> tuple[str, ...]:
    """In a sentence a layer: which numbers would move by more than half an sd, were it 10 % thicker."""
    told = []
    for layer in layers_below(mesh, surface):
        try:
            shift = thickness_shift(posterior, likelihood, scene, thicker(mesh, surface, layer))
        except InvalidInput as error:
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


def _depth(mesh: _engine.TetMesh, surface: str) -> tuple[Array, Array]:
    """(n) m from each node to the nearest of places spread over the surface, its nodes among them, and (n, 3)
    these places."""
    points, faces = np.asarray(mesh.points, dtype=float), np.asarray(mesh.surfaces[surface])
    inner = np.einsum("pk,fkc->fpc", shapes(faces.shape[1], lattice(_SAMPLES)), points[faces])
    places = np.concatenate([points[np.unique(faces)], inner.reshape(-1, 3)])
    depth, nearest = KDTree(places).query(points)
    return depth, places[nearest]
