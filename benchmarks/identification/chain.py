"""From a run to its tissue, link by link: what film and flow cost an estimate.

    python -m benchmarks.identification.chain --seeds 1 2 3           # three draws, each with its own film
    python -m benchmarks.identification.chain --seeds 1 --whole       # whole estimates, no first-order model
    python -m benchmarks.identification.chain --seeds 11 --colliding  # folds that touch
    python -m benchmarks.identification.chain --keep DIR              # films and analyses kept, used again

Folds of the coarse larynx are moved from rest by known pressures and by small unknown ones, filmed from
above, and the film is analysed by plica's video tools, with each of some presets of the flow. Tissue is
identified from (1) the true displacement of points, (2) the film's true flow, both with white noise as large
as the error of the flow found by the first preset, (3) the flow found, its error taken for white, (4) the
flow found, its error learned from the residuals (`plica.identify.estimate_from_flow`). Truth tells the error.
The model's responses are those at the truth and their first derivatives there, so that a draw costs no sweep;
`--whole` shows what that is worth.
"""

from __future__ import annotations

import argparse
import copy
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy import ndimage

import plica
from benchmarks.harness.study import record, script_parser
from plica import video
from plica.films.clip import Clip
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
    estimate_from_flow,
)
from plica.identify.estimator.posterior import standard_deviations
from plica.identify.model.model import Responses
from plica.video.motion.trajectories import follow

SCENE = Path(__file__).resolve().parents[2] / "examples" / "normal_phonation.toml"
FRAME_RATE, STEPS_A_FRAME = 4000.0, 2
STEP = 1 / FRAME_RATE / STEPS_A_FRAME
CAMERA = plica.Camera(mm_per_px=0.05, width=256, height=320)  # the whole glottis, with tissue beyond its ends
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
TOUCHING = 1e-5  # m, of the skin from the middle


def scene(preset: str, order: int, contact: bool = False) -> plica.Scene:
    """The demo's tissue in another larynx, without airflow, with or without contact."""
    bare = {"airflow": None, "initial": None, "symmetry": None, "output": plica.Output()}
    if not contact:
        bare["contact"] = None
    loaded = plica.Scene.load(SCENE).replace(bare)
    mesh = plica.Larynx(larynx=preset, order=order)
    return loaded.replace({"mesh": mesh, "time": plica.Stepping(step=STEP, duration=STEP)})


def drive(frames: int, amplitude: float, mean: float = 2.0) -> np.ndarray:
    """(steps, 2) Pa, at t + (1 + alpha) h of each step: a mean that opens the glottis, and waves of 110 and
    250 Hz, the upper section a quarter period later."""
    times = STEP * (np.arange(frames * STEPS_A_FRAME) + 0.7)
    phase = 2 * np.pi * 110 * times
    ramp = np.minimum(times / 4e-3, 1) ** 2
    waves = [mean + np.sin(phase - lag) + 0.5 * np.sin(250 / 110 * (phase - lag)) for lag in (0, 1.6)]
    return np.asarray(amplitude * ramp[:, None] * np.column_stack(waves))


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


def gaps(moved: Moved) -> np.ndarray:
    """(N + 1) m: the least distance of a fold's skin from the plane between the folds."""
    nodes = np.unique(np.asarray(moved.mesh.surfaces["airway"]))
    x = np.asarray(moved.mesh.points)[nodes]
    inner = (np.abs(x[:, 1]) < 6e-3) & (np.abs(x[:, 0]) > 1e-6)
    now = x[inner, 0] + moved.fields["displacement"][:, nodes[inner], 0]
    return np.asarray((np.sign(x[inner, 0]) * now).min(axis=1))


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


class FirstOrder(MotionModel):
    """A model by its responses and their derivatives at one tissue."""

    def __init__(self, model: MotionModel, at: np.ndarray) -> None:
        self.__dict__.update(model.__dict__)
        self._at, self._known = at, model.responses(at)

    def of_first(self, frames: int) -> FirstOrder:
        """Of the first frames alone."""
        other = super().of_first(frames)
        assert isinstance(other, FirstOrder)
        known = self._known
        other._known = Responses(
            np.ascontiguousarray(known.mean[:, :frames]), np.ascontiguousarray(known.lags[:, :frames])
        )
        return other

    def responses(
        self, log_theta: np.ndarray, derivatives: bool = True, tilt: tuple[float, float] = (0.0, 0.0)
    ) -> Responses:
        """To first order, no farther than 1.5 in log theta."""
        off = np.clip(log_theta - self._at, -1.5, 1.5)
        mean, lags = self._known.mean.copy(), self._known.lags.copy()
        mean[0] += np.tensordot(off, mean[1:], 1)
        lags[0] += np.tensordot(off, lags[1:], 1)
        kinds = None if derivatives else 1
        return Responses(mean[:kinds], np.ascontiguousarray(lags[:kinds]))


class Estimator:
    """The mesh on which tissue is identified."""

    def __init__(self, made: plica.Scene, waves: np.ndarray, closed: np.ndarray, whole: bool) -> None:
        self.scene, self.mesh = made, plica.build_mesh(made.mesh)
        surface = patterns(self.mesh)
        x = np.asarray(self.mesh.points)[:, 1]
        middle = np.repeat(np.clip(1 - (x / np.abs(x).max()) ** 2, 0, None), 3)[:, None]
        collision = np.ascontiguousarray(surface * middle) if closed.any() else None
        self.forcing = Forcing(surface, waves, gain_sd=GAIN_SD, collision=collision)
        self.parameters, truth = [], []
        for (name, targets), off in zip(NAMED.items(), OFFSET, strict=True):
            layer, value = targets[0].split(".")
            true = float(getattr(made.tissue[layer], value))
            truth.append(np.log(true))
            self.parameters.append(TissueParameter(targets, Prior(true * np.exp(off), PRIOR_SD), name))
        self.truth = np.array([*truth, 0.0])
        self.points = SurfacePoints.seen(self.mesh, "airway", CAMERA, image_points())
        blank = np.random.default_rng(0).normal(size=(len(closed), len(image_points()), 2))
        seen = Observation(self.points, CAMERA, blank, frame_rate=FRAME_RATE, closed=closed)
        model = MotionModel(self.scene, self.parameters, seen, self.forcing, mesh=self.mesh)
        self._model = model if whole else FirstOrder(model, self.truth[:-1])

    def estimate(self, flow: np.ndarray, sd: float, learn: bool) -> tuple[Posterior, float]:
        """The posterior, and what it took (s of a processor)."""
        began = time.process_time()
        model = copy.copy(self._model)
        model.observation = replace(model.observation, flow=flow, sd=sd)
        likelihood = MarginalLikelihood(model)
        found = estimate_from_flow(likelihood)[0] if learn else estimate(likelihood)
        return found, time.process_time() - began


def line(title: str, draw: int, found: Posterior, truth: np.ndarray, seconds: float) -> list[str]:
    """Error, sd and whether the interval holds the truth; then the noise, the residual test and the time."""
    error = found.mean - truth
    cells = [
        f"{100 * e:+.1f} ({100 * s:.1f}){'' if abs(e) <= standard_deviations() * s else ' **out**'}"
        for e, s in zip(error, found.sd, strict=True)
    ]
    r = found.residuals
    scores = f"{r.in_time:+.1f} {r.in_space:+.1f} {r.tails:+.1f} {r.level:+.1f}"
    noise = f"{found.noise.flow:.2f}, {found.noise.pressure:.0f} Pa, {found.noise.gain:.2f}"
    wider = "" if found.inflation is None else f", sd times {found.inflation.max():.1f} at most"
    passed = "passed" if r.passed else "failed"
    return [title, str(draw), *cells, noise, f"{passed} ({scores}){wider}", f"{seconds:.0f}"]


def filmed(moved: Moved, directory: Path, seed: int) -> Clip:
    """The clip; in diffuse light, as shades do not move."""
    directory.mkdir(parents=True, exist_ok=True)
    clip = plica.film(moved, CAMERA, ambient=0.8, seed=seed)
    if not (directory / "clip.avi").exists():
        plica.write_film(clip, directory / "clip.avi")
    return clip


def found_by(preset: str, directory: Path, frames: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Of plica's video tools: motion (N, r, 2) px a frame of the points, missing where it is not known, what
    the trust maps say of its error (N, r) px, and which is missing."""
    settings = video.Settings(fps=FRAME_RATE, mm_per_px=CAMERA.mm_per_px, correct_drift=False, preset=preset)
    analysis = video.analyse(directory / "clip.avi", directory / preset, settings, progress=False)
    flow, places = along_paths((analysis.flow(k) for k in range(frames)), image_points())
    trips = np.array([analysis.round_trip(k) for k in range(frames)])
    # of e = u + b with errors alike and independent: a component's sd is that of e's component over sqrt(2)
    trust = at_paths(np.hypot(trips[..., 0], trips[..., 1]) / 2, places)
    unseen = ~np.isfinite(trust)
    flow[unseen] = np.nan
    return flow, trust, unseen


COLUMNS = ("noise, unknown pressure, gains of points", "residual test (time, space, tails, level)", "s")
FILMED = (
    "draw",
    "least gap (mm)",
    "closed frames",
    "motion (px a frame)",
    "error of the film's true flow (px)",
)
FOUND = ("error (px)", "motion found, of the true (median of the points)", "missing (%)", "trust too kind by")


def measure(arguments: argparse.Namespace, directory: Path) -> None:
    """All draws."""
    name = "chain" + "-colliding" * arguments.colliding + "-whole" * arguments.whole
    films: list[list[str]] = []
    preset, order = arguments.mesh
    note = (
        "Errors in %, in brackets the sd; **out**: the 95 % interval does not hold the truth. "
        f"Larynx {preset} of order {order}, {arguments.frames} frames."
    )
    columns = ["link", "draw", *NAMED, "gain", *COLUMNS]
    record(name, columns, rows(arguments, directory, films), note)
    record(f"{name}-films", [*FILMED, *[f"{p}: {what}" for p in arguments.presets for what in FOUND]], films)


def rows(arguments: argparse.Namespace, directory: Path, films: list[list[str]]) -> Iterator[list[str]]:
    """Of all draws, a row a link; cells about their films are added to `films`."""
    estimators: dict[bytes, Estimator] = {}
    for seed in arguments.seeds:
        waves = drive(arguments.frames, arguments.drive, arguments.mean)
        rng = np.random.default_rng(seed)
        unknown = np.repeat(rng.normal(0, UNKNOWN, (arguments.frames, 2)), STEPS_A_FRAME, axis=0)
        moved = run(scene(*arguments.mesh, contact=arguments.colliding), waves + unknown)
        gap = gaps(moved)
        if gap.min() <= TOUCHING and not arguments.colliding:
            raise SystemExit("chain: the folds would touch; take a smaller --drive, or --colliding.")
        touching = gap < TOUCHING
        closed = (touching[:-1] | touching[1:]) & arguments.colliding
        films.append([str(seed), f"{1e3 * gap.min():.3f}", str(closed.sum())])
        key = closed.tobytes()
        if key not in estimators:
            estimators[key] = Estimator(scene(*arguments.mesh), waves, closed, arguments.whole)
        yield from draw(arguments, estimators[key], moved, directory / f"{seed}", seed, rng, films[-1])


def draw(
    arguments: argparse.Namespace,
    estimator: Estimator,
    moved: Moved,
    directory: Path,
    seed: int,
    rng: np.random.Generator,
    film_cells: list[str],
) -> Iterator[list[str]]:
    """All links of one; cells about its film are added to `film_cells`."""
    points = estimator.points
    u = np.einsum("rk,trkc->trc", points.weights, moved.fields["displacement"][:, points.nodes])
    true = np.diff(u, axis=0) @ CAMERA.projection[:2, :3].T
    clip = filmed(moved, directory, seed)
    flows = (np.nan_to_num(clip.flow(k)[0]) for k in range(arguments.frames))
    film_flow = along_paths(flows, image_points())[0]
    film_cells += [f"{rms(np.hypot(*np.moveaxis(true, -1, 0))):.2f}", f"{rms(film_flow - true):.4f}"]
    links: list[tuple[str, np.ndarray, float, bool]] = []
    for preset in arguments.presets:
        flow, trust, unseen = found_by(preset, directory, arguments.frames)
        error = rms(flow - true)
        there = np.where(unseen[..., None], 0.0, true)
        kept = ~unseen.all(axis=0)
        share = np.median(np.nansum(flow * there, axis=(0, 2))[kept] / np.sum(there**2, axis=(0, 2))[kept])
        film_cells += [
            f"{error:.4f}",
            f"{share:.3f}",
            f"{100 * unseen.mean():.1f}",
            f"{error / rms(trust):.1f}",
        ]
        if not links:
            white = rng.normal(0, error, true.shape)  # the same in both links
            links += [
                ("true displacement, white noise", true + white, error, False),
                ("true flow of the film, the same noise", film_flow + white, error, False),
            ]
        links += [
            (f"flow found ({preset}), error taken for white", flow, error, False),
            (f"flow found ({preset}), error learned", flow, error, True),
        ]
    for title, flow, error, learn in links[arguments.links :]:
        try:
            one, seconds = estimator.estimate(flow, error, learn)
        except (plica.SolveFailed, plica.InvalidInput) as failure:
            yield [title, str(seed), *["-"] * len(estimator.truth), "", str(failure), ""]
            continue
        yield line(title, seed, one, estimator.truth, seconds)


def mesh(text: str) -> tuple[str, int]:
    """ "coarse:2" is the larynx coarse of order 2."""
    preset, _, order = text.partition(":")
    return preset, int(order)


def main() -> None:
    """Run the benchmark."""
    parser = script_parser(__doc__)
    parser.add_argument("--mesh", type=mesh, default=("coarse", 2), help="preset:order")
    parser.add_argument("--frames", type=int, default=120)
    parser.add_argument("--drive", type=float, default=200.0, help="Pa, of the known pressure")
    parser.add_argument("--mean", type=float, default=2.0, help="of it, in units of --drive")
    parser.add_argument("--seeds", type=int, nargs="+", default=[1])
    parser.add_argument("--links", type=int, default=0, help="the first that is estimated")
    parser.add_argument("--whole", action="store_true", help="whole estimates, a sweep each iteration")
    parser.add_argument("--colliding", action="store_true", help="with contact; closed frames are given")
    parser.add_argument("--presets", nargs="+", default=["robust", "video"], help="of the flow that is found")
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
