"""Folds that known pressures drive, filmed from mid-vibration on: how far estimates are off.

    python -m benchmarks.identification.begin                                   # 170 Hz, four draws
    python -m benchmarks.identification.begin --frequency 110 --viscosity 3     # another motion

Known pressures at three heights, 2 and 0.6 kPa at a frequency and its double, and unknown ones of 10 Pa move
the coarse larynx with linear elements for 60 ms; of the 15 ms that follow 60 frames are seen, with 0.1 px of
noise. Whole estimates of four numbers on the mesh of the truth, from values off by 0.3 in log theta, by the
number of frames before the film in which its start is made; "none": as if at rest in the first frame.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

import plica
from benchmarks.harness.study import record, script_parser
from plica import _engine
from plica.identify import (
    Forcing,
    MarginalLikelihood,
    MotionModel,
    Observation,
    SurfacePoints,
    TissueParameter,
    estimate,
)
from plica.scene.mesh.build import build_mesh

Floats = NDArray[np.float64]
CAMERA = plica.Camera(mm_per_px=0.05, width=240, height=360)
SPACING, NOISE = 28, 0.1  # px
RATE, STEPS = 4000, 5  # frames/s, steps a frame
BEFORE, FRAMES = 240, 60  # moved unseen, seen
HEIGHTS = (-4e-3, -2e-3, 0.0)  # m
UNKNOWN = 10.0  # Pa
LAYERS = ("cover", "ligament", "body")
NAMES = (
    TissueParameter(tuple(f"{layer}.viscosity" for layer in LAYERS), name="viscosity"),
    "cover.mu_fibre",
    "body.mu_fibre",
)


class Folds:
    """The larynx, its drive, and what a camera sees of it."""

    def __init__(self, frequency: float, viscosity: float) -> None:
        larynx = plica.Larynx(larynx="coarse", order=1)
        scene = plica.Scene(
            larynx, "thesis_corrected", time=plica.Stepping(step=1 / (RATE * STEPS), duration="1 ms")
        )
        self.scene = scene.replace(
            {f"tissue.{name}.viscosity": viscosity * scene.tissue[name].viscosity for name in LAYERS}
        )
        self.mesh = build_mesh(larynx)
        t = self.scene.time.step * (np.arange((BEFORE + FRAMES) * STEPS) + 0.7)
        first, second = np.sin(2 * np.pi * frequency * t), np.sin(4 * np.pi * frequency * t + 0.7)
        self.drive = 2000 * np.outer(first, [0.5, 1, 0.3]) + 600 * np.outer(second, [1, 0.2, 0.1])

    @cached_property
    def _patterns(self) -> Floats:
        return Forcing.on_surface(self.mesh, "airway", HEIGHTS)

    @cached_property
    def _motion(self) -> tuple[SurfacePoints, Floats, Floats]:
        """Points that move, and of these mean (N, m) and lags (N, m, q) of all frames."""
        grid = np.meshgrid(*(np.arange(0.0, size, SPACING) for size in (CAMERA.width, CAMERA.height)))
        points, _ = SurfacePoints.met(self.mesh, "airway", CAMERA, np.stack(grid, -1).reshape(-1, 2))
        shape = (BEFORE + FRAMES, len(points.nodes), 2)
        model = self._model(points, np.ones(shape), self.drive)
        found = model.responses(model.tissue.prior_mean, derivatives=False)
        size = np.abs(found.mean[0].reshape(shape)[BEFORE:]).max(axis=(0, 2))
        moving = size > 0.02 * size.max()
        rows = np.repeat(moving, 2)
        points = SurfacePoints(points.nodes[moving], points.weights[moving])
        return points, found.mean[0][:, rows], np.ascontiguousarray(found.lags[0][:, rows])

    def _model(self, points: SurfacePoints, flow: Floats, drive: Floats) -> MotionModel:
        seen = Observation(points, CAMERA, flow, sd=NOISE, frame_rate=RATE)
        forcing = Forcing(self._patterns, drive, gain_sd=0.3)
        return MotionModel(self.scene, NAMES, seen, forcing, mesh=self.mesh)

    @property
    def size(self) -> float:
        """px a frame, rms of what is seen."""
        return float(np.sqrt(np.mean(self._motion[1][BEFORE:] ** 2)))

    def errors(self, seed: int, lead: int) -> tuple[Floats, Floats, bool]:
        """(4) of log theta, and sd; whether residuals pass."""
        rng = np.random.default_rng(seed)
        points, mean, lags = self._motion
        inputs = rng.normal(0, UNKNOWN, (len(mean) * len(HEIGHTS), 1))
        rows = mean + np.asarray(_engine.toeplitz_product(lags, inputs)).reshape(mean.shape)
        flow = rows[BEFORE:] + rng.normal(0, NOISE, rows[BEFORE:].shape)
        flow = np.concatenate([np.full((lead, flow.shape[1]), np.nan), flow]).reshape(lead + FRAMES, -1, 2)
        drive = self.drive[STEPS * (BEFORE - lead) :].copy()
        rise = np.arange(STEPS * lead)[:, None] / max(STEPS * lead, 1)
        drive[: STEPS * lead] = drive[STEPS * lead] * (0.5 - 0.5 * np.cos(np.pi * rise))
        likelihood = MarginalLikelihood(self._model(points, flow, drive))
        truth = likelihood.prior_mean
        found = estimate(likelihood, truth + np.append(rng.normal(0, 0.3, 3), 0.0))
        return found.mean - truth, found.sd, found.residuals.passed


def main() -> None:
    options = script_parser(__doc__)
    options.add_argument("--frequency", type=float, default=170.0, help="Hz")
    options.add_argument("--viscosity", type=float, default=1.0, help="factor")
    options.add_argument("--leads", type=int, nargs="+", default=[0, 8, 16, 20, 24, 40], help="frames")
    options.add_argument("--seeds", type=int, nargs="+", default=[31, 32, 33, 34])
    chosen = options.parse_args()
    folds = Folds(chosen.frequency, chosen.viscosity)

    def rows() -> object:
        for lead in chosen.leads:
            errors, sds, passed = map(
                np.array, zip(*(folds.errors(seed, lead) for seed in chosen.seeds), strict=True)
            )
            held = np.abs(errors) < 1.96 * sds
            size = np.sqrt(np.mean((errors / sds) ** 2, axis=0))
            yield [
                f"{lead or 'none'}",
                *(
                    f"{100 * e.mean():+.0f} ({100 * s.mean():.0f}), {z:.1f} sd"
                    for e, s, z in zip(errors.T, sds.T, size, strict=True)
                ),
                f"{held.sum()} of {held.size}",
                f"{passed.sum()} of {len(passed)}",
            ]

    record(
        f"identify-begin-{chosen.frequency:g}-{len(chosen.seeds)}",
        [
            "frames before",
            "viscosity",
            "mu' cover",
            "mu' body",
            "gain",
            "95 % hold",
            "residuals pass",
        ],
        rows(),
        f"{folds.size:.2f} px of motion a frame (rms). Mean error (mean sd) in %, rms of the error in sd.",
    )


if __name__ == "__main__":
    main()
