"""One collision of a phonating larynx, from one state, by the step and by the mesh.

    python -m benchmarks.contact.collision runs/half_step

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

import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

import plica
from benchmarks.harness.study import script_parser
from benchmarks.harness.table import show
from plica.measures.run.contact import collisions, moving_average
from plica.measures.thresholds import contact_share, pressure_window
from plica.runs.build import build_simulation
from plica.scene.mesh.build import build_mesh
from plica.uncertainty import start
from plica.uncertainty.transfer import transferred

MESHES = ("coarse", "demo", "fine")
LENGTH = 3.2e-3  # s from the widest opening: past the end of the collision


def widest_opening(directory: Path) -> tuple[Any, Any, np.ndarray, np.ndarray]:
    """Scene, mesh, displacement and velocity (n, 3) at the widest opening after the newest checkpoint."""
    run = plica.Run.load(directory)
    found = start.widest_opening(run)
    if found is None:
        raise RuntimeError(f"{directory}: no checkpoint, or no opening after it.")
    return run.scene, build_mesh(run.scene.mesh), found.displacement, found.velocity


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
        "energy balance": np.abs(wave["energy_balance_error"]).max()
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
    rows, before = [], None
    for name, row in zip(names, found, strict=True):
        cells = []
        for key, _, factor, digits in columns:
            text = f"{factor * row[key]:.{digits}f}"
            cells.append(text if before is None else f"{text} ({100 * (row[key] / before[key] - 1):+.1f} %)")
        rows.append([name, *cells])
        before = row
    print()
    show([title, *(head for _, head, *_ in columns)], rows)


def main() -> None:
    parser = script_parser(__doc__)
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
            u, v = transferred(mesh, [displacement, velocity], np.asarray(built.points))
            rows.append(run(other, built, u, v, 1e-6 * step))
            names.append(f"{name}, {len(np.asarray(built.cells))} cells")
            print(f"# {name}, step {step:g} us: {rows[-1]}", flush=True)
        table(f"mesh, step {step:g} us", names, rows)


if __name__ == "__main__":
    main()
