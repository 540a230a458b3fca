"""Whether identification finds the tissue: errors and coverage over draws, and what an estimate takes.

    python benchmarks/identify.py same --draws 100      # the truth on the mesh of the estimate
    python benchmarks/identify.py refined --draws 30    # no inverse crime: a finer mesh, half the step
    python benchmarks/identify.py larynx                # time and memory at 7,704 unknowns

A layered block is seen from above by 66 points at 4000 frames/s, 20 px/mm, with 0.1 px noise in the flow. Known
pressures on its medial face, and unknown ones of 30 Pa, drive it. In each draw the noise is new and the prior's median
is drawn about the truth, with the prior's own spread. Every estimate starts at its prior's median.
"""

from __future__ import annotations

import argparse
import json
import resource
import time
from pathlib import Path
from typing import Any

import numpy as np

import plica
from plica import _engine
from plica.identify import (
    Camera,
    Forcing,
    MarginalLikelihood,
    MotionModel,
    Observation,
    Posterior,
    Prior,
    Scoring,
    SurfacePoints,
    TissueParameter,
    TissueParameters,
    estimate,
)
from plica.phonation.run.build import materials_of

THICKNESS = (1.2e-3, 0.9e-3, 0.9e-3)  # of body, ligament, cover
SIZE = (4e-3, 8e-3, 3e-3)
CAMERA = Camera(pixels_per_metre=20e3)
FRAME_RATE, STEP = 4000.0, 125e-6
FLOW_SD, PRESSURE_SD, PRIOR_SD, GAIN_SD = 0.1, 30.0, 0.7, 0.3
VISCOSITY = tuple(f"{layer}.viscosity" for layer in ("cover", "ligament", "body"))
SEVEN = ("cover.mu_fibre", "ligament.mu_fibre", "body.mu_fibre", "cover.E_fibre", "ligament.E_fibre", "body.E_fibre")
TISSUE = {
    "body": {"E": 20e3, "nu": 0.45, "E_fibre": 40e3, "nu_fibre": 0.45, "mu_fibre": 30e3, "viscosity": 0.35},
    "ligament": {"E": 3e3, "nu": 0.58, "E_fibre": 20e3, "nu_fibre": 0.58, "mu_fibre": 40e3, "viscosity": 0.35},
    "cover": {"E": 1e3, "nu": 0.66, "E_fibre": 10e3, "nu_fibre": 0.66, "mu_fibre": 10e3, "viscosity": 0.14},
}


Divisions = tuple[int, int, tuple[int, int, int]]
"""Hexahedra along x and y, and along z in body, ligament and cover."""


def layered_block(divisions: Divisions) -> _engine.TetMesh:
    """Quadratic tetrahedra; body, ligament and cover one above the other."""
    along_x, along_y, layers = divisions
    block = _engine.block_mesh(size=SIZE, divisions=(along_x, along_y, sum(layers)))
    points, cells = np.array(block.points), np.asarray(block.cells)
    level = points[:, 2] / SIZE[2] * sum(layers)
    levels = np.cumsum([0, *layers])
    points[:, 2] = np.interp(level, levels, np.cumsum([0.0, *THICKNESS]))
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
    """The block, held below, laterally and at both ends; its mesh is made apart."""
    return plica.Scene(
        plica.Block(size=SIZE, order=2),
        {name: plica.Tissue(**fields) for name, fields in TISSUE.items()},
        time=plica.Stepping(step=step, duration=step),
        supports=plica.Supports(fixed=("x_min", "y_min", "y_max", "z_min")),
    )


def drive(times: np.ndarray) -> np.ndarray:
    """(steps, 2) Pa: 110 and 250 Hz, the upper part of the face a quarter period later."""
    ramp = np.minimum(times / 4e-3, 1) ** 2
    phase = 2 * np.pi * 110 * times
    wave = [np.sin(phase - lag) + 0.5 * np.sin(250 / 110 * (phase - lag)) for lag in (0, 1.6)]
    return 120 * ramp[:, None] * np.column_stack(wave)


def parameters(names: tuple[str, ...], offset: np.ndarray) -> list[TissueParameter]:
    """The common viscosity and the named ones, each prior's median off the truth by exp(offset)."""
    made = []
    for targets, off in zip([VISCOSITY, *[(name,) for name in names]], offset, strict=True):
        layer, field = targets[0].split(".")
        prior = Prior(TISSUE[layer][field] * float(np.exp(off)), PRIOR_SD)
        made.append(TissueParameter(targets, prior, "viscosity" if len(targets) > 1 else targets[0]))
    return made


COARSE: Divisions = (4, 5, (1, 1, 2))
FINE: Divisions = (6, 8, (2, 2, 3))
TRUTH: Divisions = (9, 12, (3, 3, 4))


class Bench:
    """One mesh and step of the block, and what is seen of it."""

    def __init__(self, divisions: Divisions, step: float, frames: int) -> None:
        self.mesh, self.scene, self.frames = layered_block(divisions), scene(step), frames
        x, y = np.meshgrid(np.linspace(0.5e-3, 3.7e-3, 6), np.linspace(0.7e-3, 7.3e-3, 11))
        image = np.column_stack([x.ravel(), y.ravel()])
        self.points = SurfacePoints.seen(self.mesh, "z_max", CAMERA, image)
        top = SIZE[2]
        self.patterns = Forcing.on_surface(self.mesh, "x_max", [0, top / 2, top])[:, 1:]

    @property
    def unknowns(self) -> int:
        """Displacement components, the held ones included."""
        return 3 * len(np.asarray(self.mesh.points))

    def model(self, named: list[TissueParameter], flow: np.ndarray, gain_sd: float = GAIN_SD) -> MotionModel:
        """Of the flow (N, r, 2)."""
        seen = Observation(self.points, CAMERA, flow, sd=FLOW_SD, frame_rate=FRAME_RATE)
        step = self.scene.time.step
        steps = self.frames * round(1 / (FRAME_RATE * step))
        times = step * (np.arange(steps) + 1 + self.scene.time.scheme.choice.alpha)
        forcing = Forcing(self.patterns, drive(times), gain_sd=gain_sd)
        return MotionModel(self.scene, named, seen, forcing, mesh=self.mesh)

    def truth(self) -> Any:
        """Mean and lags at the true tissue."""
        named = parameters(SEVEN, np.zeros(7))
        model = self.model(named, np.ones((self.frames, len(self.points.nodes), 2)), 0.0)
        return model.responses(model.tissue.prior_mean, derivatives=False)

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


def drawn(names: tuple[str, ...], bench: Bench, rng: np.random.Generator) -> list[TissueParameter]:
    """Parameters whose prior medians are off the truth; again where such a tissue would store no energy."""
    materials, layers, _ = materials_of(bench.scene, bench.mesh)
    while True:
        named = parameters(names, rng.normal(0, PRIOR_SD, 1 + len(names)))
        tissue = TissueParameters(materials, layers, named)
        try:
            tissue.materials(tissue.prior_mean)
        except plica.InvalidInput:
            continue
        return named


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


def same(arguments: argparse.Namespace) -> dict[str, Any]:
    """The truth on the mesh of the estimate."""
    names = ("cover.E", *SEVEN)
    bench = Bench((3, 4, (1, 1, 1)), STEP, arguments.frames)
    truth, found = bench.truth(), []
    print(f"{bench.unknowns} unknowns, {arguments.frames} frames")
    for draw in range(arguments.draws):
        rng = np.random.default_rng(1000 + draw)
        named = drawn(names, bench, rng)
        found.append(estimate(MarginalLikelihood(bench.model(named, bench.recording(truth, rng)))))
        if draw % 10 == 9:
            show_same(names, found)
    return show_same(names, found)


def show_same(names: tuple[str, ...], found: list[Posterior]) -> dict[str, Any]:
    """The table of the draws so far."""
    error = np.array([p.mean for p in found]) - true_log(names)
    print("iterations", np.bincount([p.iterations for p in found]), end="")
    return report("same mesh", found[0].names, error, np.array([p.sd for p in found]))


def refined(arguments: argparse.Namespace) -> dict[str, Any]:
    """The truth on a finer mesh with half the step; two meshes estimate."""
    truth_bench = Bench(TRUTH, STEP / 2, arguments.frames)
    coarse, fine = Bench(COARSE, STEP, arguments.frames), Bench(FINE, STEP, arguments.frames)
    print(f"truth {truth_bench.unknowns}, estimates {coarse.unknowns} and {fine.unknowns} unknowns", flush=True)
    truth = truth_bench.truth()
    found: list[tuple[Posterior, Posterior]] = []
    out: dict[str, Any] = {}
    for draw in range(arguments.draws):
        rng = np.random.default_rng(2000 + draw)
        named = drawn(SEVEN, coarse, rng)
        flow = truth_bench.recording(truth, rng)
        first = estimate(MarginalLikelihood(coarse.model(named, flow)))
        second = estimate(MarginalLikelihood(fine.model(named, flow)), first.mean, Scoring(tolerance=0.3))
        found.append((first, first.refined_by(second)))
        if draw % 3 == 2 or draw == arguments.draws - 1:
            out = show_refined(found)
        if arguments.output:
            parts = [(a.mean.tolist(), a.sd.tolist(), b.mean.tolist(), b.statistical_covariance.tolist()) for a, b in found]
            arguments.output.with_suffix(".draws.json").write_text(json.dumps(parts))
    return out


def show_refined(found: list[tuple[Posterior, Posterior]]) -> dict[str, Any]:
    """The tables of the draws so far."""
    exact, names = true_log(SEVEN), found[0][0].names
    coarse = np.array([a.mean for a, _ in found]) - exact
    fine = np.array([b.mean for _, b in found]) - exact
    alone = np.array([np.sqrt(np.diag(b.statistical_covariance)) for _, b in found])
    shift = np.median([np.abs(b.shift_in_sd) for _, b in found], axis=0)
    print("\nmedian shift in sd:", dict(zip(names, np.round(shift, 2).tolist(), strict=True)))
    return {
        "coarse": report("coarse mesh", names, coarse, np.array([a.sd for a, _ in found])),
        "fine": report("finer mesh", names, fine, alone),
        "with shift": report("finer mesh, with the shift", names, fine, np.array([b.sd for _, b in found])),
    }


def larynx(arguments: argparse.Namespace) -> dict[str, Any]:
    """Time and memory of one estimate in the larynx."""
    made = plica.Scene(
        plica.Larynx(larynx=arguments.preset, order=2),
        {name: plica.Tissue(**fields) for name, fields in TISSUE.items()},
        time=plica.Stepping(step=STEP, duration=STEP),
    )
    mesh = plica.build_mesh(made.mesh)
    x, faces = np.asarray(mesh.points), np.asarray(mesh.surfaces["airway"])
    centres = x[faces[:, :3]].mean(axis=1)
    upward = np.cross(*np.moveaxis(x[faces[:, 1:3]] - x[faces[:, :1]], 1, 0))[:, 2] > 0
    near = upward & (np.abs(centres[:, 0]) < 3.5e-3) & (np.abs(centres[:, 1]) < 6e-3)
    points = SurfacePoints.at_nodes(np.unique(faces[near])[:: max(1, len(np.unique(faces[near])) // 80)])
    patterns = Forcing.on_surface(mesh, "airway", [-4.5e-3, -3.1e-3, -1.5e-3, 0.3e-3])[:, 1:3]
    steps = arguments.frames * round(1 / (FRAME_RATE * STEP))
    waves = 1.0 * drive(STEP * (np.arange(steps) + 0.7))
    named = parameters(SEVEN, np.zeros(7))

    def model(flow: np.ndarray) -> MotionModel:
        seen = Observation(points, CAMERA, flow, sd=FLOW_SD, frame_rate=FRAME_RATE)
        return MotionModel(made, named, seen, Forcing(patterns, waves, gain_sd=GAIN_SD), mesh=mesh)

    first = model(np.ones((arguments.frames, len(points.nodes), 2)))
    rng = np.random.default_rng(7)
    truth = first.responses(first.tissue.prior_mean, derivatives=False)
    pressures = rng.normal(0, PRESSURE_SD, (arguments.frames * 2, 1))
    rows = truth.mean[0] + np.asarray(_engine.toeplitz_product(truth.lags[0], pressures)).reshape(truth.mean[0].shape)
    flow = (rows + rng.normal(0, FLOW_SD, rows.shape)).reshape(arguments.frames, -1, 2)
    likelihood = MarginalLikelihood(model(flow))
    start = likelihood.prior_mean + rng.normal(0, 0.3, 8)
    began = time.perf_counter()
    found = estimate(likelihood, start, progress=lambda i: print(i.number, f"{i.value:.3f} {i.step:.3g} sd", flush=True))
    seconds = time.perf_counter() - began
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(f"{3 * len(x)} unknowns, {len(points.nodes)} points, {arguments.frames} frames: {seconds:.1f} s, "
          f"{found.iterations} iterations, peak {memory:.0f} MB of the process, {plica._engine.threads()} threads")
    print(found.table(), "\n".join(found.warnings()), sep="\n")
    return {"unknowns": 3 * len(x), "seconds": seconds, "iterations": found.iterations, "peak_MB": memory}


def main() -> None:
    """Run one of the benchmarks."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=("same", "refined", "larynx"))
    parser.add_argument("--draws", type=int, default=3)
    parser.add_argument("--frames", type=int, default=120)
    parser.add_argument("--preset", default="coarse")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("-o", "--output", type=Path)
    arguments = parser.parse_args()
    plica.set_threads(arguments.threads)
    measured = {"same": same, "refined": refined, "larynx": larynx}[arguments.what](arguments)
    if arguments.output:
        arguments.output.write_text(json.dumps(measured, indent=1))


if __name__ == "__main__":
    main()
