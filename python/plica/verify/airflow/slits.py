"""Viscous flow through slits."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from math import sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plica import _engine as engine
from plica.scene.mesh.changed import changed_mesh
from plica.verify.airflow.rest import DENSITY, PRESSURE, ROUNDING, at_rest
from plica.verify.bodies.body import Body
from plica.verify.case import Case, Check, worst

__all__ = ["CASES"]

Array = NDArray[np.float64]

MU = 1.8e-5  # Pa s
LENGTH, HEIGHT = 14e-3, 6e-3  # m, anteroposterior and along the flow
NARROW, WIDE = 0.2e-3, 1e-3  # m, gaps
RATIO = 1.2  # of the areas where the jet leaves and where it is narrowest


def slit(gap: Callable[[Array], Array], divisions: int = 12) -> Body:
    """Two plates that face each other, `gap(z)` (m) apart; linear between z = k HEIGHT / divisions."""
    thick = 2e-3
    shape: dict[str, Any] = {"size": (thick, LENGTH, HEIGHT), "divisions": (1, 4, divisions)}
    left = engine.block_mesh(corner=(-thick, -LENGTH / 2, 0), **shape)
    right = engine.block_mesh(corner=(0, -LENGTH / 2, 0), **shape)
    mesh = engine.combine(left, right, "left.", "right.")
    points, cells = np.array(mesh.points), np.asarray(mesh.cells)
    on_right = np.arange(len(points)) >= len(left.points)
    points[:, 0] += np.where(on_right, 0.5, -0.5) * gap(points[:, 2])
    walls = {"airway": np.vstack([mesh.surfaces["left.x_max"], mesh.surfaces["right.x_min"]])}
    sides = np.where(on_right[cells[:, 0]], 2, 1).astype(np.int32)
    made = changed_mesh(mesh, points=points, cell_side=sides, surfaces=walls)
    fixed = np.zeros(points.shape, bool)
    fixed[np.concatenate([mesh.node_sets["left.x_min"], mesh.node_sets["right.x_max"]])] = True
    return Body(made, engine.Material(engine.Isotropic(20e3, 0.45), 1040.0), fixed)


def viscous(viscosity: float) -> dict[str, Any]:
    model = engine.ViscousSlit(separation_ratio=RATIO, air_viscosity=viscosity)
    return {"model": model, "area": engine.Cut(sections=40)}


INSET = "the first and the last section lie 1e-4 of the height inside the slit"


def poiseuille() -> Iterator[Check]:
    """1 Pa through 40 um: inertia is a millionth of the pressure."""
    narrow = 40e-6
    simulation, found = at_rest(
        slit(lambda z: np.full_like(z, narrow)), subglottal_pressure=1.0, **viscous(MU)
    )
    yield Check(
        name="flow",
        quantity="flow at 1 Pa through a slit of 40 um",
        unit="m^3/s",
        value=float(found["flow"][0]),
        reference=LENGTH * narrow**3 / (12 * MU * HEIGHT),
        tolerance=3e-4,
        because=f"{INSET}: 2e-4, and inertia 1e-6",
    )
    heights = np.asarray(simulation.section_height)
    expected = 1 - (heights - heights[0]) / (heights[-1] - heights[0])
    found_pressure = found["section_pressure"][0]
    k = int(np.argmax(np.abs(found_pressure - expected)[1:-1])) + 1
    yield Check(
        name="pressure",
        quantity="pressure in the inner section that is furthest from a linear fall between the outer ones",
        unit="Pa",
        value=float(found_pressure[k]),
        reference=float(expected[k]),
        tolerance=2e-6,
        because="inertia: rho (Q / A)^2 / 2 = 9e-7 Pa",
        of="unit",
    )


def converging() -> Iterator[Check]:
    """p = rho Q^2 / (2 a_1^2) + R Q, R = 12 mu W^2 int dz / a^3 = 6 mu W^2 H (a_0 + a_1) / (a_0 a_1)^2."""
    first, last = WIDE * LENGTH, NARROW * LENGTH
    friction = 6 * MU * LENGTH**2 * HEIGHT * (first + last) / (first * last) ** 2
    kinetic = DENSITY / (2 * last**2)
    flow = (sqrt(friction**2 + 4 * kinetic * PRESSURE) - friction) / (2 * kinetic)
    _, found = at_rest(slit(lambda z: WIDE + (NARROW - WIDE) * z / HEIGHT), **viscous(MU))
    for name, quantity, unit, value, reference in (
        ("flow", "flow at 800 Pa", "m^3/s", found["flow"][0], flow),
        (
            "loss",
            "power lost to friction at the walls",
            "W",
            found["air_viscous_loss"][0],
            friction * flow**2,
        ),
    ):
        yield Check(
            name=name,
            quantity=quantity,
            unit=unit,
            value=float(value),
            reference=reference,
            tolerance=1e-3,
            because=f"{INSET}, where the gap is 4e-4 wider than at the exit; friction goes with its square",
        )


def throat() -> Iterator[Check]:
    """Without viscosity; the jet leaves where the slit has widened to 1.2 times its throat."""
    body = slit(lambda z: NARROW + (WIDE - NARROW) * np.abs(2 * z / HEIGHT - 1))
    simulation, found = at_rest(body, **viscous(0.0))
    area = found["section_area"][0]
    least = float(area.min())
    yield Check(
        name="flow",
        quantity="flow at 800 Pa",
        unit="m^3/s",
        value=float(found["flow"][0]),
        reference=sqrt(2 * PRESSURE / DENSITY) * RATIO * least,
        tolerance=1e-11,
        because=ROUNDING,
    )
    heights = np.asarray(simulation.section_height)
    exact = LENGTH * (NARROW + (WIDE - NARROW) * np.abs(2 * heights / HEIGHT - 1))
    value, reference = worst(area, exact)
    yield Check(
        name="area",
        quantity="area of the section that is furthest off",
        unit="m^2",
        value=value,
        reference=reference,
        tolerance=1e-8,
        because="a plane that meets nodes is raised by 1e-9 of the height, where the gap widens by 7.5e-9",
    )
    throat = int(area.argmin())
    yield Check(
        name="suction",
        quantity="pressure in the narrowest section",
        unit="Pa",
        value=float(found["section_pressure"][0, throat]),
        reference=PRESSURE * (1 - RATIO**2),
        tolerance=1e-11,
        because=ROUNDING,
    )


CASES = (
    Case(
        "poiseuille",
        "A long narrow slit carries Poiseuille's flow.",
        "p W a^3 / (12 mu H)",
        poiseuille,
    ),
    Case(
        "converging-slit",
        "In a slit that narrows, friction takes the integral of plane Poiseuille flow and the jet the rest.",
        "p = rho Q^2 / (2 a_1^2) + 12 mu W^2 Q integral of dz / a^3",
        converging,
    ),
    Case(
        "throat",
        "In a slit that widens the jet leaves at 1.2 times the least area, with suction in the throat.",
        "Bernoulli's law between throat and separation",
        throat,
    ),
)
