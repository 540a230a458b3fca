"""The layered block of the identification benchmarks: its tissue, what is seen of it, what drives it.

A block is seen from above by 66 points at 4000 frames/s, 20 px/mm, with 0.1 px noise in the flow. Known
pressures on its medial face, and unknown ones of 30 Pa, drive it.
"""

from __future__ import annotations

import time
from typing import Any

import numpy as np

import plica
from plica import _engine
from plica.identify import (
    Forcing,
    MarginalLikelihood,
    MotionModel,
    Observation,
    Prior,
    Responses,
    SurfacePoints,
    TissueParameter,
    TissueParameters,
)
from plica.identify.estimator.posterior import standard_deviations
from plica.runs.materials import materials_of
from plica.scene.mesh.changed import changed_mesh
from plica.scene.tissue_presets import TISSUE_PRESETS

THICKNESS = (2.2e-3, 0.9e-3, 0.9e-3)  # of body, ligament, cover
SIZE = (4e-3, 8e-3, 4e-3)
CAMERA = plica.Camera(mm_per_px=0.05, centre=(2e-3, 4e-3, 4e-3))
FRAME_RATE, STEP = 4000.0, 125e-6
FLOW_SD, PRESSURE_SD, PRIOR_SD, GAIN_SD = 0.1, 30.0, 0.7, 0.3
VISCOSITY = tuple(f"{layer}.viscosity" for layer in ("cover", "ligament", "body"))
SEVEN = (
    "cover.mu_fibre",
    "ligament.mu_fibre",
    "body.mu_fibre",
    "cover.E_fibre",
    "ligament.E_fibre",
    "body.E_fibre",
)
TISSUE: dict[str, dict[str, float]] = {
    layer: {
        name: getattr(tissue, name) for name in ("E", "nu", "E_fibre", "nu_fibre", "mu_fibre", "viscosity")
    }
    for layer, tissue in TISSUE_PRESETS["thesis_corrected"].items()
}


Triple = tuple[float, float, float]
Divisions = tuple[int, int, tuple[int, int, int]]
"""Hexahedra along x and y, and along z in body, ligament and cover."""


def layered_block(divisions: Divisions, size: Triple, thickness: Triple) -> _engine.TetMesh:
    """Quadratic tetrahedra; body, ligament and cover one above the other."""
    along_x, along_y, layers = divisions
    block = _engine.block_mesh(size=size, divisions=(along_x, along_y, sum(layers)))
    points, cells = np.array(block.points), np.asarray(block.cells)
    level = points[:, 2] / size[2] * sum(layers)
    levels = np.cumsum([0, *layers])
    points[:, 2] = np.interp(level, levels, np.cumsum([0.0, *thickness]))
    layer = np.searchsorted(levels[1:], level[cells].mean(axis=1)).astype(np.int32)
    return _engine.to_quadratic(
        changed_mesh(block, points=points, cell_layer=layer, layer_names=["body", "ligament", "cover"])
    )


def scene(step: float) -> plica.Scene:
    """The block, held laterally and at both ends; its mesh is made apart."""
    return plica.Scene(
        plica.Block(size=SIZE, order=2),
        {name: plica.Tissue(**fields) for name, fields in TISSUE.items()},
        time=plica.Stepping(step=step, duration=step),
        supports=plica.Supports(fixed=("x_min", "y_min", "y_max")),
    )


def drive(times: np.ndarray, amplitude: float) -> np.ndarray:
    """(steps, 2) Pa: 110 and 250 Hz, the upper part of the face a quarter period later."""
    ramp = np.minimum(times / 4e-3, 1) ** 2
    phase = 2 * np.pi * 110 * times
    wave = [np.sin(phase - lag) + 0.5 * np.sin(250 / 110 * (phase - lag)) for lag in (0, 1.6)]
    return amplitude * ramp[:, None] * np.column_stack(wave)


def parameters(names: tuple[str, ...], offset: np.ndarray) -> list[TissueParameter]:
    """The common viscosity and the named ones, each prior's median off the truth by exp(offset)."""
    made = []
    for targets, off in zip([VISCOSITY, *[(name,) for name in names]], offset, strict=True):
        layer, field = targets[0].split(".")
        prior = Prior(TISSUE[layer][field] * float(np.exp(off)), PRIOR_SD)
        made.append(TissueParameter(targets, prior, "viscosity" if len(targets) > 1 else targets[0]))
    return made


COARSE: Divisions = (4, 5, (2, 1, 1))
FINE: Divisions = (8, 10, (4, 2, 2))
TRUTH: Divisions = (12, 15, (6, 3, 3))


class Bench:
    """One mesh and step of the block, and what is seen of it."""

    def __init__(
        self,
        divisions: Divisions,
        step: float,
        frames: int,
        size: Triple = SIZE,
        thickness: Triple = THICKNESS,
    ) -> None:
        self.mesh, self.scene, self.frames = layered_block(divisions, size, thickness), scene(step), frames
        self.camera, self.modulation = CAMERA, 0.0
        x, y = np.meshgrid(np.linspace(0.5e-3, 3.7e-3, 6), np.linspace(0.7e-3, 7.3e-3, 11))
        top = SIZE[2]
        shown = CAMERA.project(np.column_stack([x.ravel(), y.ravel(), np.full(x.size, top)]))[:, :2]
        self.points = SurfacePoints.seen(self.mesh, "z_max", CAMERA, shown)
        self.patterns = Forcing.on_surface(self.mesh, "x_max", [0, top / 2, top])[:, 1:]

    @property
    def unknowns(self) -> int:
        """Displacement components, the held ones included."""
        return 3 * len(np.asarray(self.mesh.points))

    def model(self, named: list[TissueParameter], flow: np.ndarray, amplitude: float) -> MotionModel:
        """Of the flow (N, r, 2)."""
        seen = Observation(self.points, self.camera, flow, sd=FLOW_SD, frame_rate=FRAME_RATE)
        step = self.scene.time.step
        steps = self.frames * round(1 / (FRAME_RATE * step))
        times = step * (np.arange(steps) + 1 + self.scene.time.scheme.choice.alpha)
        waves = drive(times, amplitude) * (1 + self.modulation * np.sin(2 * np.pi * 37 * times))[:, None]
        forcing = Forcing(self.patterns, waves, gain_sd=GAIN_SD)
        return MotionModel(self.scene, named, seen, forcing, mesh=self.mesh)

    def recording(self, truth: Any, rng: np.random.Generator, gain: float = 1.0) -> np.ndarray:
        """Flow (N, r, 2) with new pressures and noise, the known pressures times a gain."""
        lags = truth.lags[0]
        pressures = rng.normal(0, PRESSURE_SD, (self.frames * lags.shape[2], 1))
        moved = np.asarray(_engine.toeplitz_product(lags, pressures)).reshape(truth.mean[0].shape)
        rows = gain * truth.mean[0] + moved + rng.normal(0, FLOW_SD, moved.shape)
        return rows.reshape(self.frames, -1, 2)


def true_log(names: tuple[str, ...]) -> np.ndarray:
    """log theta of the block, with that of the gain, 0, at the end."""
    fields = [VISCOSITY[0], *names]
    return np.append(np.log([TISSUE[f.split(".")[0]][f.split(".")[1]] for f in fields]), 0.0)


def statistics(found: list[tuple[np.ndarray, np.ndarray]]) -> dict[str, Any]:
    """Of errors (p) of log theta and their covariance (p, p), draw by draw: per cent a number, (p), and the
    per cent of all nominal 95 % intervals that hold the truth."""
    error, sd = errors(found)
    covered = np.abs(error) <= standard_deviations() * sd
    return {
        "bias %": 100 * error.mean(axis=0),
        "rms %": 100 * np.sqrt(np.mean(error**2, axis=0)),
        "sd %": 100 * np.median(sd, axis=0),
        "95 % covers": 100 * covered.mean(axis=0),
        "coverage": 100 * float(covered.mean()),
    }


def statistics_rows(found: list[tuple[np.ndarray, np.ndarray]]) -> list[list[str]]:
    """A row each of bias, rms, sd and coverage; in the last column the coverage of all numbers."""
    made = statistics(found)
    rows = [[what, *[f"{v:.1f}" for v in made[what]], ""] for what in ("bias %", "rms %", "sd %")]
    covers = [f"{v:.0f} %" for v in made["95 % covers"]]
    return [*rows, ["95 % covers", *covers, f"{made['coverage']:.1f} %"]]


def offsets(names: tuple[str, ...], bench: Bench, rng: np.random.Generator) -> np.ndarray:
    """Of the prior's medians (p), the gain's at the end; again where such a tissue would store no energy."""
    materials, layers, _ = materials_of(bench.scene, bench.mesh)
    while True:
        offset = rng.normal(0, PRIOR_SD, 1 + len(names))
        tissue = TissueParameters(materials, layers, parameters(names, offset))
        try:
            tissue.materials(tissue.prior_mean)
        except plica.InvalidInput:
            continue
        return np.append(offset, 0.0)


def errors(found: list[tuple[np.ndarray, np.ndarray]]) -> tuple[np.ndarray, np.ndarray]:
    """Errors (draws, p) and their sd."""
    return np.array([e for e, _ in found]), np.array([np.sqrt(np.diag(c)) for _, c in found])


class Study:
    """Many recordings of one tissue on one mesh: the sweep at the truth serves all of them.

    The estimate of a recording is one scoring step from the truth, with the recording's own gradient,
    information and prior: what the iteration would end at but for terms of second order, as `whole` shows
    draw by draw.
    """

    def __init__(self, bench: Bench, names: tuple[str, ...], amplitude: float) -> None:
        self.bench, self.names = bench, names
        blank = np.ones((bench.frames, len(bench.points.nodes), 2))
        self.model = bench.model(parameters(names, np.zeros(1 + len(names))), blank, amplitude)
        self.truth = true_log(names)
        began = time.perf_counter()
        self.responses = self.model.responses(self.truth[:-1])
        self.seconds = time.perf_counter() - began

    def one_step(
        self, flow: np.ndarray, offset: np.ndarray, known: Responses | None = None
    ) -> tuple[np.ndarray, np.ndarray]:
        """Error (p) of log theta and its covariance (p, p), where the prior's median is off by `offset`
        (p)."""
        likelihood = MarginalLikelihood(self.model.seeing(flow))
        at = likelihood.evaluate_known(self.truth, known or self.responses)
        precision = np.append(np.full(len(offset) - 1, PRIOR_SD), GAIN_SD) ** -2.0
        covariance = np.linalg.inv(at.information + np.diag(precision))
        return covariance @ (at.gradient + precision * offset), covariance
