"""R9, the contact patch test: uniform pressure through a flat interface between two meshes.

Two unit cubes of n^3 hexahedra each, E = 20 kPa, nu = 0.3, touch at x = 0. One is held at its far end, the
other pressed there; both swell freely between rollers. Exact is a uniform stress, whose displacement linear
and quadratic tetrahedra contain. Errors are those of the state of rest: of the stress in the energy norm, and
the largest at the corners of a cell (of the pressure); of the displacement (of the shortening); of the nodal
forces at the interface (of the largest exact one).
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from scipy.sparse import csr_array

from benchmarks.harness.study import record, script_parser
from plica import _engine as engine
from plica.tetrahedron import EDGES
from plica.verify.contact.airway import air_between

E, NU, DENSITY = 20e3, 0.3, 1040.0


def largest_stress_error(mesh: Any, displacement: np.ndarray, pressure: float) -> float:
    """Largest component of sigma + pressure e_x e_x at the cells' corners, of the pressure."""
    points, cells = np.asarray(mesh.points), np.asarray(mesh.cells)
    corners = points[cells[:, :4]]
    inner = np.linalg.inv((corners[:, 1:] - corners[:, :1]).transpose(0, 2, 1))
    linear = np.concatenate([-inner.sum(axis=1, keepdims=True), inner], axis=1)  # gradients, (m, 4, 3)
    mu, lame = E / 2 / (1 + NU), E * NU / (1 + NU) / (1 - 2 * NU)
    worst = 0.0
    for corner in range(4):
        gradients = linear
        if cells.shape[1] == 10:
            at_corners = [(4 * (k == corner) - 1) * linear[:, k] for k in range(4)]
            between = [4 * ((i == corner) * linear[:, j] + (j == corner) * linear[:, i]) for i, j in EDGES]
            gradients = np.stack(at_corners + between, axis=1)
        gradient = np.einsum("mnc,mnd->mcd", displacement[cells], gradients)
        strain = (gradient + gradient.transpose(0, 2, 1)) / 2
        stress = 2 * mu * strain + lame * np.trace(strain, axis1=1, axis2=2)[:, None, None] * np.eye(3)
        stress[:, 0, 0] += pressure
        worst = max(worst, float(np.abs(stress).max()))
    return worst / pressure


def patch(order: int, first: int, second: int, enforcement: Any, mortar: bool, strain: float) -> list[float]:
    """The closed rows, and the errors of the module's head."""
    cubes = [
        engine.block_mesh(corner=(x, 0, 0), size=(1, 1, 1), divisions=(n, n, n))
        for x, n in ((-1, first), (0, second))
    ]
    if order == 2:
        cubes = [engine.to_quadratic(cube) for cube in cubes]
    mesh = engine.combine(*cubes, "a.", "b.")
    points = np.asarray(mesh.points)
    fixed = np.zeros(points.shape, bool)
    fixed[mesh.node_sets["a.x_min"], 0] = True
    for side in "ab":
        fixed[mesh.node_sets[f"{side}.y_min"], 1] = True
        fixed[mesh.node_sets[f"{side}.z_min"], 2] = True
    surfaces = [mesh.surfaces[name] for name in ("a.x_max", "b.x_min")]
    contact = engine.Contact(
        airway=air_between(points, *surfaces),
        enforcement=enforcement,
        tolerance=1e-3 * strain,
        faces=engine.Mortar(*surfaces) if mortar else engine.AtNodes(),
    )
    transit = np.sqrt(DENSITY / E)
    material = engine.Material(engine.Isotropic(E, NU), density=DENSITY, viscosity=0.2 * E * transit)
    pressure = strain * E
    sim = engine.Simulation(
        mesh,
        [material],
        ["cubes"],
        np.zeros(len(mesh.cells), int),
        fixed,
        scheme=engine.Newmark(beta=1.0, gamma=1.5),  # ends fast motion within two steps
        step=5 * transit,
        solver_tolerance=1e-11,
        contact=contact,
        loads=[engine.Load(surface="b.x_max", traction=(-pressure, 0, 0))],
    )
    rows = sim.advance(25)["contact_rows"][-1]
    exact = strain * np.stack([-(points[:, 0] + 1), NU * points[:, 1], NU * points[:, 2]], axis=1)
    stiffness = csr_array(sim.stiffness, shape=(points.size, points.size))
    error, forces = (np.asarray(sim.displacement) - exact).ravel(), stiffness @ exact.ravel()
    side = np.asarray(mesh.node_sets["a.x_max"])
    exact_force = forces.reshape(-1, 3)[side, 0]
    off_force = np.asarray(sim.contact_force)[side, 0] - exact_force
    return [
        float(rows),
        float(np.sqrt(error @ (stiffness @ error) / (exact.ravel() @ forces))),
        largest_stress_error(mesh, np.asarray(sim.displacement), pressure),
        float(np.abs(error).max() / (2 * strain)),
        float(np.abs(off_force).max() / np.abs(exact_force).max()),
    ]


COLUMNS = (
    *("elements", "cubes of", "contact", "faces", "rows"),
    *("stress, energy norm", "stress, largest", "displacement", "nodal force"),
)


def rows() -> Iterator[list[str]]:
    """A row for each case and pair of meshes."""
    enforcements = {
        "multipliers": engine.Multipliers(),
        "augmented": engine.Augmented(stiffness=100 * E),
        "penalty": engine.Penalty(stiffness=100 * E),
    }
    cases = [
        ("linear", 1, "multipliers", "nodes", ((2, 2), (2, 4), (2, 3), (3, 2), (4, 6))),
        ("linear", 1, "penalty", "nodes", ((2, 2), (2, 4), (2, 3), (4, 6))),
        ("linear", 1, "multipliers", "mortar", ((2, 2), (2, 3), (4, 6))),
        ("linear", 1, "penalty", "mortar", ((2, 2), (2, 3))),
        ("quadratic", 2, "multipliers", "nodes", ((2, 2), (2, 4), (2, 3), (3, 2), (4, 6))),
        ("quadratic", 2, "penalty", "nodes", ((2, 2), (2, 3))),
        ("quadratic", 2, "multipliers", "mortar", ((2, 2), (2, 4), (2, 3), (3, 2), (4, 6))),
        ("quadratic", 2, "augmented", "mortar", ((2, 3),)),
        ("quadratic", 2, "penalty", "mortar", ((2, 2), (2, 3))),
    ]
    for name, order, contact, faces, pairs in cases:
        for first, second in pairs:
            closed, *errors = patch(order, first, second, enforcements[contact], faces == "mortar", 1e-6)
            cubes = f"{first}^3, {second}^3"
            yield [name, cubes, contact, faces, f"{closed:.0f}", *(f"{error:.1e}" for error in errors)]


if __name__ == "__main__":
    script_parser(__doc__).parse_args()
    record("contact_patch", COLUMNS, rows())
