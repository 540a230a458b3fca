"""Two free blocks that turn and meet askew: what they keep through a collision (R10)."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plica import _engine as engine
from plica.verify.bodies.body import SCHEMES, Body, facing, mass_columns
from plica.verify.bodies.combinations import Combination
from plica.verify.bodies.impact import PENALTY

__all__ = ["BLOCK_STEPS", "CELL", "DENSITY", "NU", "E", "blocks", "kept", "penalised"]

CELL = 1e-3  # m
E, NU, DENSITY = 20e3, 0.3, 1040.0
BLOCK_STEPS = 200

Array = NDArray[np.float64]


def penalised(combination: Combination) -> tuple[Any, dict[str, Any]]:
    """The parts of a combination, with the penalty of these cells."""
    return combination.parts(PENALTY * E / CELL, CELL**2 / 4)


def kept(simulation: engine.Simulation, result: dict[str, Any]) -> dict[str, float | int]:
    """Collisions; sums of both sides' forces; energy gained since first touch; error of the balance."""
    first, second = result["contact_force_first"], result["contact_force_second"]
    touching = np.concatenate([[False], first.any(axis=1)])
    energy = result["kinetic_energy"] + result["elastic_energy"]
    most = energy.max()
    gained = energy + result["viscous_loss"] - result["load_work"] - simulation.state()["initial"]
    gained = np.concatenate([[0.0], gained])[int(touching.argmax()) - 1 :]
    return {
        "collisions": int((touching[1:] & ~touching[:-1]).sum()),
        "force sum": float(np.abs(first + second).max() / np.abs(first).max()),
        "gain": float((gained - gained[0])[1:].max() / most),
        "energy balance": float(np.abs(result["energy_balance_error"]).max() / most),
        "penetration": float(max(-result["deepest_gap"].min(), 0.0) / CELL),
    }


def blocks(combination: Combination, tolerance: float, steps: int = BLOCK_STEPS) -> dict[str, float | int]:
    """Two blocks of 6 x 3 x 3 cells that turn and meet askew, without supports.

    Angular momentum is that about reference positions, L = sum X x m v, which linear tissue keeps in free
    flight; contact couples cancel about current positions only. "Balance" is the most that
    L - L_0 - sum h [(1 - gamma) T_n + gamma T_{n+1}] is off, T = sum X x f of the contact forces, "change" is
    L - L_0 at the end. All are over the momentum of one block with an arm of half its length.
    """
    scheme, contact = penalised(combination)
    simulation, points, scale = _askew(scheme, contact, tolerance)
    columns = mass_columns(simulation)
    arms = _mass_arms(simulation, points)
    gamma = _gamma(combination.scheme)

    def angular() -> Array:
        return np.asarray(np.cross(arms, simulation.velocity).sum(axis=0))

    def linear() -> Array:
        return np.asarray((columns.reshape(-1, 3) * simulation.velocity).sum(axis=0))

    momenta, found, couple, parts = [linear()], [angular()], [np.zeros(3)], []
    start = time.process_time()
    for _ in range(steps):
        parts.append(simulation.advance(1))
        momenta.append(linear())
        found.append(angular())
        couple.append(np.cross(points, simulation.contact_force).sum(axis=0))
    seconds = time.process_time() - start
    result = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    torque = np.array(couple)
    step = simulation.time / steps
    turned = np.array(found) - found[0]
    expected = np.vstack(
        [np.zeros(3), np.cumsum(step * ((1 - gamma) * torque[:-1] + gamma * torque[1:]), axis=0)]
    )
    free = ~(torque[1:].any(axis=1) | torque[:-1].any(axis=1))
    linear_scale = scale / (3 * CELL)
    return {
        "steps": steps,
        "momentum": float(np.abs(np.array(momenta) - momenta[0]).max() / linear_scale),
        "angular, free": float(np.abs(np.diff(turned, axis=0)[free]).max() / scale),
        "angular, balance": float(np.abs(turned - expected).max() / scale),
        "angular, change": float(np.abs(turned[-1]).max() / scale),
        **kept(simulation, result),
        "s": seconds,
        "ms/step": 1e3 * seconds / steps,
    }


def _gamma(scheme: str) -> float:
    made = SCHEMES[scheme]
    return float(made.gamma if isinstance(made, engine.Newmark) else 0.5 - made.alpha)


def _mass_arms(simulation: engine.Simulation, points: Array) -> Array:
    """(n, 3): what to cross with a node's velocity for its part of L, sum over i of m_ij X_i."""
    data, columns, starts = simulation.mass
    rows = np.repeat(np.arange(len(starts) - 1), np.diff(starts))
    # m (x) I: any component's entries are those of m
    take = (rows % 3 == 0) & (columns % 3 == 0)
    node, other, mass = rows[take] // 3, columns[take] // 3, data[take]
    return np.stack([np.bincount(other, mass * points[node, d], len(points)) for d in range(3)], axis=1)


def _askew(scheme: Any, contact: dict[str, Any], tolerance: float) -> tuple[engine.Simulation, Array, float]:
    """The simulation, its points, and the angular momentum that all is compared with (N m s)."""
    size, gap, speed = (6 * CELL, 3 * CELL, 3 * CELL), 0.1 * CELL, 0.05
    shape: dict[str, Any] = {"size": size, "divisions": (6, 3, 3)}
    left = engine.block_mesh(corner=(-size[0], 0, 0), **shape)
    right = engine.block_mesh(corner=(gap, 0, 0), **shape)
    mesh, on_right, airway = facing(left, right)
    points = np.array(mesh.points)
    velocity = np.zeros(points.shape)
    for nodes, sign in ((~on_right, 1), (on_right, -1)):
        arms = points[nodes] - points[nodes].mean(axis=0)
        velocity[nodes] = sign * speed * np.array([1.0, 0.3, 0.2]) + np.cross((0.0, 2.0 * sign, 3.0), arms)
    material = engine.Material(engine.Isotropic(E, NU), DENSITY, 0.0)
    simulation = Body(mesh, material, np.zeros(points.shape, bool)).simulation(
        scheme=scheme,
        step=CELL / float(np.sqrt(E / DENSITY)),
        solver_tolerance=tolerance,
        contact=engine.Contact(airway=airway, **contact),
        velocity=velocity,
    )
    return simulation, points, float(DENSITY * np.prod(size) * speed * 3 * CELL)
