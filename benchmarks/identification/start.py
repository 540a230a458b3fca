"""What viscosity the true pressures of a voice make most probable, by what is believed of its start.

    python -m benchmarks.identification.start                               # 300 Pa
    python -m benchmarks.identification.start --pressure 400 --cover 2    # another voice

Folds of the coarse larynx with linear elements vibrate by their own airflow; points of their upper surface
are seen from frame to frame. All section pressures are known at every step, and all else of the tissue; only
the state in which the film begins is not: it is made by pressures of any size at three heights in frames
before it. In the film itself such pressures of 3 Pa are allowed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import signal

import plica
from benchmarks.harness.study import record, script_parser
from benchmarks.identification.voice import voice
from plica import _engine
from plica.identify import (
    Forcing,
    MarginalLikelihood,
    MotionModel,
    Observation,
    SurfacePoints,
    TissueParameter,
)
from plica.identify.likelihood.noise_levels import Noise
from plica.runs.build import build_simulation
from plica.scene.mesh.build import build_mesh

Floats = NDArray[np.float64]
LAYERS = ("cover", "ligament", "body")
CAMERA = plica.Camera(mm_per_px=0.05, width=240, height=360)
SPACING = 28  # px between points
STEPS = 5  # of 50 us, a frame
BEFORE, FRAMES = 150, 40  # not looked at, of the film
LEADS = (8, 16, 20, 24)  # of those before the film, in which its start is made
NOISE = 0.1  # px, that is 5 um
HEIGHTS = (-4e-3, -2e-3, 0.0)  # m, of the remainder
REMAINDER = 3.0  # Pa
FACTORS = (0.7, 0.85, 1.0, 1.15, 1.3, 1.6)


@dataclass(frozen=True)
class Voice:
    """A simulated voice: displacements (steps + 1, n, 3) m, pressures (steps, s) Pa of sections at (s) m."""

    scene: plica.Scene
    mesh: _engine.TetMesh
    displacement: Floats
    pressure: Floats
    height: Floats

    @classmethod
    def simulated(cls, pressure: float, cover: float) -> Voice:
        scene = voice(pressure, cover, 1, BEFORE + FRAMES, 0.0)
        mesh = build_mesh(scene.mesh, scene.source)
        simulation = build_simulation(scene, mesh)
        seen, pressures = [simulation.displacement], []
        for step in range(STEPS * (BEFORE + FRAMES)):
            made = simulation.advance(1)
            if step >= STEPS * (BEFORE - max(LEADS)) and made["contact_rows"].any():
                raise SystemExit("the folds touch: choose a lower pressure")
            pressures.append(made["section_pressure"][0])
            seen.append(simulation.displacement)
        return cls(scene, mesh, np.array(seen), np.array(pressures), np.array(simulation.section_height))

    def tissue(self) -> plica.Scene:
        """Without airflow and contact."""
        return self.scene.replace({"airflow": None, "contact": None, "initial": None, "symmetry": None})


class DrivenModel(MotionModel):
    """A model with known pressures beside the unknown ones: patterns (3 n, k), waveforms (steps, k)."""

    known: Floats
    waves: Floats

    @property
    def patterns(self) -> Floats:
        return np.ascontiguousarray(np.hstack([super().patterns, self.known]))

    def _lags(self, seen: Floats) -> Floats:
        return super()._lags(seen[..., : -self.known.shape[1]])

    def _mean(self, seen: Floats) -> Floats:
        driven = seen[..., -self.known.shape[1] :]
        parts = (
            signal.fftconvolve(driven[..., i], wave[:, None, None], axes=0)[: len(seen)]
            for i, wave in enumerate(self.waves.T)
        )
        return np.ascontiguousarray(self._frames(sum(parts)).transpose(1, 0, 2))


class Study:
    """The end of one voice seen under its true pressures; its start is made in `lead` frames before it."""

    def __init__(self, voice: Voice, lead: int, seed: int) -> None:
        self.voice, self.lead = voice, lead
        self.first = len(voice.pressure) - STEPS * (lead + FRAMES)
        surface = voice.mesh.surfaces["airway"]
        self.load = np.asarray(_engine.pressure_patterns(voice.mesh, surface, voice.height))
        self.observation = self._observed(seed)

    def _observed(self, seed: int) -> Observation:
        grid = np.meshgrid(*(np.arange(0.0, size, SPACING) for size in (CAMERA.width, CAMERA.height)))
        pixels = np.stack(grid, -1).reshape(-1, 2)
        points, _ = SurfacePoints.met(self.voice.mesh, "airway", CAMERA, pixels)
        path = self.voice.displacement[self.first :: STEPS][:, points.nodes]
        places = np.einsum("rk,trkc->trc", points.weights, path)
        flow = np.diff(places, axis=0)[..., :2] * np.array([1, -1]) / (1e-3 * CAMERA.mm_per_px)
        flow[: self.lead] = np.nan
        moving = np.nanmax(np.abs(flow), axis=(0, 2)) > 0.02 * np.nanmax(np.abs(flow))
        flow = flow[:, moving]
        flow[self.lead :] += np.random.default_rng(seed).normal(0, NOISE, flow[self.lead :].shape)
        points = SurfacePoints(points.nodes[moving], points.weights[moving])
        rate = 1 / (STEPS * self.voice.scene.time.step)
        return Observation(points, CAMERA, flow, sd=NOISE, frame_rate=rate)

    def _waves(self) -> Floats:
        """(steps, s) Pa about their mean: flow shows no mean deflection. Before the film they rise."""
        pressure, seen = self.voice.pressure[self.first :], STEPS * self.lead
        rise = np.ones(len(pressure))
        rise[:seen] = 0.5 - 0.5 * np.cos(np.pi * np.arange(seen) / seen)
        return np.asarray((pressure - pressure[seen:].mean(axis=0)) * rise[:, None])

    def profile(self) -> Floats:
        """(f) log p at the FACTORS of viscosity."""
        targets = tuple(f"{name}.viscosity" for name in LAYERS)
        model = DrivenModel(
            self.voice.tissue(),
            [TissueParameter(targets, name="viscosity")],
            self.observation,
            Forcing(Forcing.on_surface(self.voice.mesh, "airway", HEIGHTS)),
            self.voice.mesh,
        )
        waves, size, shapes = np.linalg.svd(self._waves(), full_matrices=False)
        kept = int(np.sum(size > 1e-4 * size[0]))
        model.known, model.waves = self.load @ shapes[:kept].T, waves[:, :kept] * size[:kept]
        likelihood = MarginalLikelihood(model, Noise(REMAINDER, 1.0))
        return np.array([likelihood.value(likelihood.prior_mean + np.log(factor)) for factor in FACTORS])


def main() -> None:
    options = script_parser(__doc__)
    options.add_argument("--pressure", type=float, default=300.0, help="Pa")
    options.add_argument("--cover", type=float, default=1.5, help="factor on its moduli")
    options.add_argument("--seed", type=int, default=1)
    chosen = options.parse_args()
    voiced = Voice.simulated(chosen.pressure, chosen.cover)
    rows = []
    for lead in LEADS:
        found = Study(voiced, lead, chosen.seed).profile()
        rows.append([f"{lead}", *(f"{value - found.max():.1f}" for value in found)])
    name = f"identify-start-{chosen.pressure:g}"
    record(name, ["frames before", *(f"{factor:g}" for factor in FACTORS)], rows)


if __name__ == "__main__":
    main()
