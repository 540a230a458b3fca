"""From a run without collision to its tissue, link by link: what film and flow cost an estimate.

    python benchmarks/chain.py                       # all links, two meshes
    python benchmarks/chain.py --keep DIR            # film and analysis are kept, and used again

Folds of the coarse larynx are moved from rest by known pressures and by small unknown ones, filmed from
above, and the film is analysed by plica's video tools. Tissue is identified from (1) the true displacement
of points, (2) the film's true flow, both with white noise as large as the error of the flow found, (3) the
flow found, with one sd for all, (4) the same with an sd from the trust maps, (5) with a third of the points
and (6) with every other pair of frames too, since the flow's errors are correlated along both. The error of
a flow is told from its truth.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from scipy import ndimage

import plica
from plica import video
from plica.film.clip import Clip
from plica.identify import (
    Forcing,
    MarginalLikelihood,
    MotionModel,
    Observation,
    Posterior,
    Prior,
    SurfacePoints,
    TissueParameter,
    estimate,
)
from plica.video.trajectories import follow

SCENE = Path(__file__).resolve().parents[1] / "examples" / "normal_phonation.toml"
FRAME_RATE, STEPS_A_FRAME = 4000.0, 2
STEP = 1 / FRAME_RATE / STEPS_A_FRAME
CAMERA = plica.Camera(mm_per_px=0.05, width=256, height=256)
HEIGHTS = (-4.5e-3, -3.1e-3, -1.5e-3, 0.3e-3)  # m, of the pressures' sections
NAMED = {
    "viscosity": ("cover.viscosity", "ligament.viscosity", "body.viscosity"),
    "cover.mu_fibre": ("cover.mu_fibre",),
    "body.mu_fibre": ("body.mu_fibre",),
}
OFFSET = (0.3, -0.3, 0.3)  # of the prior's medians, in log theta
PRIOR_SD, GAIN_SD = 0.7, 0.3
UNKNOWN = 10.0  # Pa, sd of the unknown pressures
GRID = (8, 9)  # points across both folds and along them
THINNED = 3  # of the points, where they are thinned


def scene(preset: str, order: int) -> plica.Scene:
    """The demo's tissue in another larynx, without airflow and contact."""
    bare = {"airflow": None, "contact": None, "initial": None, "output": plica.Output()}
    loaded = plica.Scene.load(SCENE).replace(bare)
    mesh = plica.Larynx(larynx=preset, order=order)
    return loaded.replace({"mesh": mesh, "time": plica.Stepping(step=STEP, duration=STEP)})


def drive(frames: int, amplitude: float) -> np.ndarray:
    """(steps, 2) Pa, at t + (1 + alpha) h of each step: a mean that opens the glottis, and waves of 110 and
    250 Hz, the upper section a quarter period later."""
    times = STEP * (np.arange(frames * STEPS_A_FRAME) + 0.7)
    phase = 2 * np.pi * 110 * times
    ramp = np.minimum(times / 4e-3, 1) ** 2
    waves = [2 + np.sin(phase - lag) + 0.5 * np.sin(250 / 110 * (phase - lag)) for lag in (0, 1.6)]
    return amplitude * ramp[:, None] * np.column_stack(waves)


def patterns(mesh: Any) -> np.ndarray:
    """(3 n, 2) N/Pa."""
    return np.ascontiguousarray(Forcing.on_surface(mesh, "airway", HEIGHTS)[:, 1:3])


@dataclass(frozen=True)
class Moved:
    """A run: what `plica.film` needs of one."""

    mesh: Any
    fields: dict[str, Any] = field(default_factory=dict)


def run(made: plica.Scene, pressures: np.ndarray) -> Moved:
    """The folds' motion under pressures (steps, 2), stored at every frame."""
    mesh = plica.build_mesh(made.mesh)
    loads, simulation = patterns(mesh), plica.build_simulation(made, mesh)
    stored = [np.zeros((len(np.asarray(mesh.points)), 3))]
    for k, pressure in enumerate(pressures):
        simulation.set_external_force((loads @ pressure).reshape(-1, 3))
        simulation.advance(1)
        if (k + 1) % STEPS_A_FRAME == 0:
            stored.append(np.array(simulation.displacement))
    times = np.arange(len(stored)) / FRAME_RATE
    return Moved(mesh, {"time": times, "displacement": np.array(stored)})


def least_gap(moved: Moved) -> float:
    """m: the least distance of a fold's skin from the plane between the folds; below 0 they would touch."""
    nodes = np.unique(np.asarray(moved.mesh.surfaces["airway"]))
    x = np.asarray(moved.mesh.points)[nodes]
    inner = (np.abs(x[:, 1]) < 6e-3) & (np.abs(x[:, 0]) > 1e-6)
    now = x[inner, 0] + moved.fields["displacement"][:, nodes[inner], 0]
    return float((np.sign(x[inner, 0]) * now).min())


def image_points() -> np.ndarray:
    """(r, 2) column and row, px: of the superior surface of both folds."""
    across = np.linspace(0.9e-3, 2.7e-3, GRID[0] // 2)
    x, y = np.meshgrid(np.append(-across[::-1], across), np.linspace(-4.8e-3, 4.8e-3, GRID[1]))
    return CAMERA.project(np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)]))[:, :2]


def at_paths(fields: Any, paths: np.ndarray) -> np.ndarray:
    """(N, r) values of fields (h, w), one a frame, where the points then are."""
    return np.array(
        [
            ndimage.map_coordinates(one, [p[:, 1], p[:, 0]], order=1, mode="nearest")
            for one, p in zip(fields, paths[:-1], strict=True)
        ]
    )


def along_paths(flows: Any, image: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Motion (N, r, 2) px a frame of material points carried along by flow, and their places (N + 1, r, 2)
    px."""
    places = follow(flows, image).places
    return np.diff(places, axis=0), places


def rms(values: np.ndarray) -> float:
    """Of the finite ones."""
    return float(np.sqrt(np.nanmean(np.square(values))))


class Estimator:
    """One mesh on which tissue is identified."""

    def __init__(self, made: plica.Scene, waves: np.ndarray, image: np.ndarray) -> None:
        self.scene, self.mesh = made, plica.build_mesh(made.mesh)
        self.forcing = Forcing(patterns(self.mesh), waves, gain_sd=GAIN_SD)
        self.image = image
        self.parameters, truth = [], []
        for (name, targets), off in zip(NAMED.items(), OFFSET, strict=True):
            layer, value = targets[0].split(".")
            true = float(getattr(made.tissue[layer], value))
            truth.append(np.log(true))
            self.parameters.append(TissueParameter(targets, Prior(true * np.exp(off), PRIOR_SD), name))
        self.truth = np.array([*truth, 0.0])

    @property
    def unknowns(self) -> int:
        """Displacement components, the held ones included."""
        return 3 * len(np.asarray(self.mesh.points))

    def points(self, chosen: np.ndarray) -> SurfacePoints:
        """Those of `image` that are chosen."""
        return SurfacePoints.seen(self.mesh, "airway", CAMERA, self.image[chosen])

    def estimate(
        self, flow: np.ndarray, sd: Any, chosen: np.ndarray, start: np.ndarray | None
    ) -> tuple[Posterior, float]:
        """The posterior, and what it took (s)."""
        began = time.perf_counter()
        seen = Observation(self.points(chosen), CAMERA, flow[:, chosen], sd=sd, frame_rate=FRAME_RATE)
        model = MotionModel(self.scene, self.parameters, seen, self.forcing, mesh=self.mesh)
        found = estimate(MarginalLikelihood(model), start)
        return found, time.perf_counter() - began


def line(title: str, kind: str, found: Posterior, truth: np.ndarray, seconds: float) -> None:
    """Error, sd and whether the interval holds the truth; then the residual test and the time."""
    error = found.mean - truth
    cells = [
        f"{100 * e:+.1f} ({100 * s:.1f}){'' if abs(e) <= 1.959964 * s else ' **out**'}"
        for e, s in zip(error, found.sd, strict=True)
    ]
    r = found.residuals
    scores = f"{r.in_time:+.1f} {r.in_space:+.1f} {r.tails:+.1f} {r.level:+.1f}"
    noise = f"{found.noise.flow:.2f}, {found.noise.pressure:.0f} Pa"
    passed = "passed" if r.passed else "failed"
    print(
        f"| {title} | {kind} | {' | '.join(cells)} | {noise} | {passed} ({scores}) | {seconds:.0f} |",
        flush=True,
    )


def filmed(moved: Moved, directory: Path) -> tuple[Clip, Any]:
    """The clip, and its analysis by plica's video tools; in diffuse light, as shades do not move."""
    clip = plica.film(moved, CAMERA, ambient=0.8)
    if not (directory / "clip.avi").exists():
        clip.write(directory / "clip.avi")
    settings = video.Settings(fps=FRAME_RATE, mm_per_px=CAMERA.mm_per_px, correct_drift=False)
    return clip, video.analyse(directory / "clip.avi", directory / "analysis", settings, progress=False)


def measure(arguments: argparse.Namespace, directory: Path) -> None:
    """All links."""
    made, coarser = scene(*arguments.mesh), scene(*arguments.coarser)
    waves = drive(arguments.frames, arguments.drive)
    rng = np.random.default_rng(arguments.seed)
    unknown = np.repeat(rng.normal(0, UNKNOWN, (arguments.frames, 2)), STEPS_A_FRAME, axis=0)
    began = time.perf_counter()
    moved = run(made, waves + unknown)
    gap = least_gap(moved)
    print(f"run: {time.perf_counter() - began:.0f} s, least gap of a fold from the middle {1e3 * gap:.3f} mm")
    if gap <= 0:
        raise SystemExit("chain: the folds would touch; take a smaller --drive.")
    image = image_points()
    everything = np.arange(len(image))
    estimators = [Estimator(coarser, waves, image), Estimator(made, waves, image)]
    fine = estimators[1]
    seen = fine.points(everything)
    u = np.einsum("rk,trkc->trc", seen.weights, moved.fields["displacement"][:, seen.nodes])
    true = np.diff(u, axis=0) @ CAMERA.projection[:2, :3].T
    print(f"points move by {rms(np.hypot(*np.moveaxis(true, -1, 0))):.2f} px a frame (rms)", flush=True)

    began = time.perf_counter()
    clip, analysis = filmed(moved, directory)
    print(
        f"film and plica video: {time.perf_counter() - began:.0f} s (0 s and a little where kept)", flush=True
    )
    film_flow, _ = along_paths((np.nan_to_num(clip.flow(k)[0]) for k in range(arguments.frames)), image)
    found_flow, places = along_paths((analysis.flow(k) for k in range(arguments.frames)), image)
    trips = np.array([analysis.round_trip(k) for k in range(arguments.frames)])
    # of e = u + b with errors alike and independent: a component's sd is that of e's component over sqrt(2)
    trust = at_paths(np.hypot(trips[..., 0], trips[..., 1]) / 2, places)
    unseen = ~np.isfinite(trust)
    found_flow[unseen] = np.nan
    lag = found_flow - true
    error, kind = rms(lag), rms(trust)
    floor = np.where(unseen, 1.0, np.maximum(trust, np.nanmedian(trust)))
    factor = error / rms(floor[~unseen])
    print(
        f"error at the points (rms, a component): true flow of the film {rms(film_flow - true):.5f} px, flow "
        f"found {error:.4f} px, missing {100 * unseen.mean():.1f} %; trust maps {kind:.4f} px (rms), "
        f"{np.nanmedian(trust):.4f} px (median), {error / kind:.1f} times too kind; sd of link 4: the map, "
        f"no smaller than its median, times {factor:.1f}"
    )
    square = np.nanmean(lag**2)
    grid = lag.reshape(arguments.frames, *GRID[::-1], 2)
    products = (lag[1:] * lag[:-1], grid[:, 1:] * grid[:, :-1], grid[:, :, 1:] * grid[:, :, :-1])
    frame, along, across = (np.nanmean(product) / square for product in products)
    print(
        f"correlation from a frame to the next {frame:+.2f}, to the next point along a fold {along:+.2f}, "
        f"across {across:+.2f}; regression on the true flow {np.nansum(lag * true) / np.sum(true**2):+.3f}",
        flush=True,
    )
    thinned = everything[::THINNED]
    sd4 = (factor * floor)[..., None]
    white = rng.normal(
        0, error, true.shape
    )  # the same in both links, as large as the error of the flow found
    alternate = found_flow.copy()
    alternate[1::2] = np.nan
    links = (
        ("true displacement, white noise", true + white, error, everything),
        ("true flow of the film, the same noise", film_flow + white, error, everything),
        ("flow found, one sd", found_flow, error, everything),
        ("flow found, sd of the trust maps", found_flow, sd4, everything),
        ("flow found, a third of the points", found_flow, error, thinned),
        ("the same, every other pair of frames", alternate, error, thinned),
    )
    print(f"\n{fine.unknowns} unknowns, {estimators[0].unknowns} on the coarser mesh")
    titles = " | ".join([*NAMED, "gain"])
    print(f"\n| Link | Mesh | {titles} | noise | residual test (time, space, tails, level) | s |")
    print("|---|---|" + "---|" * (len(NAMED) + 4), flush=True)
    starts: list[np.ndarray | None] = [None, None]
    for title, flow, sd, chosen in links:
        posteriors: list[Posterior | None] = [None, None]
        for k in (1, 0):
            kind = ("coarser", "same")[k]
            try:
                one, seconds = estimators[k].estimate(flow, sd, chosen, starts[k])
            except (plica.SolveFailed, plica.InvalidInput) as failure:
                print(f"| {title} | {kind} | {failure} |", flush=True)
                continue
            posteriors[k], starts[k] = one, one.mean
            line(title, kind, one, fine.truth, seconds)
        coarse, same = posteriors
        if coarse is not None and same is not None:
            line(title, "with the shift", coarse.refined_by(same), fine.truth, 0.0)


def mesh(text: str) -> tuple[str, int]:
    """ "coarse:2" is the larynx coarse of order 2."""
    preset, _, order = text.partition(":")
    return preset, int(order)


def main() -> None:
    """Run the benchmark."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--mesh", type=mesh, default=("coarse", 2), help="preset:order")
    parser.add_argument("--coarser", type=mesh, default=("coarse", 1), help="preset:order")
    parser.add_argument("--frames", type=int, default=120)
    parser.add_argument("--drive", type=float, default=200.0, help="Pa, of the known pressure")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--keep", type=Path, help="directory of film and analysis")
    arguments = parser.parse_args()
    plica.set_threads(arguments.threads)
    if arguments.keep:
        arguments.keep.mkdir(parents=True, exist_ok=True)
        measure(arguments, arguments.keep)
    else:
        with tempfile.TemporaryDirectory() as directory:
            measure(arguments, Path(directory))


if __name__ == "__main__":
    main()
