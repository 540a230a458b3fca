"""Tissue at its limits: columns in closed form, and motion by a second algorithm from the same matrices.

The second algorithm is HHT(-0.3) written out in double precision with SuperLU (three refinements), from the
state after the engine's first step. Displacements and strains of every layer are compared, each over the
largest of its own layer, so that nothing hides behind a softer neighbour.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.extremes.probe import Found, Probe
from plica import _engine as engine
from plica.scene.mesh.changed import changed_mesh

__all__ = ["PROBES"]

Array = NDArray[np.float64]
ALPHA, BETA, GAMMA = -0.3, 0.4225, 0.8
SIDE, STEPS = 0.01, 20
SOLVED = 1e-5
"""The solver's 1e-8 over twenty steps, times what a ratio of stiffness of 1e8 makes of it."""


def isotropic(E: float, nu: float = 0.3, density: float = 1020.0, viscosity: float = 0.5) -> Any:
    return engine.Material(engine.Isotropic(E=E, nu=nu), density=density, viscosity=viscosity)


def fibrous(along: float, shear: float) -> Any:
    law = engine.TransverselyIsotropic(
        E=1e3, nu=0.3, E_fibre=1e3 * along, nu_fibre=0.3, mu_fibre=1e3 * along / shear
    )
    return engine.Material(law, density=1020.0, viscosity=0.5)


def layered(
    order: int = 1,
    divisions: tuple[int, int, int] = (4, 3, 3),
    size: float = SIDE,
    corner: float = 0.0,
    moved: Callable[[Array], Array] = lambda x: x,
) -> Any:
    """A cube of side `size` (m) in two layers along x; `moved` maps the x of its planes, from 0 to 1."""
    block = engine.block_mesh(corner=(0, 0, 0), size=(1, 1, 1), divisions=divisions)
    points, cells = np.array(block.points), np.asarray(block.cells)
    layer = (points[cells].mean(axis=1)[:, 0] > 0.5).astype(np.int32)
    points[:, 0] = moved(points[:, 0])
    mesh = changed_mesh(block, points=corner + size * points, cell_layer=layer, layer_names=["near", "far"])
    return engine.to_quadratic(mesh) if order == 2 else mesh


def swing(
    near: Any, far: Any, step: float = 50e-6, order: int = 1, solver: Any = None, **shape: Any
) -> Found:
    """The cube held at x = 0 and thrown, twenty steps (s), against the second algorithm."""
    mesh = layered(order, **shape)
    count = len(mesh.points)
    fixed = np.zeros((count, 3), bool)
    fixed[mesh.node_sets["x_min"]] = True
    x = np.asarray(mesh.points) - np.asarray(mesh.points).min(axis=0)
    x /= np.ptp(x, axis=0)
    velocity = 0.1 * np.stack(
        [x[:, 0] * np.cos(3 * x[:, 1]), x[:, 0] * np.sin(2 * x[:, 2]), x[:, 0] ** 2], axis=1
    )
    velocity[fixed] = 0
    simulation = engine.Simulation(
        mesh,
        [near, far],
        mesh.layer_names,
        np.asarray(mesh.cell_layer),
        fixed,
        scheme=engine.HilberHughesTaylor(alpha=ALPHA),
        step=step,
        velocity=velocity,
        **({} if solver is None else {"solver": solver}),
    )
    simulation.advance(1)
    exact = _marched(simulation, ~fixed.ravel(), step)
    simulation.advance(STEPS - 1)
    return Found(_worst(mesh, np.asarray(simulation.displacement), exact), SOLVED)


def _matrices(simulation: Any, unknowns: int) -> list[Any]:
    from scipy.sparse import csc_array, csr_array

    given = (simulation.mass, simulation.stiffness, simulation.viscosity)
    return [
        csc_array((unknowns, unknowns)) if m is None else csr_array(m, shape=(unknowns, unknowns)).tocsc()
        for m in given
    ]


def _marched(simulation: Any, free: NDArray[np.bool_], h: float) -> Array:
    """(n, 3) m, the displacement after the steps that are left."""
    from scipy.sparse import diags_array
    from scipy.sparse.linalg import splu

    M, K, C = _matrices(simulation, free.size)
    u, v, a = (
        np.array(part).ravel()
        for part in (simulation.displacement, simulation.velocity, simulation.acceleration)
    )
    A = (M + (1 + ALPHA) * GAMMA * h * C + (1 + ALPHA) * BETA * h * h * K).tocsc()[free][:, free]
    scale = 1 / np.sqrt(A.diagonal())
    factor = splu(
        (diags_array(scale) @ A @ diags_array(scale)).tocsc(),
        permc_spec="MMD_AT_PLUS_A",
        diag_pivot_thresh=0.0,
    )

    def solved(b: Array) -> Array:
        found: Array = np.zeros_like(b)
        for _ in range(4):
            found = found + scale * factor.solve(scale * (b - A @ found))
        return found

    for _ in range(STEPS - 1):
        ahead, faster = u + h * v + h * h * (0.5 - BETA) * a, v + h * (1 - GAMMA) * a
        force = -C @ ((1 + ALPHA) * faster - ALPHA * v) - K @ ((1 + ALPHA) * ahead - ALPHA * u)
        a = np.zeros_like(u)
        a[free] = solved(force[free])
        u, v = ahead + h * h * BETA * a, faster + h * GAMMA * a
    return u.reshape(-1, 3)


def _worst(mesh: Any, found: Array, exact: Array) -> float:
    """Of displacements (n, 3) m and of differences within a cell, over the layer's largest; NaN if any is."""
    errors = []
    for layer in range(2):
        cells = np.asarray(mesh.cells)[np.asarray(mesh.cell_layer) == layer]
        for one, other in ((found[cells], exact[cells]), _within(cells, found, exact)):
            errors.append(np.abs(one - other).max() / np.abs(other).max())
    return float(np.max(errors))


def _within(cells: NDArray[np.int32], found: Array, exact: Array) -> tuple[Array, Array]:
    return found[cells] - found[cells[:, :1]], exact[cells] - exact[cells[:, :1]]


def column(E: tuple[float, float], nu: float, order: int = 1) -> Found:
    """Layers of moduli E (Pa) pressed by 10 Pa between smooth walls: strains sigma / (lambda + 2 mu)."""
    mesh = layered(order)
    fixed = np.zeros((len(mesh.points), 3), bool)
    fixed[:, 1:] = True
    fixed[mesh.node_sets["x_min"], 0] = True
    found = np.asarray(
        engine.equilibrium(
            mesh=mesh,
            materials=[isotropic(modulus, nu) for modulus in E],
            material_names=mesh.layer_names,
            cell_material=np.asarray(mesh.cell_layer),
            fixed=fixed,
            loads=[engine.Load(surface="x_max", traction=(-10.0, 0, 0))],
            gravity=None,
        )
    )
    confined = [modulus * (1 - nu) / ((1 + nu) * (1 - 2 * nu)) for modulus in E]
    x = np.asarray(mesh.points)[:, 0]
    exact = np.zeros_like(found)
    half = 0.5 * SIDE
    exact[:, 0] = -10 * (np.minimum(x, half) / confined[0] + np.maximum(x - half, 0) / confined[1])
    rounded = 50 * np.finfo(float).eps * max(E) / min(E) / (1 - 2 * nu)  # round-off times K's condition
    return Found(_worst(mesh, found, exact), max(rounded, 1e-12), note="the stiff layer's strain")


def _sliver(share: float) -> Callable[[Array], Array]:
    """The last layer of cells as thin as this share of the others."""
    return lambda x: np.where(np.isclose(x, 0.75), 1 - 0.25 * share, x)


def _graded(ratio: float, count: int) -> Callable[[Array], Array]:
    edges = np.concatenate([[0.0], np.cumsum(np.geomspace(1, ratio, count))])
    return lambda x: np.interp(x, np.linspace(0, 1, count + 1), edges / edges[-1])


def _probes() -> list[Probe]:
    closed, second = "closed form of a confined column", "HHT with SuperLU from the exported matrices"
    soft, usual = isotropic(1e3), isotropic(1e4)
    cases: list[tuple[str, Callable[[], Found], bool]] = []
    for order in (1, 2):
        label, add = f"P{order}", partial(partial, swing, order=order)
        for nu in (0.49, 0.499, 0.4999, 0.49999):
            cases.append(
                (f"{label}, Poisson's ratio {nu}", add(isotropic(1e4, nu), isotropic(1e3, nu)), nu == 0.4999)
            )
        for ratio in (1e2, 1e4, 1e6, 1e8):
            cases.append(
                (
                    f"{label}, held layer {ratio:g} times as stiff",
                    add(isotropic(1e3 * ratio), soft),
                    ratio == 1e8,
                )
            )
            cases.append(
                (f"{label}, free layer {ratio:g} times as stiff", add(soft, isotropic(1e3 * ratio)), False)
            )
        for ratio in (10.0, 100.0):
            cases.append(
                (
                    f"{label}, E'/E = {ratio:g}",
                    add(fibrous(ratio, ratio / 0.4), fibrous(ratio, ratio / 0.4)),
                    False,
                )
            )
            cases.append(
                (f"{label}, E'/mu' = {ratio:g}", add(fibrous(10, ratio), fibrous(10, ratio)), ratio == 100)
            )
        for viscosity in (0.0, 500.0):
            tissue = isotropic(1e4, viscosity=viscosity)
            cases.append((f"{label}, viscosity {viscosity:g} Pa s", add(tissue, tissue), False))
        for one, other in ((1.0, 1.0), (1.0, 1e5), (1e5, 1.0), (1e5, 1e5)):
            tissues = isotropic(1e4, density=one), isotropic(1e4, density=other)
            cases.append((f"{label}, densities {one:g} and {other:g} kg/m^3", add(*tissues), False))
        for share in (1e-3, 1e-6, 1e-11):
            found = add(soft, usual, moved=_sliver(share))
            cases.append((f"{label}, slivers of {share:g} of the median volume", found, share == 1e-6))
        found = add(soft, usual, divisions=(10, 3, 3), moved=_graded(1e3, 10))
        cases.append((f"{label}, cell sizes of 1:1000", found, False))
        for corner in (1.0, 1e3, 1e6, 1e9):
            cases.append(
                (f"{label}, {corner:g} m from the origin", add(soft, usual, corner=corner), corner >= 1e6)
            )
        for step in (1e-7, 1e-3, 1e-2):
            cases.append((f"{label}, step of {1e6 * step:g} us", add(soft, usual, step=step), False))
        for size in (1e-6, 1.0, 1e3):
            found = add(soft, usual, size=size, step=5e-3 * size)
            cases.append((f"{label}, a cube of {size:g} m", found, False))
        stiff = add(soft, isotropic(1e7), solver=engine.ConjugateGradients())
        cases.append((f"{label}, conjugate gradients, 10000 times as stiff", stiff, False))
    statics: list[tuple[str, Callable[[], Found], bool]] = [
        (
            f"statics, nu = {nu}, {ratio:g} times as stiff",
            partial(column, (1e3, 1e3 * ratio), nu),
            ratio == 1e8,
        )
        for nu in (0.0, 0.4999)
        for ratio in (1.0, 1e4, 1e8)
    ]
    thin = partial(swing, soft, usual, divisions=(2, 1, 1))
    cases.append(("layers of one element", thin, True))
    return [Probe(name, second, find, small) for name, find, small in cases] + [
        Probe(name, closed, find, small) for name, find, small in statics
    ]


PROBES = _probes()
