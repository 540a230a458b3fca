"""Whether identification finds the tissue: errors and coverage over draws, and what an estimate takes.

    python benchmarks/identify.py same --draws 100      # the truth on the mesh of the estimate
    python benchmarks/identify.py refined --draws 30    # no inverse crime: a finer mesh, half the step
    python benchmarks/identify.py wrong --draws 12      # what the model has wrong
    python benchmarks/identify.py larynx                # time and memory at 7,704 unknowns
    python benchmarks/identify.py larynx --preset fine --size 6.5e-4 --before coarse    # and at over 30,000

A layered block is seen from above by 66 points at 4000 frames/s, 20 px/mm, with 0.1 px noise in the flow.
Known pressures on its medial face, and unknown ones of 30 Pa, drive it. In each draw the noise is new and
the prior's median is drawn about the truth, with the prior's own spread.
"""

from __future__ import annotations

import argparse
import json
import resource
import time
from dataclasses import replace
from pathlib import Path
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
    estimate,
    residual_test,
)
from plica.phonation.run.build import materials_of

THICKNESS = (2.2e-3, 0.9e-3, 0.9e-3)  # of body, ligament, cover
SIZE = (4e-3, 8e-3, 4e-3)
CAMERA = plica.Camera(mm_per_px=0.05, centre=(2e-3, 4e-3, 4e-3))  # above the block
LARYNX_CAMERA = plica.Camera(mm_per_px=0.05)
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
TISSUE = {
    "body": {"E": 20e3, "nu": 0.45, "E_fibre": 40e3, "nu_fibre": 0.45, "mu_fibre": 30e3, "viscosity": 0.35},
    "ligament": {
        "E": 3e3,
        "nu": 0.58,
        "E_fibre": 20e3,
        "nu_fibre": 0.58,
        "mu_fibre": 40e3,
        "viscosity": 0.35,
    },
    "cover": {"E": 1e3, "nu": 0.66, "E_fibre": 10e3, "nu_fibre": 0.66, "mu_fibre": 10e3, "viscosity": 0.14},
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
        _engine.TetMesh(
            points=points,
            cells=cells,
            cell_layer=layer,
            layer_names=["body", "ligament", "cover"],
            surfaces=block.surfaces,
            node_sets=block.node_sets,
        )
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

    def recording(self, truth: Any, rng: np.random.Generator) -> np.ndarray:
        """Flow (N, r, 2) with new pressures and noise."""
        lags = truth.lags[0]
        pressures = rng.normal(0, PRESSURE_SD, (self.frames * lags.shape[2], 1))
        moved = np.asarray(_engine.toeplitz_product(lags, pressures)).reshape(truth.mean[0].shape)
        rows = truth.mean[0] + moved + rng.normal(0, FLOW_SD, moved.shape)
        return rows.reshape(self.frames, -1, 2)


def true_log(names: tuple[str, ...]) -> np.ndarray:
    """log theta of the block, with that of the gain, 0, at the end."""
    fields = [VISCOSITY[0], *names]
    return np.append(np.log([TISSUE[f.split(".")[0]][f.split(".")[1]] for f in fields]), 0.0)


def report(title: str, names: tuple[str, ...], error: np.ndarray, sd: np.ndarray) -> dict[str, Any]:
    """Print errors and coverage over the draws, (draws, p) of log theta."""
    covered = np.abs(error) <= 1.959964 * sd
    print(f"\n{title}: {len(error)} draws; nominal 95 % covers {100 * covered.mean():.1f} %")
    print(f"{'':20}{'bias %':>8}{'rms %':>8}{'sd %':>8}{'covers %':>10}")
    rows = {}
    for j, name in enumerate(names):
        bias, rms = 100 * error[:, j].mean(), 100 * np.sqrt(np.mean(error[:, j] ** 2))
        row = (bias, rms, 100 * np.median(sd[:, j]), 100 * covered[:, j].mean())
        print(f"{name:20}{row[0]:8.1f}{row[1]:8.1f}{row[2]:8.1f}{row[3]:10.0f}", flush=True)
        rows[name] = row
    return {"draws": len(error), "coverage": float(covered.mean()), "rows": rows}


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


def same(arguments: argparse.Namespace) -> dict[str, Any]:
    """The truth on the mesh of the estimate."""
    names = ("cover.E", *SEVEN)
    study = Study(Bench(COARSE, STEP, arguments.frames), names, arguments.drive)
    titles = ("viscosity", *names, "gain")
    print(
        f"{study.bench.unknowns} unknowns, {arguments.frames} frames, sweep {study.seconds:.1f} s", flush=True
    )
    found = []
    for draw in range(arguments.draws):
        rng = np.random.default_rng(1000 + draw)
        flow = study.bench.recording(study.responses, rng)
        found.append(study.one_step(flow, offsets(names, study.bench, rng)))
    out = {"one step": report("same mesh, one step from the truth", titles, *errors(found))}
    steps, whole = [], []
    for draw in range(arguments.whole):
        rng = np.random.default_rng(1000 + draw)
        flow = study.bench.recording(study.responses, rng)
        offset = offsets(names, study.bench, rng)
        model = study.bench.model(parameters(names, offset[:-1]), flow, arguments.drive)
        estimated = estimate(MarginalLikelihood(model))
        steps.append(estimated.iterations)
        whole.append((estimated.mean - study.truth, estimated.covariance))
        apart = (whole[-1][0] - found[draw][0]) / np.sqrt(np.diag(whole[-1][1]))
        print(
            f"draw {draw}: {estimated.iterations} iterations; from the one step in sd:",
            np.round(apart, 2),
            flush=True,
        )
    if whole:
        out["whole"] = report("same mesh, whole estimates", titles, *errors(whole))
    return out


def errors(found: list[tuple[np.ndarray, np.ndarray]]) -> tuple[np.ndarray, np.ndarray]:
    """Errors (draws, p) and their sd."""
    return np.array([e for e, _ in found]), np.array([np.sqrt(np.diag(c)) for _, c in found])


def refined(arguments: argparse.Namespace) -> dict[str, Any]:
    """No inverse crime: the truth on a finer mesh with half the step; two coarser meshes estimate."""
    bench = Bench(TRUTH, STEP / 2, arguments.frames)
    blank = np.ones((bench.frames, len(bench.points.nodes), 2))
    seen = bench.model(parameters(SEVEN, np.zeros(7)), blank, arguments.drive)
    truth = seen.responses(true_log(SEVEN)[:-1], derivatives=False)
    studies = [
        Study(Bench(divisions, STEP, arguments.frames), SEVEN, arguments.drive)
        for divisions in (COARSE, FINE)
    ]
    moved = np.cumsum(truth.mean[0], axis=0)
    print(
        f"truth {bench.unknowns}, estimates {', '.join(str(s.bench.unknowns) for s in studies)} unknowns; "
        f"sweeps {', '.join(f'{s.seconds:.1f} s' for s in studies)}; up to "
        f"{np.abs(truth.mean[0]).max():.2f} px a frame, {np.abs(moved).max() / 20:.3f} mm",
        flush=True,
    )
    out = {}
    for share in (1.0, 0.25):  # the mean motion is linear in the drive
        print(f"\n==== known pressure {share * arguments.drive:g} Pa")
        out[f"{share * arguments.drive:g} Pa"] = both_meshes(bench, truth, studies, share, arguments.draws)
    for draw in range(arguments.whole):
        iterated(bench, truth, studies, 0.25, arguments.drive, draw)
    return out


def iterated(
    bench: Bench, truth: Responses, studies: list[Study], share: float, drive: float, draw: int
) -> None:
    """One draw estimated to the end on both meshes, from its prior's medians, beside the one step."""
    rng = np.random.default_rng(2000 + draw)
    flow = bench.recording(Responses(share * truth.mean, truth.lags), rng)
    offset = offsets(SEVEN, studies[0].bench, rng)
    start = None
    for study in studies:
        known = Responses(share * study.responses.mean, study.responses.lags)
        step, covariance = study.one_step(flow, offset, known)
        model = study.bench.model(parameters(SEVEN, offset[:-1]), flow, share * drive)
        began = time.perf_counter()
        found = estimate(MarginalLikelihood(model), start)
        seconds, start = time.perf_counter() - began, found.mean
        sd = np.sqrt(np.diag(covariance))
        error = (found.mean - study.truth) / sd
        print(
            f"draw {draw}, {study.bench.unknowns} unknowns: {found.iterations} iterations, {seconds:.0f} s; "
            f"error in sd {np.round(error, 2)}, of the one step {np.round(step / sd, 2)}",
            flush=True,
        )


def both_meshes(
    bench: Bench, truth: Responses, studies: list[Study], share: float, draws: int
) -> dict[str, Any]:
    """Errors and coverage of two meshes and of their combination."""
    truth = Responses(share * truth.mean, truth.lags)
    responses = [Responses(share * s.responses.mean, s.responses.lags) for s in studies]
    found: list[list[tuple[np.ndarray, np.ndarray]]] = [[], [], []]
    shifts = []
    for draw in range(draws):
        rng = np.random.default_rng(2000 + draw)
        flow = bench.recording(truth, rng)
        offset = offsets(SEVEN, studies[0].bench, rng)
        for kept, study, known in zip(found, studies, responses, strict=False):
            kept.append(study.one_step(flow, offset, known))
        (coarse, _), (fine, covariance) = found[0][-1], found[1][-1]
        shift = fine - coarse
        found[2].append((fine, covariance + np.outer(shift, shift)))
        shifts.append(shift / np.sqrt(np.diag(covariance)))
    titles = ("viscosity", *SEVEN, "gain")
    shares = [f"{title} {share:+.1f}" for title, share in zip(titles, np.median(shifts, axis=0), strict=True)]
    print("median shift in sd:", ", ".join(shares))
    kinds = ("coarse mesh", "finer mesh", "finer mesh, with the mesh shift")
    return {kind: report(kind, titles, *errors(part)) for kind, part in zip(kinds, found, strict=True)}


def wrong(arguments: argparse.Namespace) -> dict[str, Any]:
    """What is wrong in the model and not known to be: the bias in sd, and whether the residuals tell."""
    named = (
        "as modelled",
        "cover 10 % thicker",
        "length + 5 %",
        "camera tilted 5 degrees",
        "drive modulated 20 %",
    )
    names = ("viscosity", *SEVEN, "gain")
    frames, x, y, z = arguments.frames, *SIZE
    study = Study(Bench(COARSE, STEP, frames), SEVEN, arguments.drive)
    true = [Bench(COARSE, STEP, frames) for _ in named]
    body, ligament, cover = THICKNESS
    true[1] = Bench(COARSE, STEP, frames, thickness=(body - 0.1 * cover, ligament, 1.1 * cover))
    true[2] = Bench(COARSE, STEP, frames, size=(x, 1.05 * y, z))
    true[3].camera = replace(CAMERA, tilt=-5.0, lean=5.0)
    true[4].modulation = 0.2
    out = {}
    for name, bench in zip(named, true, strict=True):
        responses = Study(bench, SEVEN, arguments.drive).responses
        scores, failed = [], 0
        for draw in range(arguments.draws):
            rng = np.random.default_rng(3000 + draw)
            flow = bench.recording(responses, rng)
            error, covariance = study.one_step(flow, np.zeros(len(names)))
            scores.append(error / np.sqrt(np.diag(covariance)))
            likelihood = MarginalLikelihood(study.model.seeing(flow))
            at = likelihood.evaluate_known(study.truth, study.responses)
            failed += not residual_test(likelihood, at).passed
        bias = np.mean(scores, axis=0)
        told = ", ".join(f"{n} {b:+.1f}" for n, b in zip(names, bias, strict=True))
        print(f"{name}: bias in sd {told}; residual test fails in {failed} of {arguments.draws}", flush=True)
        out[name] = {"bias": bias.tolist(), "failed": failed}
    return out


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

    def model(self, image: np.ndarray, flow: np.ndarray) -> MotionModel:
        """Of the flow (N, r, 2) at these points of the picture."""
        points = SurfacePoints.seen(self.mesh, "airway", LARYNX_CAMERA, image)
        seen = Observation(points, LARYNX_CAMERA, flow, sd=FLOW_SD, frame_rate=FRAME_RATE)
        forcing = Forcing(self.patterns, self.waves, gain_sd=GAIN_SD)
        return MotionModel(self.scene, parameters(SEVEN, np.zeros(7)), seen, forcing, mesh=self.mesh)


def larynx(arguments: argparse.Namespace) -> dict[str, Any]:
    """Time and memory of one estimate in the larynx; with --before, of one on a coarser mesh that it starts
    from."""
    fine = LarynxBench(arguments.preset, arguments.size, arguments.frames, arguments.drive)
    benches = [LarynxBench(name, None, arguments.frames, arguments.drive) for name in arguments.before] + [
        fine
    ]
    image = fine.image()
    first = fine.model(image, np.ones((arguments.frames, len(image), 2)))
    rng = np.random.default_rng(7)
    truth = first.responses(first.tissue.prior_mean, derivatives=False)
    pressures = rng.normal(0, PRESSURE_SD, (arguments.frames * 2, 1))
    rows = truth.mean[0] + np.asarray(_engine.toeplitz_product(truth.lags[0], pressures)).reshape(
        truth.mean[0].shape
    )
    flow = (rows + rng.normal(0, FLOW_SD, rows.shape)).reshape(arguments.frames, -1, 2)
    start = np.append(first.tissue.prior_mean, 0.0) + rng.normal(0, 0.3, 8)
    out: dict[str, Any] = {"meshes": []}
    began, busy = time.perf_counter(), time.process_time()
    for bench in benches:
        likelihood = MarginalLikelihood(bench.model(image, flow))
        found = estimate(
            likelihood,
            start,
            progress=lambda i: print(
                i.number, f"{i.value:.3f} {i.step:.3g} sd {time.perf_counter() - began:.1f} s", flush=True
            ),
        )
        seconds, processor = time.perf_counter() - began, time.process_time() - busy
        memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
        print(
            f"{bench.unknowns} free unknowns, {len(image)} points, {arguments.frames} frames: {seconds:.1f} "
            f"s so far, {processor:.1f} s of processors, {found.iterations} iterations, peak {memory:.0f} MB "
            f"of the process, {plica._engine.threads()} threads",
            flush=True,
        )
        out["meshes"].append(
            {
                "unknowns": bench.unknowns,
                "seconds": seconds,
                "processor": processor,
                "iterations": found.iterations,
                "peak_MB": memory,
            }
        )
        if bench is not fine:
            coarse, start = found, found.mean
    if len(benches) > 1:
        found = coarse.refined_by(found)
    print(found.table(), "\n".join(found.warnings()), sep="\n")
    return out


def main() -> None:
    """Run one of the benchmarks."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("what", choices=("same", "refined", "wrong", "larynx"))
    parser.add_argument("--draws", type=int, default=3)
    parser.add_argument("--whole", type=int, default=0, help="of them, how many are iterated to the end")
    parser.add_argument("--drive", type=float, default=800.0, help="Pa, of the known pressure")
    parser.add_argument("--frames", type=int, default=120)
    parser.add_argument("--preset", default="coarse")
    parser.add_argument("--size", type=float, help="m, of the larynx's edges instead of the preset's")
    parser.add_argument("--before", nargs="*", default=[], help="presets to start from")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("-o", "--output", type=Path)
    arguments = parser.parse_args()
    plica.set_threads(arguments.threads)
    measured = {"same": same, "refined": refined, "wrong": wrong, "larynx": larynx}[arguments.what](arguments)
    if arguments.output:
        arguments.output.write_text(json.dumps(measured, indent=1))


if __name__ == "__main__":
    main()
