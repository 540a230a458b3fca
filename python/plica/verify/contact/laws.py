"""What bodies keep through a collision (R10), mirror symmetry, and Coulomb's law."""

from __future__ import annotations

from collections.abc import Iterator
from math import atan, cos, sin, sqrt

import numpy as np
from scipy.spatial import cKDTree

import plica
from plica import _engine as engine
from plica.verify.bodies.blocks import blocks
from plica.verify.bodies.body import Body
from plica.verify.bodies.combinations import Combination
from plica.verify.case import Case, Check, zero
from plica.verify.contact.airway import air_between
from plica.verify.larynx import larynx_scene, larynx_simulation

__all__ = ["CASES"]

SOLVES, STEPS = 1e-12, 120
CLOSE = 1e-8  # mean edges: the gap's tolerance where symmetry is looked at
FRICTION, GRAVITY, STIFF, SIDE = 0.3, 9.81, 1e6, 0.01  # -, m/s^2, Pa, m


def askew() -> Iterator[Check]:
    """Two blocks without supports that turn and meet askew."""
    found = blocks(Combination("multipliers", "HHT(-0.3)", "redistributed"), SOLVES, STEPS)
    margin = 1e3 * SOLVES
    because = f"{STEPS} solves to {SOLVES:g} each, with a margin of ten for their sum"
    for name, quantity, key, unit in (
        ("momentum", "largest change of the momentum, over that of one block", "momentum", "1"),
        (
            "angular-momentum",
            "largest change of the angular momentum about reference positions that contact couples leave "
            "unexplained, over that of one block with an arm of half its length",
            "angular, balance",
            "1",
        ),
    ):
        yield zero(
            name=name,
            quantity=quantity,
            unit=unit,
            value=found[key],
            tolerance=margin,
            because=because,
        )
    yield zero(
        name="forces",
        quantity="largest sum of the contact forces on both, over the largest force",
        value=found["force sum"],
        tolerance=1e-14,
        because="round-off",
    )
    yield zero(
        name="energy",
        quantity="energy gained since first touch, over the largest energy",
        value=max(float(found["gain"]), 0.0),
        tolerance=margin,
        because=because,
    )
    yield Check(
        name="collisions",
        quantity="collisions that took place",
        value=float(found["collisions"]),
        reference=1.0,
        tolerance=0.0,
        because="a count",
    )


def mirror() -> Iterator[Check]:
    """Folds that are thrown at each other, on a mesh that is its mirror image to the last bit."""
    contact = plica.Contact(multipliers=plica.Multipliers(), tolerance=CLOSE)
    scene = larynx_scene(
        airflow=plica.Airflow(), contact=contact, initial=plica.Initial(opening_velocity=-2.0)
    )
    mesh, simulation = larynx_simulation(scene.replace({"solver.tolerance": SOLVES}))
    x = np.asarray(mesh.points)
    partner = cKDTree(x).query(x * [-1, 1, 1])[1]
    off, closed = 0.0, 0
    for _ in range(20):
        closed = max(closed, int(simulation.advance(1)["contact_rows"][0]))
        u = np.asarray(simulation.displacement)
        off = max(off, float(np.abs(u[partner] * [-1, 1, 1] - u).max() / np.abs(u).max()))
    yield zero(
        name="motion",
        quantity="largest difference between a fold and the mirror image of the other, over the "
        "largest motion",
        value=off,
        tolerance=100 * CLOSE,
        because="a hundred times the gap's tolerance, 1e-8 edges: forces act along normals of the last pass",
    )
    yield Check(
        name="collision",
        quantity="whether the folds collided (1: they did)",
        value=float(closed > 0),
        reference=1.0,
        tolerance=0.0,
        because="yes or no",
    )


def incline(slope: float) -> tuple[float, float]:
    """How far (m) and how long (s) a stiff cube has gone down a rigid incline (rad), with friction."""
    side, far, step, steps = SIDE, 0.1, 1e-4, 400
    plate = engine.block_mesh(corner=(-side, -far, -far), size=(side, 2 * far, 2 * far))
    cube = engine.block_mesh(corner=(0, -side / 2, -side / 2), size=(side,) * 3, divisions=(1, 2, 2))
    mesh = engine.combine(plate, cube, "a.", "b.")
    on_cube = np.arange(len(mesh.points)) >= len(plate.points)
    body = Body(
        mesh, engine.Material(engine.Isotropic(STIFF, 0.0), 1000.0), np.repeat(~on_cube[:, None], 3, axis=1)
    )
    contact = engine.Contact(
        airway=air_between(np.asarray(mesh.points), mesh.surfaces["a.x_max"], mesh.surfaces["b.x_min"]),
        enforcement=engine.Multipliers(),
        tolerance=1e-9,
        friction=FRICTION,
    )
    simulation = body.simulation(
        scheme=engine.HilberHughesTaylor(alpha=-0.3),
        step=step,
        solver_tolerance=SOLVES,
        contact=contact,
        gravity=tuple(GRAVITY * np.array([-cos(slope), sin(slope), 0.0])),
    )
    simulation.advance(steps)
    mass = body.whole(body.assembly.mass())
    moved = (mass @ np.ravel(simulation.displacement)).reshape(-1, 3)[on_cube, 1].sum()
    return float(moved) / (1000.0 * side**3), step * steps


def friction() -> Iterator[Check]:
    """Steeper and less steep than the friction angle."""
    steep, flat = atan(2 * FRICTION), atan(0.5 * FRICTION)
    way, t = incline(steep)
    settling = 2 * 2 * SIDE / sqrt(STIFF / 1000.0) / t
    because = (
        "gravity sets in at once, and presses when a wave has run through the block and back: "
        "twice that, over 40 ms"
    )
    yield Check(
        name="slides",
        quantity="way down an incline of twice the friction coefficient in 40 ms",
        unit="m",
        value=way,
        reference=0.5 * GRAVITY * (sin(steep) - FRICTION * cos(steep)) * t**2,
        tolerance=settling,
        because=because,
    )
    way, _ = incline(flat)
    yield zero(
        name="holds",
        quantity="way down an incline of half the friction coefficient, over that without friction",
        value=way / (0.5 * GRAVITY * sin(flat) * t**2),
        tolerance=settling,
        because=because,
    )


CASES = (
    Case(
        "askew",
        "Two free blocks that meet askew keep their momentum, gain no energy, and turn as their "
        "contact couples say.",
        "R10: conservation laws",
        askew,
    ),
    Case(
        "mirror",
        "Folds that are mirror images stay so through a collision, driven by the air.",
        "symmetry of the problem",
        mirror,
    ),
    Case(
        "friction",
        "A block slides down a steep incline as Coulomb's law says, and stays on one that is less steep.",
        "g (sin - mu cos) t^2 / 2, and nothing where tan < mu",
        friction,
    ),
)
