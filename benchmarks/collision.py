"""One collision of a phonating larynx, from one state, by the step and by the mesh.

    python benchmarks/collision.py runs/half_step

The newest checkpoint of a run is advanced to its next widest opening. Displacement and velocity there are
where every row begins: for other meshes they are taken at their nodes, by the shape functions of the
run's own (quadratic) cells. So the collision that follows is the same one in all rows, which records of
long runs are not: near the threshold of phonation a small change of the orbit decides how hard the next
collision is. Columns are those of the measures: contact is above 1 % of the collision's peak force, the
mean force is impulse over duration; the largest nodal pressure of a single step, its moving mean over 0.2
ms, and the largest force over area of contact, a mean over all that touches, over 0.2 ms too. The
equivalent duration is that of an even force with the same spread in time, 2 sqrt(3) standard deviations;
it does not see faint tails.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

import plica
from plica.measures.catalogue import contact_share, pressure_window
from plica.phonation.measures.contact import collisions, moving_average
from plica.phonation.run import checkpoint
from plica.phonation.run.build import build_simulation
from plica.phonation.scene.mesh_source import build_mesh

MESHES = ("coarse", "demo", "fine")
LENGTH = 3.2e-3  # s from the widest opening: past the end of the collision
SIDES = ((0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3))  # of a tetrahedron, VTK's order


def widest_opening(directory: Path) -> tuple[Any, Any, np.ndarray, np.ndarray]:
    """Scene, mesh, displacement and velocity (n, 3) at the widest opening after the newest checkpoint."""
    scene = plica.Run.load(directory).scene
    mesh = build_mesh(scene.mesh)
    simulation = build_simulation(scene, mesh)
    held = checkpoint.newest(directory)
    if held is None:
        raise RuntimeError(f"{directory}: no checkpoint.")
    simulation.restore(dict(held.state))
    area = -1.0
    while True:
        before = simulation.displacement, simulation.velocity
        wave = simulation.advance(1)
        if wave["contact_rows"][-1] == 0 and 0 < wave["minimum_area"][-1] < area:
            return scene, mesh, *before
        area = float(wave["minimum_area"][-1])


def shape_functions(weights: np.ndarray) -> np.ndarray:
    """(k, 10) of the quadratic tetrahedron at barycentric coordinates (k, 4)."""
    corners = weights * (2 * weights - 1)
    return np.hstack([corners, *(4 * weights[:, [i]] * weights[:, [j]] for i, j in SIDES)])


def taken_over(mesh: Any, fields: list[np.ndarray], points: np.ndarray) -> list[np.ndarray]:
    """Nodal fields (n, 3) of a quadratic mesh at points (k, 3), in the cell that each is in or nearest to."""
    cells, nodes = np.asarray(mesh.cells), np.asarray(mesh.points)
    corners = nodes[cells[:, :4]]
    edges = np.linalg.inv((corners[:, 1:] - corners[:, :1]).transpose(0, 2, 1))
    _, near = cKDTree(corners.mean(axis=1)).query(points, k=min(60, len(cells)))
    local = np.einsum("knij,knj->kni", edges[near], points[:, None] - corners[near, 0])
    weights = np.concatenate([1 - local.sum(axis=2, keepdims=True), local], axis=2)
    best = weights.min(axis=2).argmax(axis=1)
    rows = np.arange(len(points))
    shape = shape_functions(np.clip(weights[rows, best], -0.2, 1.2))
    return [np.einsum("ka,kai->ki", shape, field[cells[near[rows, best]]]) for field in fields]


def run(
    scene: Any, mesh: Any, displacement: np.ndarray, velocity: np.ndarray, step: float
) -> Mapping[str, Any]:
    """The collision that follows; of the scene, mesh, step and initial values are replaced."""
    simulation = build_simulation(scene.replace({"time.step": step}), mesh, displacement, velocity)
    start = time.perf_counter()
    wave = simulation.advance(round(LENGTH / step))
    seconds = time.perf_counter() - start
    force = np.linalg.norm(wave["contact_force_first"], axis=1)
    found = collisions(wave["time"], force, contact_share * float(force.max()), 0.9e-3)
    if len(found) != 1:
        raise RuntimeError(f"{len(found)} complete collisions; must be one.")
    part = found[0]
    impulse = force[part].sum() * step
    duration = (part.stop - part.start) * step
    count = max(round(pressure_window / step), 1)
    t = np.asarray(wave["time"])
    centre = (t * force).sum() / force.sum()
    spread = 2 * np.sqrt(3 * (((t - centre) ** 2) * force).sum() / force.sum())
    mean_pressure = force / np.maximum(wave["contact_area"], 1e-30)
    return {
        "start": wave["time"][part.start],
        "impulse": impulse,
        "duration": duration,
        "force": impulse / duration,
        "equivalent": spread,
        "even force": impulse / spread,
        "peak": wave["largest_contact_pressure"].max(),
        "averaged": moving_average(np.asarray(wave["largest_contact_pressure"]), count).max(),
        "spread": moving_average(mean_pressure, count).max(),
        "peak force": force.max(),
        "area": wave["contact_area"].max(),
        "gap": wave["deepest_gap"].min(),
        "ledger": np.abs(wave["ledger_error"]).max()
        / (wave["kinetic_energy"] + wave["elastic_energy"]).max(),
        "seconds": seconds,
    }


def table(title: str, names: list[str], found: list[Mapping[str, Any]]) -> None:
    columns = (
        ("impulse", "impulse (uN s)", 1e6, 3),
        ("duration", "duration (ms)", 1e3, 3),
        ("force", "mean force (mN)", 1e3, 3),
        ("equivalent", "equivalent duration (ms)", 1e3, 3),
        ("even force", "impulse / that (mN)", 1e3, 2),
        ("peak force", "peak force (mN)", 1e3, 2),
        ("area", "largest area (mm2)", 1e6, 2),
        ("spread", "force / area, 0.2 ms (kPa)", 1e-3, 3),
        ("averaged", "peak pressure, 0.2 ms (kPa)", 1e-3, 3),
        ("peak", "peak pressure, one step (kPa)", 1e-3, 2),
    )
    print(f"\n| {title} | " + " | ".join(head for _, head, *_ in columns) + " |")
    print("|" + " --- |" * (len(columns) + 1))
    before = None
    for name, row in zip(names, found, strict=True):
        cells = []
        for key, _, factor, digits in columns:
            text = f"{factor * row[key]:.{digits}f}"
            cells.append(text if before is None else f"{text} ({100 * (row[key] / before[key] - 1):+.1f} %)")
        print(f"| {name} | " + " | ".join(cells) + " |", flush=True)
        before = row


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("run", type=Path, help="directory of a run of a quadratic larynx")
    parser.add_argument("--steps", default="100,50,25,12.5,6.25", help="us")
    parser.add_argument("--mesh-steps", default="50,25", help="us, at which the other meshes are run")
    options = parser.parse_args()
    scene, mesh, displacement, velocity = widest_opening(options.run)
    steps = [float(step) for step in filter(None, options.steps.split(","))]
    if steps:
        rows = []
        for step in steps:
            rows.append(run(scene, mesh, displacement, velocity, 1e-6 * step))
            print(f"# step {step:g} us: {rows[-1]}", flush=True)
        table("step (us)", [f"{step:g}" for step in steps], rows)
    for step in (float(step) for step in filter(None, options.mesh_steps.split(","))):
        rows, names = [], []
        for name in MESHES:
            other = scene.replace({"mesh": {"larynx": name, "order": 2}})
            built = build_mesh(other.mesh)
            u, v = taken_over(mesh, [displacement, velocity], np.asarray(built.points))
            rows.append(run(other, built, u, v, 1e-6 * step))
            names.append(f"{name}, {len(np.asarray(built.cells))} cells")
            print(f"# {name}, step {step:g} us: {rows[-1]}", flush=True)
        table(f"mesh, step {step:g} us", names, rows)


if __name__ == "__main__":
    main()
