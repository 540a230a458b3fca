"""R4, Hertz: a sphere or a cylinder on a rigid plane, and two alike whose meshes do not match.

E = 10 kPa, nu = 0.3, combined radius 1 m; a quarter of the spheres, half of the cylinders in plane strain, as
blocks with that surface, 8 and 24 contact radii wide. Exact, for the force F (per length F') found:
a = (3 F R / 4 E*)^(1/3), p0 = 3 F / (2 pi a^2); b = (4 F' R / pi E*)^(1/2), p0 = (F' E* / pi R)^(1/2).
Contact radii come from the second moment of the nodal forces, <r^2> = 2 a^2 / 5 or <y^2> = b^2 / 4.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.harness.study import record
from plica import _engine as engine
from plica.scene.mesh.changed import changed_mesh
from plica.verify.contact.airway import air_between
from plica.verify.contact.statics import graded

E, NU, RADIUS = 1e4, 0.3, 1.0
FACES = ("nodes", "mortar")
COLUMNS = (
    *("bodies", "elements", "faces", "edges in a", "unknowns", "closed", "passes", "a/R", "radius"),
    *("pressure at the centre", "largest pressure", "largest error within 0.8 a"),
)


@dataclass(frozen=True)
class Case:
    """Two bodies and their mesh."""

    shape: str  # sphere or cylinder
    pair: str  # plane: on a rigid one; alike: two whose meshes do not match
    order: int  # of the elements
    edges: float  # of cells within a contact radius
    faces: str
    width: float = 0.1  # m, contact radius aimed at


def body(case: Case, step: float, thick: float, radius: float, side: int) -> Any:
    """A block on that side (1: x > 0) of x = 0, whose face "x_min" is round and touches it at the origin."""
    a = case.width
    if case.shape == "sphere":  # no more cells than needed
        end, growth, even_deep, even_across = 8 * a, 1.7, 0.25 * a, 1.1 * a
    else:
        end, growth, even_deep, even_across = 24 * a, 1.4, 0.5 * a, 1.5 * a
    deep, across = graded(step, even_deep, end, growth), graded(step, even_across, end, growth)
    places = (deep, across, across if case.shape == "sphere" else np.array([0.0, thick]))
    counts = tuple(len(p) - 1 for p in places)
    block = engine.block_mesh(size=counts, divisions=counts)
    points = np.stack(
        [p[np.rint(x).astype(int)] for p, x in zip(places, block.points.T, strict=True)], axis=1
    )
    cells, surfaces = np.asarray(block.cells), dict(block.surfaces)
    if side < 0:
        points[:, 0] *= -1
        cells = cells[:, [0, 2, 1, 3]]
        surfaces = {name: faces[:, [0, 2, 1]] for name, faces in surfaces.items()}
    mesh = changed_mesh(block, points=points, cells=cells, surfaces=surfaces)
    if case.order == 2:
        mesh = engine.to_quadratic(mesh)
    points = np.array(mesh.points)
    r = np.hypot(points[:, 1], points[:, 2]) if case.shape == "sphere" else points[:, 1]
    rim = 0.6 * radius  # straight beyond
    slope = rim / np.sqrt(radius**2 - rim**2)
    height = radius - np.sqrt(radius**2 - np.minimum(r, rim) ** 2) + slope * np.maximum(r - rim, 0)
    points[:, 0] += side * height * (1 - np.abs(points[:, 0]) / end)
    return changed_mesh(mesh, points=points)


def plane(case: Case) -> Any:
    """A plate below x = 0, wider than what lies on it."""
    mesh = engine.block_mesh(corner=(-0.2, -0.2, -0.2), size=(0.2, 3.0, 3.0), divisions=(1, 3, 3))
    return engine.to_quadratic(mesh) if case.order == 2 else mesh


def solve(case: Case) -> dict[str, float]:
    """What a row of the table says; errors are relative to Hertz at the force found."""
    step = case.width / case.edges
    sphere, alike = case.shape == "sphere", case.pair == "alike"
    radius = 2 * RADIUS if alike else RADIUS
    lower = body(case, 1.37 * step, step, radius, -1) if alike else plane(case)
    mesh = engine.combine(lower, body(case, step, step, radius, 1), "a.", "b.")
    points, sets = np.asarray(mesh.points), mesh.node_sets
    fixed, moved = np.zeros(points.shape, bool), np.zeros(points.shape)
    for side in "ab":
        fixed[sets[f"{side}.y_min"], 1] = True
        fixed[sets[f"{side}.z_min"], 2] = True
    if not sphere:
        fixed[:, 2] = True
    fixed[sets["b.x_max"]] = True
    fixed[sets["a.x_max"] if alike else slice(len(lower.points))] = True
    moved[sets["b.x_max"], 0] = -(1.05 if sphere else 1.9) * case.width**2 / RADIUS
    surfaces = [mesh.surfaces["a.x_min" if alike else "a.x_max"], mesh.surfaces["b.x_min"]]
    contact = engine.Contact(
        airway=air_between(points, *surfaces),
        enforcement=engine.Multipliers(),
        faces=engine.Mortar(*surfaces) if case.faces == "mortar" else engine.AtNodes(),
    )
    material = engine.Material(engine.Isotropic(E, NU), density=1000.0)
    layers = np.zeros(len(mesh.cells), int)
    rest = engine.contact_equilibrium(
        mesh, [material], ["body"], layers, fixed, contact=contact, displacement=moved
    )

    upper = np.unique(surfaces[1])
    x, force = points[upper] + rest.displacement[upper], np.asarray(rest.contact_force)[upper, 0]
    r2 = x[:, 1] ** 2 + (x[:, 2] ** 2 if sphere else 0)
    stiffness = E / (1 - NU**2) / (2 if alike else 1)
    if sphere:
        total = 4 * force.sum()
        exact, found = (
            (0.75 * total * RADIUS / stiffness) ** (1 / 3),
            np.sqrt(2.5 * (force @ r2) / force.sum()),
        )
        peak = 1.5 * total / np.pi / exact**2
    else:
        total = 2 * force.sum() / step
        exact, found = np.sqrt(4 * total * RADIUS / np.pi / stiffness), 2 * np.sqrt(force @ r2 / force.sum())
        peak = np.sqrt(total * stiffness / np.pi / RADIUS)
    pressure = np.asarray(rest.contact_pressure)[upper]
    off = (pressure - peak * np.sqrt(np.maximum(0, 1 - r2 / exact**2)))[r2 < (0.8 * exact) ** 2]
    return {
        "unknowns": float((~fixed).sum()),
        "closed": float(rest.rows),
        "passes": float(rest.passes),
        "ratio": exact / RADIUS,
        "radius": found / exact - 1,
        "centre": pressure[np.argmin(r2 + x[:, 2] ** 2)] / peak - 1,
        "peak": pressure.max() / peak - 1,
        "inner pressure": np.abs(off).max() / peak,
    }


def cases(finest: float) -> list[Case]:
    """Those of the table, coarse to fine."""
    cylinders = [
        Case("cylinder", pair, order, edges, faces)
        for pair, order in (("plane", 1), ("plane", 2), ("alike", 2))
        for faces in FACES
        for edges in (1, 2, 4, 8, 16)
    ]
    spheres = [
        Case("sphere", pair, 2, edges, faces)
        for pair in ("plane", "alike")
        for faces in FACES
        for edges in ((1, 2, 4, 6) if (pair, faces) == ("plane", "mortar") else (1, 2, 3))
    ]
    smaller = [Case("cylinder", "plane", 2, edges, "mortar", width=0.025) for edges in (2, 4, 8, 16)]
    smaller += [Case("sphere", "plane", 2, edges, "mortar", width=0.025) for edges in (2, 4, 6)]
    return [case for case in cylinders + spheres + smaller if case.edges <= finest]


def rows(finest: float) -> Iterator[list[str]]:
    """A row for each case."""
    for chosen in cases(finest):
        row = solve(chosen)
        bodies = f"{chosen.shape} on a plane" if chosen.pair == "plane" else f"two {chosen.shape}s"
        elements = "linear" if chosen.order == 1 else "quadratic"
        counts = [f"{row[name]:.0f}" for name in ("unknowns", "closed", "passes")]
        errors = [f"{100 * row[name]:+.1f} %" for name in ("radius", "centre", "peak", "inner pressure")]
        yield [bodies, elements, chosen.faces, f"{chosen.edges:g}", *counts, f"{row['ratio']:.4f}", *errors]


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--finest", type=float, default=16, help="edges of cells within a contact radius")
    record("hertz", COLUMNS, rows(parser.parse_args().finest))
