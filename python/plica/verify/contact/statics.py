"""Contact at rest: the patch test (R9) and Hertz's cylinder (R4)."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from math import pi, sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plica import _engine as engine
from plica.scene.mesh.changed import changed_mesh
from plica.verify.bodies.body import Body
from plica.verify.case import Case, Check, worst, zero
from plica.verify.contact.airway import air_between

__all__ = ["CASES", "graded"]

Array = NDArray[np.float64]

E, NU, DENSITY, STRAIN = 20e3, 0.3, 1040.0, 1e-6
HERTZ_E, RADIUS, WIDTH, EDGES = 1e4, 1.0, 0.025, 8  # Pa, m, m of contact aimed at, cells within it


def at_rest(body: Body, contact: engine.Contact, **parts: Any) -> engine.ContactEquilibrium:
    cells = np.zeros(len(body.mesh.cells), np.int32)
    return engine.contact_equilibrium(
        body.mesh, [body.material], ["tissue"], cells, body.fixed, contact=contact, **parts
    )


def patch(order: int, first: int, second: int, mortar: bool) -> Iterator[Check]:
    """Two unit cubes of n^3 hexahedra on rollers, pressed on each other."""
    cubes = [
        engine.block_mesh(corner=(x, 0, 0), size=(1, 1, 1), divisions=(n, n, n))
        for x, n in ((-1, first), (0, second))
    ]
    first_cube, second_cube = (engine.to_quadratic(cube) if order == 2 else cube for cube in cubes)
    mesh = engine.combine(first_cube, second_cube, "a.", "b.")
    x = np.asarray(mesh.points)
    fixed = np.zeros(x.shape, bool)
    fixed[mesh.node_sets["a.x_min"], 0] = fixed[mesh.node_sets["b.x_max"], 0] = True
    for side in "ab":
        fixed[mesh.node_sets[f"{side}.y_min"], 1] = fixed[mesh.node_sets[f"{side}.z_min"], 2] = True
    body = Body(mesh, engine.Material(engine.Isotropic(E, NU), DENSITY), fixed)
    surfaces = [np.asarray(mesh.surfaces[name]) for name in ("a.x_max", "b.x_min")]
    contact = engine.Contact(
        airway=air_between(x, *surfaces),
        enforcement=engine.Multipliers(),
        tolerance=1e-3 * STRAIN,
        faces=engine.Mortar(*surfaces) if mortar else engine.AtNodes(),
    )
    moved = np.zeros(x.shape)
    moved[mesh.node_sets["b.x_max"], 0] = -2 * STRAIN
    found = at_rest(body, contact, displacement=moved)
    exact = STRAIN * np.stack([-(x[:, 0] + 1), NU * x[:, 1], NU * x[:, 2]], axis=1)
    K = body.whole(body.assembly.stiffness())
    off = (found.displacement - exact).ravel()
    force = np.asarray(found.contact_force)[mesh.node_sets["a.x_max"], 0]
    pressure = np.asarray(found.contact_pressure)[np.unique(surfaces[0])]
    because = "the forces act at the feet of the last pass: the size of the strain, 1e-6"
    yield zero(
        name="stress",
        quantity="error of the stress in the energy norm, over the uniform stress",
        value=float(np.sqrt(off @ (K @ off) / (exact.ravel() @ (K @ exact.ravel())))),
        tolerance=STRAIN,
        because=because,
    )
    yield Check(
        name="force",
        quantity="sum of the contact forces",
        unit="N",
        value=float(-force.sum()),
        reference=STRAIN * E,
        tolerance=STRAIN,
        because=because,
    )
    value, reference = worst(pressure, np.full(len(pressure), STRAIN * E))
    yield Check(
        name="pressure",
        quantity="contact pressure at the node that is furthest off",
        unit="Pa",
        value=value,
        reference=reference,
        tolerance=STRAIN,
        because="the size of the strain: the area has swollen by twice Poisson's ratio of it",
    )


def graded(step: float, even_to: float, end: float, growth: float) -> Array:
    """Places from 0 to `end`, a step apart to `even_to` and growing beyond."""
    even = step * np.arange(np.ceil(even_to / step - 1e-9) + 1)
    places = [float(even[-1])]
    while places[-1] < end:
        step *= growth
        places.append(places[-1] + step)
    stretch = (end - even[-1]) / (places[-1] - even[-1])
    return np.concatenate([even, even[-1] + stretch * (np.array(places[1:]) - even[-1])])


def half_cylinder(step: float) -> engine.TetMesh:
    """A block on x > 0, one cell thick, whose face "x_min" is round and touches x = 0 at the origin."""
    end = 24 * WIDTH
    places = (graded(step, 0.5 * WIDTH, end, 1.4), graded(step, 1.5 * WIDTH, end, 1.4), np.array([0.0, step]))
    counts = tuple(len(p) - 1 for p in places)
    block = engine.block_mesh(size=counts, divisions=counts)
    points = np.stack(
        [p[np.rint(x).astype(int)] for p, x in zip(places, block.points.T, strict=True)], axis=1
    )
    mesh = engine.to_quadratic(changed_mesh(block, points=points))
    points = np.array(mesh.points)
    y, rim = points[:, 1], 0.6 * RADIUS  # straight beyond
    slope = rim / sqrt(RADIUS**2 - rim**2)
    height = RADIUS - np.sqrt(RADIUS**2 - np.minimum(y, rim) ** 2) + slope * np.maximum(y - rim, 0)
    points[:, 0] += height * (1 - points[:, 0] / end)
    return changed_mesh(mesh, points=points)


def hertz() -> Iterator[Check]:
    """Half a cylinder in plane strain, pressed on a rigid plane; mortar faces of quadratic tetrahedra."""
    step = WIDTH / EDGES
    plate = engine.to_quadratic(
        engine.block_mesh(corner=(-0.2, -0.2, -0.2), size=(0.2, 3, 3), divisions=(1, 3, 3))
    )
    mesh = engine.combine(plate, half_cylinder(step), "a.", "b.")
    x, sets = np.asarray(mesh.points), mesh.node_sets
    fixed, moved = np.zeros(x.shape, bool), np.zeros(x.shape)
    fixed[sets["b.y_min"], 1] = fixed[:, 2] = True
    fixed[sets["b.x_max"]] = fixed[: len(plate.points)] = True
    moved[sets["b.x_max"], 0] = -1.9 * WIDTH**2 / RADIUS
    surfaces = [np.asarray(mesh.surfaces[name]) for name in ("a.x_max", "b.x_min")]
    contact = engine.Contact(
        airway=air_between(x, *surfaces), enforcement=engine.Multipliers(), faces=engine.Mortar(*surfaces)
    )
    body = Body(mesh, engine.Material(engine.Isotropic(HERTZ_E, NU), 1000.0), fixed)
    found = at_rest(body, contact, displacement=moved)
    upper = np.unique(surfaces[1])
    y, force = (x + found.displacement)[upper, 1], np.asarray(found.contact_force)[upper, 0]
    per_length, stiffness = 2 * force.sum() / step, HERTZ_E / (1 - NU**2)
    half_width = sqrt(4 * per_length * RADIUS / (pi * stiffness))
    yield Check(
        name="half-width",
        quantity="half the width of the contact, 2 sqrt(second moment of the forces)",
        unit="m",
        value=2 * sqrt(float(force @ y**2 / force.sum())),
        reference=half_width,
        tolerance=half_width / RADIUS,
        because="Hertz's theory is the limit of b / R = 0",
    )
    yield Check(
        name="pressure",
        quantity="largest contact pressure",
        unit="Pa",
        value=float(np.asarray(found.contact_pressure)[upper].max()),
        reference=sqrt(per_length * stiffness / (pi * RADIUS)),
        tolerance=half_width / RADIUS,
        because="Hertz's theory is the limit of b / R = 0",
    )


PATCHES = {
    "matched": ("Uniform pressure passes through an interface of matched linear meshes.", (1, 2, 2, False)),
    "linear": (
        "Uniform pressure passes through an interface of linear meshes that do not match.",
        (1, 2, 3, False),
    ),
    "mortar": (
        "Uniform pressure passes through mortar faces of quadratic meshes that do not match.",
        (2, 2, 3, True),
    ),
}

CASES = (
    *(
        Case(
            f"contact-patch-{name}",
            proves,
            "contact patch test R9: the uniform stress",
            partial(patch, *parts),
        )
        for name, (proves, parts) in PATCHES.items()
    ),
    Case(
        "hertz",
        "A cylinder on a rigid plane has the contact width and the pressure that Hertz found.",
        "R4: b = sqrt(4 F' R / (pi E*)), p_0 = sqrt(F' E* / (pi R)), at the force found",
        hertz,
    ),
)
