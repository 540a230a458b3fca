"""What pressures do to a wall: resultants, work, and the airflow's share in the energy."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

import plica
from plica import _engine as engine
from plica.scene.mesh.changed import changed_mesh
from plica.verify.case import Case, Check, zero
from plica.verify.larynx import larynx_scene, larynx_simulation

__all__ = ["CASES"]

Array = NDArray[np.float64]

SIZE = (0.020, 0.015, 0.010)  # m
PRESSURE = 700.0  # Pa


def hull() -> tuple[engine.TetMesh, NDArray[np.int32], Array]:
    """A distorted block, all its faces, and the nodal force (n, 3) of 1 Pa on them (N)."""
    block = engine.block_mesh(size=SIZE, divisions=(4, 3, 2))
    points = np.array(block.points)
    points += 5e-4 * np.random.default_rng(2).uniform(-1, 1, points.shape)
    mesh = changed_mesh(block, points=points)
    faces = np.vstack([np.asarray(faces) for faces in mesh.surfaces.values()])
    heights = np.array([points[:, 2].min(), points[:, 2].max()])
    patterns = np.asarray(engine.pressure_patterns(mesh, faces, heights)).sum(axis=1)
    return mesh, faces, patterns.reshape(-1, 3)


def closed_surface() -> Iterator[Check]:
    mesh, _, force = hull()
    x = np.asarray(mesh.points)
    size = float(np.abs(force).sum())
    for name, quantity, total in (
        (
            "force",
            "resultant of a constant pressure on a closed surface, over the sum of its nodal forces",
            force,
        ),
        ("moment", "moment of it, likewise, over the length of the body", np.cross(x, force) / SIZE[0]),
    ):
        yield zero(
            name=name,
            quantity=quantity,
            value=float(np.abs(total.sum(axis=0)).max()) / size,
            tolerance=1e-13,
            because="round-off of a sum over the faces",
        )


def swelling() -> Iterator[Check]:
    """A displacement that is no affine one: the volume gained is the sum over the cells of V div u."""
    mesh, _, force = hull()
    x, cells = np.asarray(mesh.points), np.asarray(mesh.cells)
    u = 1e-3 * np.sin(200 * x[:, [1, 2, 0]]) + 0.02 * x
    corners, moved = x[cells], u[cells]
    slopes = np.linalg.solve(corners[:, 1:] - corners[:, :1], moved[:, 1:] - moved[:, :1])
    volume = np.linalg.det(corners[:, 1:] - corners[:, :1]) / 6
    gained = float((volume * np.trace(slopes, axis1=1, axis2=2)).sum())
    yield Check(
        name="work",
        quantity="work of 700 Pa outside on a body that swells unevenly",
        unit="J",
        value=PRESSURE * float((force * u).sum()),
        reference=-PRESSURE * gained,
        tolerance=1e-12,
        because="round-off of a sum over the cells",
    )


def in_motion() -> Iterator[Check]:
    """Of the airflow's work in a run without other loads: du . f with f = M a + C V + K U of the states."""
    scene = larynx_scene(airflow=plica.Airflow(), initial=plica.Initial(opening_velocity=0.5))
    scene = scene.replace({"solver.tolerance": 1e-13})
    _, simulation = larynx_simulation(scene)
    n = np.asarray(simulation.displacement).size
    M, C, K = (
        csr_array(m, shape=(n, n)) for m in (simulation.mass, simulation.viscosity, simulation.stiffness)
    )
    alpha, begin, steps = -0.3, 2, 60

    def state() -> Array:
        parts = (simulation.displacement, simulation.velocity, simulation.acceleration)
        return np.stack([np.ravel(part) for part in parts])

    path, works = [state()], [0.0]
    for _ in range(steps):
        works.append(float(simulation.advance(1)["flow_work"][0]))
        path.append(state())
    forces = [np.zeros(n)]
    for before, now in pairwise(path):
        mixed = (1 + alpha) * now - alpha * before
        forces.append(M @ now[2] + C @ mixed[1] + K @ mixed[0])
    done = 0.0
    for k in range(begin, steps):
        middle = 0.5 * (forces[k] + forces[k + 1]) - alpha * (forces[k + 1] - forces[k])
        done += float((path[k + 1][0] - path[k][0]) @ middle)
    yield Check(
        name="work",
        quantity=f"work of the air on the folds in {steps - begin} steps",
        unit="J",
        value=works[-1] - works[begin],
        reference=done,
        tolerance=1e-8,
        because="60 solves to 1e-13 of a load that is some hundredth of the inertial forces",
    )


CASES = (
    Case(
        "closed-surface",
        "A constant pressure all around a body neither moves nor turns it.",
        "divergence theorem",
        closed_surface,
    ),
    Case(
        "pressure-work",
        "The work of a pressure on a wall is the pressure times the volume that the wall gives way.",
        "divergence theorem: p sum of V div u over the cells",
        swelling,
    ),
    Case(
        "flow-work",
        "The work booked for the airflow in the energy balance is that of the force which the motion of the "
        "folds asks for.",
        "R13: du . (M a + C V + K U)",
        in_motion,
    ),
)
