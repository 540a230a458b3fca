"""A voice that drives itself, from run to film to tissue: how far estimates are off, in the sd they state.

    python -m benchmarks.identification.voice                              # linear elements, four pressures
    python -m benchmarks.identification.voice --pressures 700 --cover 0.8  # others
    python -m benchmarks.identification.voice --order 2 --first 60         # quadratic elements

Folds of the coarse larynx vibrate by their own airflow and are filmed from above without error. Noise is
added to the film's true flow, and `plica.identify.identify` estimates viscosity and two shear moduli on the
mesh of the truth, as if the unknown pressures did not depend on the motion (``voiced = false``).
"""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np

import plica
from benchmarks.harness.study import script_parser
from benchmarks.harness.table import show
from plica.identify import Settings, identify
from plica.storage.stored import Stored

SCENE = Path(__file__).resolve().parents[2] / "examples" / "normal_phonation.toml"
COLUMNS = (
    "Pa",
    "cover",
    "motion",
    "closed",
    "viscosity",
    "mu' cover",
    "mu' body",
    "follows",
    "residuals",
    "Gaussian",
)
CAMERA = plica.Camera(mm_per_px=0.1, width=96, height=144)
FRAME = 250e-6  # s
NOISE = 0.05  # px, that is 5 um
ESTIMATED = (
    {"targets": ("cover.viscosity", "ligament.viscosity", "body.viscosity"), "name": "viscosity"},
    "cover.mu_fibre",
    "body.mu_fibre",
)


def voice(pressure: float, cover: float, order: int, frames: int, first: float) -> plica.Scene:
    """The thesis's folds at a subglottal pressure (Pa), the cover's moduli times a factor, filmed from
    `first` (ms) on for some frames."""
    scene = plica.Scene.load(SCENE)
    tissue = {
        f"tissue.cover.{name}": cover * getattr(scene.tissue["cover"], name)
        for name in ("E", "E_fibre", "mu_fibre")
    }
    output = plica.Output(every=FRAME, start=1e-3 * first)
    parts = {"mesh": plica.Larynx(larynx="coarse", order=order), "airflow.subglottal_pressure": pressure}
    time = {"initial.opening_velocity": 1.0, "time.duration": 1e-3 * first + frames * FRAME}
    return scene.replace(tissue | parts | time | {"output": output})


def judged(scene: plica.Scene, where: Path, guess: float) -> list[str]:
    """A row: errors of log theta in %, with the sd that is stated, and the residual test."""
    run = plica.run(scene, where / "run", progress=False)
    plica.write_film(plica.film(run, CAMERA), where / "clip.npy")
    random = np.random.default_rng(1)
    with Stored(where / "clip.truth.h5", "r+") as file:
        for index, flow in enumerate(file.rows("flow")):
            file.put_row("flow", index, flow + random.normal(0, NOISE, flow.shape))
    settings = Settings(parameters=ESTIMATED, coarser="none", sd=NOISE, spacing=8, voiced=False)
    bare = scene.replace({"contact": None, "initial": None, "symmetry": None, "output": plica.Output()})
    begin = {
        f"tissue.{layer}.{name}": guess * getattr(scene.tissue[layer], name)
        for layer, name in (("cover", "mu_fibre"), ("body", "mu_fibre"))
    }
    found = identify(where / "clip.truth.h5", bare.replace(begin), where / "tissue", settings, progress=False)
    posterior, picture = found.posterior, found.picture
    truth = [scene.tissue["cover"].viscosity, scene.tissue["cover"].mu_fibre, scene.tissue["body"].mu_fibre]
    truth[0] = posterior.median[0] / np.exp(posterior.mean[0] - posterior.prior_mean[0])  # the guess's is it
    parts = [
        f"{100 * error:+.0f} ({100 * sd:.1f})"
        for error, sd in zip(posterior.mean - np.log(truth), posterior.sd, strict=True)
    ]
    test = posterior.residuals
    scores = " ".join(f"{score:+.1f}" for score in (test.in_time, test.in_space, test.tails, test.level))
    passed = "passed" if test.passed else "failed"
    motion = float(np.sqrt(np.nanmean(picture.observed**2)))
    follows = f"{100 * picture.explained:.0f} %"
    tests = [follows, f"{passed} ({scores})", "yes" if posterior.gaussian else "no"]
    return [f"{motion:.2f} px", str(int(picture.closed.sum())), *parts, *tests]


def main() -> None:
    options = script_parser(__doc__)
    options.add_argument("--pressures", type=float, nargs="+", default=[400, 600, 800, 1000], help="Pa")
    options.add_argument("--cover", type=float, nargs="+", default=[1.0], help="factors on its moduli")
    options.add_argument("--order", type=int, default=1, help="of the elements")
    options.add_argument("--frames", type=int, default=40)
    options.add_argument("--first", type=float, default=40.0, help="ms before the film")
    options.add_argument("--guess", type=float, default=1.35, help="prior medians of moduli over the truth")
    chosen = options.parse_args()
    show(COLUMNS, rows(chosen))


def rows(chosen: argparse.Namespace) -> Iterator[list[str]]:
    """A voice by pressure and cover."""
    for pressure in chosen.pressures:
        for cover in chosen.cover:
            scene = voice(pressure, cover, chosen.order, chosen.frames, chosen.first)
            with tempfile.TemporaryDirectory() as where:
                found = judged(scene, Path(where), chosen.guess)
            yield [f"{pressure:g}", f"{cover:g}", *found]


if __name__ == "__main__":
    main()
