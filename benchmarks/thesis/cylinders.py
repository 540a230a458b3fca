"""The impact of two elastic cylinders of Paper A, Sec. 4.1 (Figs. 6 and 7), as far as it is stated.

Stated: E = 2e9 Pa, nu = 0.3, no friction, 35 m/s, 7 mm between them, contact looked for in
[0, 2.7] x [-1, 1] x [-1, 1] m with the origin at the centre of the left cylinder, forces at their extremes at
1.1 and 3 ms. Chosen here: each moves at 35 m/s; both lie along x, end to end, with their centres 2.7 m apart
and a radius of 1 m, which is what the region spans; the density is 1000 kg/m^3, with which a wave goes to the
far end and back in the 3.8 ms that the extremes suggest. Bars then press with sqrt(E density) 35 m/s.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.thesis.tissue_stress import TissueStress
from plica import _engine as engine
from plica.verify.bodies.body import Body, facing

E, NU, DENSITY = 2e9, 0.3, 1000.0
SPEED, GAP, APART, RADIUS = 35.0, 0.007, 2.7, 1.0
LENGTH = APART - GAP
DURATION = 5e-3
MIDDLES = (1.1e-3, 3e-3)
"""s, the instants of the thesis's Fig. 6b."""
LEVELS = ((6, 20e-6), (10, 20e-6), (10, 10e-6))
"""Elements across and step (s); the last is shown."""


def bar_pressure() -> float:
    """Pa, of bars without lateral motion or Poisson's ratio: half the closing speed times sqrt(E density)."""
    return float(np.sqrt(E * DENSITY) * SPEED)


def bar_duration() -> float:
    """s, a wave's way to the far end and back."""
    return float(2 * LENGTH / np.sqrt(E / DENSITY))


def momentum() -> float:
    """N s: the impulse that turns a cylinder round without loss."""
    return float(2 * SPEED * DENSITY * LENGTH * np.pi * RADIUS**2)


def rounded(mesh: Any) -> Any:
    """A box of square cross-section [-1, 1]^2 as a cylinder of radius 1; faces x_min, x_max stay flat."""
    points = np.array(mesh.points)
    y, z = points[:, 1].copy(), points[:, 2].copy()
    points[:, 1] = RADIUS * y * np.sqrt(1 - z**2 / 2)
    points[:, 2] = RADIUS * z * np.sqrt(1 - y**2 / 2)
    parts = {name: np.asarray(getattr(mesh, name)) for name in ("cells", "cell_layer", "cell_side")}
    return engine.TetMesh(
        points,
        **parts,
        layer_names=mesh.layer_names,
        surfaces={name: np.asarray(faces) for name, faces in mesh.surfaces.items()},
        node_sets={name: np.asarray(nodes) for name, nodes in mesh.node_sets.items()},
    )


@dataclass(frozen=True)
class Impact:
    """What one computation gave."""

    across: int  # elements
    step: float  # s
    unknowns: int
    time: np.ndarray  # s
    left: np.ndarray  # N, along x, on each cylinder
    right: np.ndarray
    stress: np.ndarray  # Pa, largest compressive principal stress in a cell
    outlines: np.ndarray  # (MIDDLES, k, 2) m, x and y of the surface nodes at z = 0

    @property
    def duration(self) -> float:
        touching = np.flatnonzero(self.right > 0)
        return float((touching[-1] - touching[0] + 1) * self.step)

    @property
    def impulse(self) -> float:
        return float(self.right.sum() * self.step)


@dataclass(frozen=True)
class Pair:
    """Both cylinders with that many elements across a diameter and cubes of that size along."""

    simulation: Any
    mesh: Any
    material: Any


def pair(
    across: int, step: float, scheme: Any, surface_mass: str = "kept", enforcement: Any | None = None
) -> Pair:
    along = round(across * LENGTH / (2 * RADIUS))
    shape = {"size": (LENGTH, 2.0, 2.0), "divisions": (along, across, across)}
    left = rounded(engine.block_mesh(corner=(-LENGTH / 2, -1.0, -1.0), **shape))
    right = rounded(engine.block_mesh(corner=(APART - LENGTH / 2, -1.0, -1.0), **shape))
    mesh, on_right, airway = facing(left, right)
    velocity = np.zeros((len(mesh.points), 3))
    velocity[:, 0] = np.where(on_right, -SPEED, SPEED)
    material = engine.Material(engine.Isotropic(E, NU), density=DENSITY)
    simulation = Body(mesh, material, np.zeros(velocity.shape, bool)).simulation(
        scheme=scheme,
        step=step,
        contact=engine.Contact(
            airway=airway, enforcement=enforcement or engine.Multipliers(), surface_mass=surface_mass
        ),
        velocity=velocity,
    )
    return Pair(simulation, mesh, material)


def impact(across: int, step: float) -> Impact:
    """The impact with what the figures show."""
    both = pair(across, step, engine.HilberHughesTaylor(alpha=-0.3))
    simulation, mesh, points = both.simulation, both.mesh, np.asarray(both.mesh.points)
    of_cell = np.zeros(len(mesh.cells), int)
    stress = TissueStress(points, np.asarray(mesh.cells), [both.material], of_cell)
    skin = np.unique(engine.boundary(mesh.cells)[0])
    skin = skin[np.abs(points[skin, 2]) < 1e-6]
    time, forces, largest = [], [], []
    outlines = np.zeros((len(MIDDLES), len(skin), 2))
    for _ in range(round(DURATION / step)):
        waves = simulation.advance(1)
        u = np.asarray(simulation.displacement)
        time.append(float(waves["time"][0]))
        forces.append((-waves["contact_force_first"][0, 0], waves["contact_force_second"][0, 0]))
        largest.append(-stress.least_principal(u, np.zeros_like(u)).min())
        for k, middle in enumerate(MIDDLES):
            if abs(time[-1] - middle) < 0.5 * step:
                outlines[k] = (points + u)[skin][:, :2]
    on_left, on_right = np.array(forces).T
    return Impact(across, step, points.size, np.array(time), on_left, on_right, np.array(largest), outlines)


def stored(across: int, step: float, runs: Path) -> Impact:
    """That impact, computed unless `runs` has it."""
    path = runs / f"cylinders_{across}_{1e6 * step:g}us.npz"
    if path.exists():
        with np.load(path) as found:
            return Impact(**{name: found[name][()] for name in found.files})
    made = impact(across, step)
    runs.mkdir(parents=True, exist_ok=True)
    np.savez_compressed(path, **vars(made))
    return made
