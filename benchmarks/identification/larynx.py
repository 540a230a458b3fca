"""What one estimate in the larynx takes: `python -m benchmarks.identification.estimates larynx`."""

from __future__ import annotations

import argparse
import resource
import time
from collections.abc import Iterator

import numpy as np

import plica
from benchmarks.harness.study import record
from benchmarks.identification.block import (
    FLOW_SD,
    FRAME_RATE,
    GAIN_SD,
    PRESSURE_SD,
    SEVEN,
    STEP,
    TISSUE,
    drive,
    parameters,
)
from plica import _engine
from plica.identify import (
    Forcing,
    MarginalLikelihood,
    MotionModel,
    Observation,
    SurfacePoints,
    estimate,
    posterior_table,
    posterior_warnings,
)

LARYNX_CAMERA = plica.Camera(mm_per_px=0.05)


class LarynxBench:
    """One mesh of the larynx, and its points seen from above."""

    def __init__(self, preset: str, size: float | None, frames: int, amplitude: float) -> None:
        options = {} if size is None else {"options": {"size": size}}
        self.scene = plica.Scene(
            plica.Larynx(larynx=preset, order=2, **options),
            {name: plica.Tissue(**fields) for name, fields in TISSUE.items()},
            time=plica.Stepping(step=STEP, duration=STEP),
        )
        self.frames, self.mesh = frames, plica.build_mesh(self.scene.mesh)
        self.patterns = Forcing.on_surface(self.mesh, "airway", [-4.5e-3, -3.1e-3, -1.5e-3, 0.3e-3])[:, 1:3]
        steps = frames * round(1 / (FRAME_RATE * STEP))
        self.waves = drive(STEP * (np.arange(steps) + 0.7), amplitude)

    @property
    def unknowns(self) -> int:
        """Free ones: the wall is held."""
        return 3 * (len(np.asarray(self.mesh.points)) - len(self.mesh.node_sets["wall"]))

    def image(self) -> np.ndarray:
        """(r, 2) px, column and row: some 80 nodes of the surface about the glottis."""
        x, faces = np.asarray(self.mesh.points), np.asarray(self.mesh.surfaces["airway"])
        centres = x[faces[:, :3]].mean(axis=1)
        upward = np.cross(*np.moveaxis(x[faces[:, 1:3]] - x[faces[:, :1]], 1, 0))[:, 2] > 0
        near = upward & (np.abs(centres[:, 0]) < 3.5e-3) & (np.abs(centres[:, 1]) < 6e-3)
        nodes = np.unique(faces[near])
        return LARYNX_CAMERA.project(x[nodes[:: max(1, len(nodes) // 80)]])[:, :2]

    def shows(self, image: np.ndarray) -> np.ndarray:
        """(r) Which points of the picture (r, 2) this mesh's surface is seen at."""
        return SurfacePoints.met(self.mesh, "airway", LARYNX_CAMERA, image)[1]

    def model(self, image: np.ndarray, flow: np.ndarray) -> MotionModel:
        """Of the flow (N, r, 2) at these points of the picture."""
        points = SurfacePoints.seen(self.mesh, "airway", LARYNX_CAMERA, image)
        seen = Observation(points, LARYNX_CAMERA, flow, sd=FLOW_SD, frame_rate=FRAME_RATE)
        forcing = Forcing(self.patterns, self.waves, gain_sd=GAIN_SD)
        return MotionModel(self.scene, parameters(SEVEN, np.zeros(7)), seen, forcing, mesh=self.mesh)


def larynx(arguments: argparse.Namespace) -> None:
    """Time and memory of one estimate in the larynx; with --before, of one on a coarser mesh that it starts
    from."""
    fine = LarynxBench(arguments.preset, arguments.size, arguments.frames, arguments.drive)
    presets = [LarynxBench(name, None, arguments.frames, arguments.drive) for name in arguments.before]
    columns = ["larynx", "free unknowns", "evaluations", "s so far", "s of processors", "peak memory (MB)"]
    names = [*arguments.before, arguments.preset]
    note = f"{arguments.frames} frames, seven parameters and the gain, {arguments.threads} threads."
    made = estimates(dict(zip(names, [*presets, fine], strict=True)), arguments.frames)
    record("identify-larynx", columns, made, note)


def estimates(benches: dict[str, LarynxBench], frames: int) -> Iterator[list[str]]:
    """One recording of the last mesh estimated on each, from where the mesh before ended."""
    *_, fine = benches.values()
    image = fine.image()
    image = image[np.all([bench.shows(image) for bench in benches.values()], axis=0)]
    first = fine.model(image, np.ones((frames, len(image), 2)))
    rng = np.random.default_rng(7)
    truth = first.responses(first.tissue.prior_mean, derivatives=False)
    pressures = rng.normal(0, PRESSURE_SD, (frames * 2, 1))
    moved = np.asarray(_engine.toeplitz_product(truth.lags[0], pressures)).reshape(truth.mean[0].shape)
    rows = truth.mean[0] + moved
    flow = (rows + rng.normal(0, FLOW_SD, rows.shape)).reshape(frames, -1, 2)
    start = np.append(first.tissue.prior_mean, 0.0) + rng.normal(0, 0.3, 8)
    began, busy, found = time.perf_counter(), time.process_time(), None
    for name, bench in benches.items():
        coarse, found = found, estimate(MarginalLikelihood(bench.model(image, flow)), start)
        start = found.mean
        memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
        spent = [f"{time.perf_counter() - began:.0f}", f"{time.process_time() - busy:.0f}", f"{memory:.0f}"]
        yield [name, f"{bench.unknowns:,}", str(found.iterations), *spent]
    if coarse is not None:
        found = coarse.refined_by(found)
    print(posterior_table(found), "\n".join(posterior_warnings(found)), sep="\n")
