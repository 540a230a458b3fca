"""A small block in three layers that a camera sees from above, and its recording."""

from __future__ import annotations

from math import pi
from typing import Any

import numpy as np
from numpy.typing import NDArray

import plica
from plica import _engine
from plica.identify import Forcing, MotionModel, Observation, SurfacePoints
from plica.runs.build import build_simulation
from plica.scene.mesh.changed import changed_mesh

__all__ = ["FRAMES", "NAMES", "UNKNOWN", "layered", "motion_model", "prior", "recorded", "scene", "stepped"]

Array = NDArray[np.float64]

SIZE, STEP, SUBSTEPS = (4e-3, 6e-3, 3e-3), 50e-6, 5  # m, s, steps a frame
CAMERA = plica.Camera(mm_per_px=0.05, centre=(2e-3, 3e-3, 3e-3))
NAMES: list[Any] = ["cover.E", "ligament.mu_fibre", "cover.viscosity"]
FRAMES, NOISE, UNKNOWN = 30, 0.05, 10.0  # -, px/frame, Pa


def layered(divisions: tuple[int, int, int] = (1, 2, 3), order: int = 2) -> _engine.TetMesh:
    """Body, ligament and cover, each a third of the height of a block."""
    block = _engine.block_mesh(size=SIZE, divisions=divisions)
    points, cells = np.asarray(block.points), np.asarray(block.cells)
    layer = np.floor(3 * points[cells].mean(axis=1)[:, 2] / SIZE[2]).astype(np.int32)
    mesh = changed_mesh(block, cell_layer=layer, layer_names=["body", "ligament", "cover"])
    return _engine.to_quadratic(mesh) if order == 2 else mesh


def scene() -> plica.Scene:
    """Held below and at both ends; its own mesh part is not used."""
    return plica.Scene(
        plica.Block(size=SIZE),
        "thesis",
        time=plica.Stepping(step=STEP, duration=STEP),
        supports=plica.Supports(fixed=("z_min", "y_min", "y_max")),
        solver=plica.Solver(tolerance=1e-13),
    )


def patterns(mesh: _engine.TetMesh) -> Array:
    """(3 n, 2): pressure on the lower and the upper part of the face x_max."""
    return np.ascontiguousarray(Forcing.on_surface(mesh, "x_max", [0, SIZE[2] / 2, SIZE[2]])[:, 1:])


def drive() -> Array:
    """(5 frames, 2) Pa."""
    t = STEP * (np.arange(SUBSTEPS * FRAMES) + 0.7)
    return 200 * np.column_stack([np.sin(2 * pi * 150 * t), np.sin(2 * pi * 390 * t)])


def motion_model(mesh: _engine.TetMesh, flow: Array) -> MotionModel:
    """Of flow (N, 12, 2) px/frame at a grid of points of the upper face."""
    x, y = np.meshgrid(np.linspace(0.3e-3, 3.7e-3, 3), np.linspace(1e-3, 5e-3, 4))
    place = np.column_stack([x.ravel(), y.ravel(), np.full(x.size, SIZE[2])])
    seen = SurfacePoints.seen(mesh, "z_max", CAMERA, CAMERA.project(place)[:, :2])
    observation = Observation(seen, CAMERA, flow, sd=NOISE)
    return MotionModel(scene(), NAMES, observation, Forcing(patterns(mesh), drive=drive()), mesh=mesh)


def recorded(mesh: _engine.TetMesh, engine_flow: Array) -> MotionModel:
    """With unknown pressures and noise added to a flow, and some points lost."""
    rng = np.random.default_rng(3)
    lags = motion_model(mesh, np.ones((FRAMES, 12, 2))).responses(prior(mesh), derivatives=False).lags[0]
    unknown = UNKNOWN * rng.standard_normal((FRAMES, 2))
    moved = np.asarray(_engine.toeplitz_product(lags, unknown.reshape(-1, 1))).reshape(FRAMES, -1)
    flow = (engine_flow.reshape(FRAMES, -1) + moved + NOISE * rng.standard_normal(moved.shape)).reshape(
        FRAMES, -1, 2
    )
    flow[4], flow[6, 2:5] = np.nan, np.nan
    return motion_model(mesh, flow)


def prior(mesh: _engine.TetMesh) -> Array:
    """log theta at the scene's values."""
    return np.asarray(motion_model(mesh, np.ones((FRAMES, 12, 2))).tissue.prior_mean)


def stepped(mesh: _engine.TetMesh) -> Array:
    """(N, 24) px/frame: what the engine's own steps show at the points, frame by frame."""
    model = motion_model(mesh, np.ones((FRAMES, 12, 2)))
    simulation = build_simulation(scene(), mesh)
    unknowns, camera = model.observation.displacements()
    places, forces = [np.zeros(camera.shape[0])], patterns(mesh)
    for k, pressures in enumerate(drive()):
        simulation.set_external_force((forces @ pressures).reshape(-1, 3))
        simulation.advance(1)
        if k % SUBSTEPS == SUBSTEPS - 1:
            places.append(camera @ np.asarray(simulation.displacement).ravel()[unknowns])
    return np.diff(places, axis=0)
