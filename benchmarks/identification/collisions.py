"""What collisions cost an estimate.

    python -m benchmarks.identification.estimates collisions --draws 20 --frames 60

In some frames a force of some 800 Pa, of which nothing is known, pushes on the upper half of the block's
medial face. Whole estimates know of these frames, or not. Unknown pressures act on both halves of the
face, so that they can take the blame, or on the lower one alone.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator

import numpy as np

from benchmarks.harness.study import record
from benchmarks.identification.block import (
    FLOW_SD,
    FRAME_RATE,
    GAIN_SD,
    PRESSURE_SD,
    STEP,
    Bench,
    drive,
    parameters,
    statistics,
    true_log,
)
from benchmarks.identification.calibration import NAMES, NUMBERS, SMALL
from plica import _engine
from plica.identify import Forcing, MarginalLikelihood, MotionModel, Observation, Responses, estimate

COLLISION = 800.0  # Pa
OFFSET_SD = 0.3  # of the prior's medians
PLACES = {"on all of the face": (1.0, 1.0), "on the lower half": (1.0, 0.0)}


def collisions(arguments: argparse.Namespace) -> None:
    """Errors and coverage with closed frames known, and without."""
    columns = ["unknown pressures", "closed frames", "", *NUMBERS, "95 % covers", "their level (Pa)"]
    note = f"{arguments.draws} draws, {arguments.frames} frames, of which {_closed(arguments).sum()} closed."
    record("identify-collisions", columns, _rows(arguments), note)


def _closed(arguments: argparse.Namespace) -> np.ndarray:
    return np.arange(arguments.frames) % 18 >= 14


def _rows(arguments: argparse.Namespace) -> Iterator[list[str]]:
    bench, frames, closed = Bench(SMALL, STEP, arguments.frames), arguments.frames, _closed(arguments)
    truth = true_log(NAMES)
    for place, noise in PLACES.items():
        blank = np.ones((frames, len(bench.points.nodes), 2))
        seen = _model(bench, blank, np.zeros(len(truth)), noise, closed, arguments.drive)
        responses = seen.responses(truth[:-1], derivatives=False)
        for closed_known in (True, False):
            found, pressures = [], []
            for draw in range(arguments.draws):
                rng = np.random.default_rng(6000 + draw)
                flow = _recording(responses, rng, np.array(noise), closed)
                offset = rng.normal(0, OFFSET_SD, len(truth))
                model = _model(bench, flow, offset, noise, closed if closed_known else None, arguments.drive)
                posterior = estimate(MarginalLikelihood(model))
                found.append((posterior.mean - truth, posterior.covariance))
                pressures.append(posterior.noise.pressure)
            made = statistics(found)
            last = [f"{made['coverage']:.0f} %", f"{np.median(pressures):.0f}"]
            for what in ("bias %", "rms %", "sd %"):
                cells = [f"{value:.1f}" for value in made[what]]
                yield [place, "told" if closed_known else "not told", what, *cells, *last]


def _model(
    bench: Bench,
    flow: np.ndarray,
    offset: np.ndarray,
    noise: tuple[float, float],
    closed: np.ndarray | None,
    amplitude: float,
) -> MotionModel:
    """That sees flow (N, r, 2); forces of collision are unknown in frames that are called closed."""
    seen = Observation(bench.points, bench.camera, flow, sd=FLOW_SD, frame_rate=FRAME_RATE, closed=closed)
    steps = len(flow) * round(1 / (FRAME_RATE * STEP))
    waves = drive(STEP * (np.arange(steps) + 1 + bench.scene.time.scheme.choice.alpha), amplitude)
    pushed = None if closed is None else np.ascontiguousarray(bench.patterns[:, 1:])
    forcing = Forcing(bench.patterns, waves, noise=np.array(noise), gain_sd=GAIN_SD, collision=pushed)
    return MotionModel(bench.scene, parameters(NAMES, offset[:-1]), seen, forcing, mesh=bench.mesh)


def _recording(
    truth: Responses, rng: np.random.Generator, noise: np.ndarray, closed: np.ndarray
) -> np.ndarray:
    """Flow (N, r, 2) with new pressures, collisions and noise."""
    frames = len(closed)
    inputs = np.zeros((frames, truth.lags.shape[3]))
    inputs[:, :2] = PRESSURE_SD * noise * rng.normal(size=(frames, 2))
    inputs[closed, 2] = COLLISION * rng.uniform(0.5, 1.5, closed.sum())
    moved = np.asarray(_engine.toeplitz_product(truth.lags[0], inputs.reshape(-1, 1)))
    rows = truth.mean[0] + moved.reshape(truth.mean[0].shape)
    return (rows + rng.normal(0, FLOW_SD, rows.shape)).reshape(frames, -1, 2)
