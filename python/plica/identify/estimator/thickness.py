"""Sensitivity of the estimate to the thickness of the layers, which no residual reveals."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.linalg import splu
from scipy.spatial import KDTree

from plica import _engine
from plica.camera.visible_faces import lattice, shapes
from plica.errors import InvalidInput
from plica.identify.estimator.posterior import Posterior
from plica.identify.likelihood.likelihood import UNDEFINED_DENSITY
from plica.identify.likelihood.marginal import MarginalLikelihood
from plica.identify.model.model import MotionModel
from plica.scene.mesh.changed import changed_mesh
from plica.tetrahedron import EDGES

__all__ = ["layers_below", "thicker", "thickness_shift", "thickness_warnings"]

Array = NDArray[np.float64]

FACTOR = 1.1
REPORTED_SHIFT = 0.5
"""[posterior sd] Larger shifts give a warning."""
_STEPS = 2  # of scoring; one is wrong by up to a factor of two for a nonlinear problem
_SAMPLES = 4  # per side of a face, to find the nearest point of the surface
_STACKED = 0.3  # of the median depth of an interface; fewer than a tenth of its nodes are above that
_LEAST_JACOBIAN = 0.1  # det dx/dxi over the straight cell's, as in the larynx's own meshes
_BENDS = (1.0, 0.0, 0.25, 0.5, 0.75, 0.9, 1.1, 1.25, 1.5, 2.0)  # of an edge, over what it is
_SWEEPS = 10
_UNCHANGED = 2.0  # times the depth of the deepest interface, below which nothing moves


def layers_below(mesh: _engine.TetMesh, surface: str) -> dict[str, NDArray[np.intp]]:
    """The layers under a surface that are on top of another one, from the surface downward, and the nodes
    that each shares with the next. Layers side by side, whose interface reaches the surface, are not
    included."""
    cells, of_cell = np.asarray(mesh.cells), np.asarray(mesh.cell_layer)
    depth = _depth(mesh, surface)
    volume = np.asarray(_engine.signed_volumes(np.asarray(mesh.points, dtype=float), cells))
    nodes = {int(k): np.unique(cells[of_cell == k]) for k in np.unique(of_cell)}
    middle = depth[cells[:, :4]].mean(axis=1)
    order = sorted(nodes, key=lambda k: float(np.average(middle[of_cell == k], weights=volume[of_cell == k])))
    found = {}
    for k, below in pairwise(order):
        shared = np.intersect1d(nodes[k], nodes[below])
        if len(shared) and np.quantile(depth[shared], 0.1) > _STACKED * np.median(depth[shared]):
            found[mesh.layer_names[k]] = shared
    return found


def thicker(mesh: _engine.TetMesh, surface: str, layer: str, factor: float = FACTOR) -> _engine.TetMesh:
    """The mesh with a layer of `layers_below` thicker by a factor, at the expense of the deepest tissue.

    The lower side of the layer moves away from its upper one, and interfaces below move with it. The surface
    and all nodes below twice the depth of the deepest interface stay, and nodes between follow smoothly (a
    harmonic displacement on the edges). Cells and their layers are unchanged. Where curved cells would fold
    over, edges that are not on the surface bend more or less.

    Raises
    ------
    InvalidInput
        Naming the factor and a cell that would be inside out: the tissue below must have room.
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
    made = changed_mesh(mesh, points=_unfolded(mesh, points + _harmonic(mesh, moved), depth == 0))
    refused = f'thicker: factor = {factor:g} of the layer "{layer}"; must be nearer 1: '
    try:
        _engine.check_mesh(made)
    except InvalidInput as error:
        raise InvalidInput(f"{refused}{error}") from None
    ratios = np.asarray(_engine.least_jacobian_ratios(np.asarray(made.points), np.asarray(made.cells)))
    if ratios.min() <= 0:
        raise InvalidInput(f"{refused}the curved cell {ratios.argmin()} would fold over.")
    return made


def _unfolded(mesh: _engine.TetMesh, points: Array, held: NDArray[np.bool_]) -> Array:
    """Points (n, 3) m at which cells with curved sides do not fold over, where bending their edges more or
    less helps; held nodes (n) stay.

    Cells are looked at whose least det dx/dxi, over that of the straight cell, is below a tenth and what the
    mesh itself has. The nodes amid their edges, together and one by one, go where the least of all cells
    around is largest.
    """
    cells = np.asarray(mesh.cells)
    if cells.shape[1] == 4 or np.min(_engine.signed_volumes(points, cells)) <= 0:
        return points  # nothing to bend, or nothing that bending could mend
    wanted = np.minimum(_LEAST_JACOBIAN, _engine.least_jacobian_ratios(np.asarray(mesh.points), cells))
    middle = points.copy()
    for k, (i, j) in enumerate(EDGES):
        middle[cells[:, 4 + k]] = 0.5 * (points[cells[:, i]] + points[cells[:, j]])
    found = points.copy()
    for _ in range(_SWEEPS):
        poor = np.asarray(_engine.least_jacobian_ratios(found, cells)) < wanted
        moved = False
        for cell in cells[poor]:
            free = cell[4:][~held[cell[4:]]]
            for nodes in (free, *free[:, None]):
                around = cells[np.isin(cells[:, 4:], nodes).any(axis=1)]
                bend = _bend_of(found, middle, nodes, around)
                found[nodes] = middle[nodes] + bend * (found[nodes] - middle[nodes])
                moved |= bend != 1.0
        if not moved:
            break
    return found


def _bend_of(points: Array, middle: Array, nodes: NDArray[np.int32], around: NDArray[np.int32]) -> float:
    """Of `_BENDS`, that of these nodes (k) for which the least det dx/dxi of the cells around is largest."""
    own = np.isin(around, nodes)
    least = []
    for bend in _BENDS:
        x = points[around]
        x[own] = middle[around[own]] + bend * (x[own] - middle[around[own]])
        ratios = _engine.least_jacobian_ratios(x.reshape(-1, 3), np.arange(around.size).reshape(-1, 10))
        least.append(np.min(ratios))
    return _BENDS[int(np.argmax(least))]


def _harmonic(mesh: _engine.TetMesh, known: Array) -> Array:
    """(n, 3) with the known rows of vertices unchanged; each other vertex is the mean of its neighbours,
    weighted by the inverse edge lengths, and a node amid an edge the mean of its two ends.

    So curved cells keep the bend of their edges: one whose mid-side nodes followed alone could fold.
    """
    cells, points = np.asarray(mesh.cells), np.asarray(mesh.points)
    vertices = np.unique(cells[:, :4])
    ends = np.unique(np.sort(np.concatenate([cells[:, [i, j]] for i, j in EDGES]), axis=1), axis=0)
    weight = 1 / np.linalg.norm(np.diff(points[ends], axis=1)[:, 0], axis=1)
    n, (i, j) = len(points), ends.T
    graph = sparse.coo_array((np.tile(weight, 2), (np.append(i, j), np.append(j, i))), shape=(n, n)).tocsr()
    laplace = (sparse.diags_array(graph.sum(axis=1)) - graph).tocsr()
    free = np.zeros(n, dtype=bool)
    free[vertices] = np.isnan(known[vertices]).any(axis=1)
    held = np.setdiff1d(vertices, np.flatnonzero(free))
    found = known.copy()
    found[free] = splu(laplace[free][:, free].tocsc()).solve(-laplace[free][:, held] @ known[held])
    for k in range(4, cells.shape[1]):
        a, b = EDGES[k - 4]
        found[cells[:, k]] = 0.5 * (found[cells[:, a]] + found[cells[:, b]])
    return found


def thickness_shift(posterior: Posterior, likelihood: MarginalLikelihood, model: MotionModel) -> Array:
    """(p) Shift of log theta with a model of other layers, by two scoring steps of one sweep each. The flow
    error of `likelihood`, that of the posterior, is kept; noise levels are estimated again."""
    other = MarginalLikelihood(model, likelihood.fixed_noise, flow_error=likelihood.flow_error)
    point, precision = posterior.mean, posterior.prior_sd**-2.0
    for _ in range(_STEPS):
        at = other.evaluate(point)
        slope = at.gradient - precision * (point - posterior.prior_mean)
        point = point + np.linalg.solve(at.information + np.diag(precision), slope)
    return point - posterior.mean


def thickness_warnings(
    posterior: Posterior,
    likelihood: MarginalLikelihood,
    mesh: _engine.TetMesh,
    surface: str,
    model_on: Callable[[_engine.TetMesh], MotionModel],
) -> tuple[str, ...]:
    """A warning for each layer that, if 10 % thicker, would move parameters by more than half an sd."""
    warnings = []
    for layer in layers_below(mesh, surface):
        try:
            shift = thickness_shift(posterior, likelihood, model_on(thicker(mesh, surface, layer)))
        except UNDEFINED_DENSITY as error:
            warnings.append(f'The effect of a thicker layer "{layer}" is not known: {error}')
            continue
        parts = [
            f'"{name}" would be {_change(d, logarithmic)} ({d / sd:+.1f} of its sd)'
            for name, d, sd, logarithmic in zip(
                posterior.names, shift, posterior.sd, likelihood.logarithmic, strict=True
            )
            if abs(d) > REPORTED_SHIFT * sd
        ]
        if parts:
            warnings.append(
                f'The thickness of the layer "{layer}" is that of the mesh; its uncertainty is not in the '
                f"intervals. If it were {100 * (FACTOR - 1):.0f} % thicker, {', '.join(parts)}, and the "
                "residual test might still pass."
            )
    return tuple(warnings)


def _change(shift: float, logarithmic: bool) -> str:
    if not logarithmic:
        return f"shifted by {shift:+.1f} degrees"
    return f"{100 * abs(np.expm1(shift)):.0f} % {'higher' if shift > 0 else 'lower'}"


def _places(mesh: _engine.TetMesh, surface: str) -> Array:
    """(k, 3) m, points spread over a surface, including its nodes."""
    points, faces = np.asarray(mesh.points, dtype=float), np.asarray(mesh.surfaces[surface])
    inner = np.einsum("pk,fkc->fpc", shapes(faces.shape[1], lattice(_SAMPLES)), points[faces])
    return np.concatenate([points[np.unique(faces)], inner.reshape(-1, 3)])


def _depth(mesh: _engine.TetMesh, surface: str) -> Array:
    """(n) m from each node to the nearest of these points."""
    return np.asarray(KDTree(_places(mesh, surface)).query(np.asarray(mesh.points, dtype=float))[0])
