"""A small block in three layers that a camera sees from above: what the tests of identification share."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

import plica
from conftest import THESIS_TISSUE
from plica import _engine
from plica.identify import Forcing, MotionModel, Observation, Prior, SurfacePoints, TissueParameter
from plica.identify.likelihood.flow_error import FlowError
from plica.verify.identification.recorded import CAMERA, SIZE, STEP
from plica.verify.identification.recorded import layered as layered_mesh


def layered_scene(**changes: Any) -> plica.Scene:
    """Held below and at both ends; its own mesh part is not used."""
    parts: dict[str, Any] = {
        "time": plica.Stepping(step=STEP, duration=STEP),
        "supports": plica.Supports(fixed=("z_min", "y_min", "y_max")),
    }
    tissue = {name: plica.Tissue(**fields) for name, fields in THESIS_TISSUE.items()}
    return plica.Scene(plica.Block(size=SIZE), tissue, **parts | changes)


def patterns(mesh: _engine.TetMesh) -> NDArray[np.float64]:
    """(3 n, 2): pressure on the lower and the upper part of the face x_max."""
    return np.ascontiguousarray(Forcing.on_surface(mesh, "x_max", [0, SIZE[2] / 2, SIZE[2]])[:, 1:])


def shown(place: NDArray[np.float64], camera: plica.Camera = CAMERA) -> NDArray[np.float64]:
    """(r, 2) px of points (r, 3) m."""
    return camera.project(place)[:, :2]


def points(mesh: _engine.TetMesh, columns: int = 3, rows: int = 4) -> SurfacePoints:
    """A grid of points of the upper face."""
    x, y = np.meshgrid(np.linspace(0.3e-3, 3.7e-3, columns), np.linspace(1e-3, 5e-3, rows))
    place = np.column_stack([x.ravel(), y.ravel(), np.full(x.size, SIZE[2])])
    return SurfacePoints.seen(mesh, "z_max", CAMERA, shown(place))


def drive(frames: int) -> NDArray[np.float64]:
    """(5 frames, 2) Pa."""
    t = STEP * (np.arange(5 * frames) + 0.7)
    return 200 * np.column_stack([np.sin(2 * np.pi * 150 * t), np.sin(2 * np.pi * 390 * t)])


def layered_model(
    parameters: list[Any],
    flow: NDArray[np.float64],
    mesh: _engine.TetMesh | None = None,
    sd: Any = 0.1,
    closed: NDArray[np.bool_] | None = None,
    seen: SurfacePoints | None = None,
    camera: plica.Camera = CAMERA,
    tilt_sd: float = 0.0,
    **forcing: Any,
) -> MotionModel:
    """A model of the block that sees flow (N, r, 2)."""
    mesh = layered_mesh() if mesh is None else mesh
    seen = points(mesh) if seen is None else seen
    observation = Observation(seen, camera, flow, sd=sd, closed=closed, tilt_sd=tilt_sd)
    given = {"drive": drive(len(flow))} | forcing
    return MotionModel(layered_scene(), parameters, observation, Forcing(patterns(mesh), **given), mesh=mesh)


def simulated(
    model: MotionModel,
    rng: np.random.Generator,
    pressure: float = 100.0,
    flow: float = 0.1,
    collision: float = 0.0,
) -> NDArray[np.float64]:
    """Flow (N, r, 2) at the model's prior medians, with pressures and noise of these standard deviations."""
    truth = model.responses(model.tissue.prior_mean, derivatives=False)
    lags = truth.lags[0]
    inputs = np.zeros((len(lags), lags.shape[2]))
    inputs[:, : len(model.forcing.noise)] = (
        pressure * model.forcing.noise * rng.normal(size=(len(lags), len(model.forcing.noise)))
    )
    closed = np.asarray(model.observation.closed)
    inputs[closed, len(model.forcing.noise) :] = collision * rng.normal(
        size=(closed.sum(), lags.shape[2] - len(model.forcing.noise))
    )
    moved = np.asarray(_engine.toeplitz_product(lags, inputs.reshape(-1, 1))).reshape(truth.mean[0].shape)
    rows = truth.mean[0] + moved + flow * rng.normal(size=moved.shape)
    return np.asarray(rows.reshape(len(lags), -1, 2))


def whole(lags: NDArray[np.float64]) -> NDArray[np.float64]:
    """The block-Toeplitz matrix (N m, N q) of lags (N, m, q)."""
    N, m, q = lags.shape
    T = np.zeros((N, m, N, q))
    for k in range(N):
        for i in range(k + 1):
            T[k, :, i] = lags[k - i]
    return T.reshape(N * m, N * q)


def one_number(log_sd: float, **changes: float) -> MotionModel:
    """Of cover.E alone."""
    named = [TissueParameter(("cover.E",), Prior(changes.get("median", 1e3), log_sd))]
    flow = simulated(layered_model(named, np.ones((10, 12, 2))), np.random.default_rng(1), pressure=5.0)
    return layered_model(named, flow)


def correlated_in_time(frames: int, seed: int) -> FlowError:
    """An error of the flow of twelve points that is correlated in time, with gains of the points."""
    rng = np.random.default_rng(seed)
    return FlowError(
        sd=rng.uniform(0.05, 0.2, 12),
        by_frame=rng.uniform(0.8, 1.2, frames),
        in_time=np.array([-0.4, 0.15]),
        share=0.0,
        length=1.0,
        neighbours=np.full((12, 3), -1),
        distances=np.ones((12, 12)),
        motion=rng.normal(size=(frames, 12, 2)),
        outliers=np.zeros((frames, 12), dtype=bool),
    )
