"""A million steps: what rounds off in each must not add up."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from benchmarks.extremes.probe import Found, Probe
from plica import _engine as engine

__all__ = ["PROBES"]

_CHUNK = 20_000


def free_block(steps: int, solver: Any) -> Found:
    """Free, unloaded, undamped: the trapezoidal rule keeps energy and momentum, a line its course.

    Each solve may leave 1e-8 of its right-hand side; allowed is as far as these would walk at random. What
    is found stays below, but is no walk. The block flies 60 m and turns: K, whose entries are rounded, has
    a force of about 1e-15 N a second for such a path, always in the same direction, so that the momentum
    drifts by 1' K v t^2 / 2, v the rigid part of the velocity, whatever the tolerance and the step.
    """
    mesh = engine.block_mesh(corner=(0, 0, 0), size=(1e-2, 1e-2, 1e-2), divisions=(1, 1, 1))
    points = np.asarray(mesh.points)
    velocity = np.stack(
        [0.1 + 0 * points[:, 0], 10 * points[:, 2], 20 * points[:, 0] * points[:, 1] * 1e2], axis=1
    )
    simulation = engine.Simulation(
        mesh,
        [engine.Material(engine.Isotropic(E=1e4, nu=0.3), density=1000.0, viscosity=0.0)],
        mesh.layer_names,
        np.zeros(len(mesh.cells), int),
        np.zeros(points.shape, bool),
        scheme=engine.Newmark(),
        step=5e-4,
        velocity=velocity,
        solver=solver,
    )
    from scipy.sparse import csr_array

    M = csr_array(simulation.mass, shape=(points.size, points.size))
    ones = np.tile(np.eye(3), (len(points), 1))  # (3 n, 3)

    def momentum() -> Any:
        return ones.T @ (M @ np.asarray(simulation.velocity).ravel())

    start, energies = momentum(), []
    for done in range(0, steps, _CHUNK):
        waves = simulation.advance(min(_CHUNK, steps - done))
        energies.append(np.asarray(waves["kinetic_energy"]) + np.asarray(waves["elastic_energy"]))
    energy = np.concatenate(energies)
    drift = float(np.abs(energy / energy[0] - 1).max())
    moved = float(np.abs(momentum() - start).max() / np.abs(start).max())
    allowed = 1e-8 * float(np.sqrt(steps))
    note = f"energy {drift:.1e}, momentum {moved:.1e} after {steps} steps"
    return Found(float(np.maximum(drift, moved)), allowed, note=note)  # NaN if either is


PROBES = [
    Probe(
        "1e4 steps", "energy and momentum kept", partial(free_block, 10_000, engine.Cholesky()), small=True
    ),
    Probe(
        "1e6 steps", "energy and momentum kept", partial(free_block, 1_000_000, engine.Cholesky()), limit=900
    ),
    Probe(
        "1e5 steps, conjugate gradients",
        "energy and momentum kept",
        partial(free_block, 100_000, engine.ConjugateGradients()),
        limit=400,
    ),
]
