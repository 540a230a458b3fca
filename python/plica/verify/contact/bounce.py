"""A bar that falls on a wall (R2), and bars of unlike impedance (R3)."""

from __future__ import annotations

from collections.abc import Iterator
from math import sqrt
from typing import Any

import numpy as np

from plica import _engine as engine
from plica.verify.bodies.bars import PROBLEMS
from plica.verify.bodies.body import facing
from plica.verify.case import Case, Check
from plica.verify.contact.impact import ELEMENTS, FIRST, FRONT, RECOMMENDED, SOLVES, front

__all__ = ["CASES"]


def bouncing() -> Iterator[Check]:
    """R2: dropped from 5 m, twice. E = 900, rho = 1, L = 10, g = 10; a step is 1/300 s."""
    problem = PROBLEMS["R2"](ELEMENTS)
    bar = problem.bar
    scheme, contact = RECOMMENDED.parts(bar.modulus / bar.edge, bar.edge**2 / 4)
    run = problem.simulation(scheme, contact, SOLVES)
    result = run.simulation.advance(round(4.0 / bar.step))
    time, force = result["time"], np.abs(result["contact_force_first"][:, 0]) / bar.edge**2
    touching = force > 0
    first, second = touching & (time < 2.5), touching & (time > 2.5)
    energy = result["kinetic_energy"] + result["elastic_energy"] - result["load_work"] + problem.potential
    travelled = 2 * ELEMENTS
    for name, quantity, unit, value, reference, tolerance, because in (
        (
            "begin",
            "begin of the first impact",
            "s",
            time[first][0] - bar.step,
            1.0,
            2 * bar.step,
            "two steps",
        ),
        ("end", "end of the first impact", "s", time[first][-1], 5 / 3, front(travelled) * 2 / 3, FRONT),
        (
            "impulse",
            "impulse of the first impact per area",
            "N s/m^2",
            force[first].sum() * bar.step,
            30 * (10 * 2 / 3 + 10 * (2 / 3) ** 2 / 2),
            (10 * 2 / 3 + 10 * (2 / 3) ** 2 / 2) * 30 / ELEMENTS,
            FIRST,
        ),
        (
            "second",
            "begin of the second impact",
            "s",
            time[second][0] - bar.step,
            11 / 3,
            front(travelled + ELEMENTS * 6) * (8 / 3),
            FRONT,
        ),
        ("energy", "energy at 4 s per area", "J/m^2", energy[-1] / bar.edge**2, 500.0, 5.0, FIRST),
    ):
        yield Check(
            name=name,
            quantity=quantity,
            unit=unit,
            value=float(value),
            reference=float(reference),
            tolerance=float(tolerance),
            because=because,
            of="unit",
        )


def unequal() -> Iterator[Check]:
    """A soft light bar runs into a stiff heavy one: the pressure until the first reflection returns."""
    speed, length, n = 0.5, 0.01, ELEMENTS
    soft, stiff = (20e3, 1000.0), (80e3, 2250.0)  # Pa, kg/m^3: waves of 4.47 and 5.96 m/s
    w = length / n
    shape: dict[str, Any] = {"size": (length, w, w), "divisions": (n, 1, 1)}
    left = engine.block_mesh(corner=(-length, 0, 0), **shape)
    right = engine.block_mesh(corner=(0, 0, 0), **shape)
    mesh, on_right, airway = facing(left, right)
    materials = [engine.Material(engine.Isotropic(E, 0.0), rho) for E, rho in (soft, stiff)]
    waves = [sqrt(E / rho) for E, rho in (soft, stiff)]
    fixed = np.zeros((len(mesh.points), 3), bool)
    fixed[:, 1:] = True
    velocity = np.zeros((len(mesh.points), 3))
    velocity[~on_right, 0] = speed
    scheme, contact = RECOMMENDED.parts(1.0, 1.0)
    step = w / max(waves)
    simulation = engine.Simulation(
        mesh,
        materials,
        ["soft", "stiff"],
        on_right[np.asarray(mesh.cells)[:, 0]].astype(np.int32),
        fixed,
        scheme=scheme,
        step=step,
        solver_tolerance=SOLVES,
        contact=engine.Contact(airway=airway, **contact),
        velocity=velocity,
    )
    steps = int(0.9 * 2 * length / max(waves) / step)
    force = np.abs(simulation.advance(steps)["contact_force_first"][:, 0]) / w**2
    Z1, Z2 = (rho * c for (_, rho), c in zip((soft, stiff), waves, strict=True))
    yield Check(
        name="pressure",
        quantity="median contact pressure until the first reflection",
        unit="Pa",
        value=float(np.median(force)),
        reference=speed * Z1 * Z2 / (Z1 + Z2),
        tolerance=1 / n,
        because=FIRST,
    )


CASES = (
    Case(
        "bouncing-bar",
        "An elastic bar that falls on a wall stays for 2/3 s and meets it again at 11/3 s.",
        "R2, Doyen, Ern and Piperno, SISC 33(1) 223: rho c (v + g t), energy 500",
        bouncing,
    ),
    Case(
        "unequal-bars",
        "Bars of unlike impedance press on each other with the mean that their impedances ask for.",
        "R3: v Z_1 Z_2 / (Z_1 + Z_2), Z = rho c",
        unequal,
    ),
)
