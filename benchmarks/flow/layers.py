"""Flow between rendered pictures: layers of textured things that move over each other, with the exact truth.

    python -m benchmarks.flow.layers --peers peers/bin/python
    python -m benchmarks.flow.layers --set choice --sweep          what constants were chosen on

Each pair, 320 x 240 px: a background and three to six things of irregular outline, each with a texture of its
own (waves and blots of 2 to 40 px, of more or less contrast) and an affine motion of its own: up to 6 px
across and down, 3 degrees, 3 % of size. 4 x 4 samples a pixel, noise of 1 grey level, 8 bits. Two sets that
share no seed: constants are chosen on `choice`, claims are made of `judge` alone. Mean end-point error (px)
over all pixels whose thing is seen in both pictures.

Peers need an environment of their own: python -m venv peers, then
peers/bin/pip install opencv-contrib-python-headless scikit-image
"""

from __future__ import annotations

import os
import subprocess
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy import ndimage

import plica
from benchmarks.flow.method import PEERS
from benchmarks.harness.study import record, script_parser
from plica.video.motion.flow import flow

SETS = {"choice": range(1, 7), "judge": range(101, 111)}
PRESETS = ("robust", "fast", "video", "gradient")
ROWS, COLUMNS, SAMPLES = 240, 320, 4
WORKER = Path(__file__).with_name("method.py")
FIRST = {"preset": "gradient", "gradient_noise": 1.0, "fine_levels": 2, "warps": 5, "spacing": 2.0}
BOTH = FIRST | {"gradient_noise": 0.3, "fine_levels": 4}
CHARBONNIER = {
    "preset": "robust",
    "data_penalty": "charbonnier",
    "smooth_penalty": "charbonnier",
    "data_scale": 0.35,
    "smooth_scale": 0.01,
}
SWEEP: dict[str, dict[str, Any]] = {
    "gradient at first: zeta 1, two fine levels, five warps": FIRST,
    "zeta 0.3": FIRST | {"gradient_noise": 0.3},
    "four fine levels": FIRST | {"fine_levels": 4},
    "both": BOTH,
    "both, four warps": BOTH | {"warps": 4},
    "both, three warps": BOTH | {"warps": 3},
    "both, four warps, spacing 1.5": BOTH | {"warps": 4, "spacing": 1.5},
    "both, three warps, spacing 1.5: the preset gradient": {"preset": "gradient"},
    "robust": {"preset": "robust"},
    "robust, Charbonnier": CHARBONNIER,
    "robust, Charbonnier, spacing 1.5": CHARBONNIER | {"spacing": 1.5},
    "robust, Charbonnier, spacing 1.5, seven warps": CHARBONNIER | {"spacing": 1.5, "warps": 7},
    "robust, spacing 1.5, seven warps": {"preset": "robust", "spacing": 1.5, "warps": 7},
}


@dataclass
class Pair:
    first: np.ndarray  # (h, w) grey
    second: np.ndarray
    truth: np.ndarray  # (h, w, 2) px, not a number where the thing is hidden in the second


class Thing:
    """A texture with an outline, and how it moves."""

    def __init__(self, random: np.random.Generator, background: bool) -> None:
        side = 512
        noise = np.zeros((side, side))
        for size in random.uniform([1, 3, 8], [2.5, 7, 20]):
            part = ndimage.gaussian_filter(random.standard_normal((side, side)), size, mode="wrap")
            part /= part.std()
            noise += np.sign(part) if random.random() < 0.4 else part
        self.texture = ndimage.spline_filter(
            random.uniform(70, 180) + random.uniform(5, 22) * noise, mode="grid-wrap"
        )
        self.centre = random.uniform([40, 40], [COLUMNS - 40, ROWS - 40])
        turn, size = random.uniform(-0.05, 0.05), random.uniform(-0.03, 0.03)
        shear = random.uniform(-0.01, 0.01, (2, 2))
        self.matrix = np.eye(2) * (1 + size) + np.array([[0, -turn], [turn, 0]]) + shear
        self.shift = random.uniform(-6, 6, 2)
        self.background = background
        self.radius = random.uniform(25, 70)
        self.waves = random.uniform(-1, 1, (4, 2)) * np.array([[0.2], [0.12], [0.08], [0.05]])

    def moved(self, points: np.ndarray) -> np.ndarray:
        return (points - self.centre) @ self.matrix.T + self.centre + self.shift

    def back(self, points: np.ndarray) -> np.ndarray:
        return (points - self.centre - self.shift) @ np.linalg.inv(self.matrix).T + self.centre

    def holds(self, points: np.ndarray) -> np.ndarray:
        """Whether points (..., 2) px of the first picture are of this thing."""
        if self.background:
            return np.ones(points.shape[:-1], bool)
        x, y = np.moveaxis(points - self.centre, -1, 0)
        angle = np.arctan2(y, x)
        radius = 1 + sum(
            a * np.cos(k * angle) + b * np.sin(k * angle) for k, (a, b) in enumerate(self.waves, start=2)
        )
        return np.hypot(x, y) < self.radius * radius

    def grey(self, points: np.ndarray) -> np.ndarray:
        x, y = np.moveaxis(points, -1, 0)
        return ndimage.map_coordinates(self.texture, [y, x], order=3, prefilter=False, mode="grid-wrap")


def rendered(seed: int) -> Pair:
    random = np.random.default_rng([seed, 2024])
    things = [Thing(random, k == 0) for k in range(random.integers(4, 8))]
    fine = (np.arange(SAMPLES) + 0.5) / SAMPLES - 0.5
    y, x = np.mgrid[0:ROWS, 0:COLUMNS].astype(float)
    pixel = np.stack([x, y], axis=-1)
    pictures = []
    for back in (False, True):
        sum_ = np.zeros((ROWS, COLUMNS))
        for dx in fine:
            for dy in fine:
                at = pixel + np.array([dx, dy])
                grey = np.zeros((ROWS, COLUMNS))
                for thing in things:
                    own = thing.back(at) if back else at
                    held = thing.holds(own)
                    grey[held] = thing.grey(own[held])
                sum_ += grey / SAMPLES**2
        noisy = sum_ + random.standard_normal(sum_.shape)
        pictures.append(np.clip(np.round(noisy), 0, 255))
    shown = np.zeros((ROWS, COLUMNS), int)
    for k, thing in enumerate(things):
        shown[thing.holds(pixel)] = k
    truth = np.full((ROWS, COLUMNS, 2), np.nan)
    for k, thing in enumerate(things):
        own = shown == k
        then = thing.moved(pixel[own])
        seen = (then >= 0).all(axis=-1) & (then <= [COLUMNS - 1, ROWS - 1]).all(axis=-1)
        for above in things[k + 1 :]:
            seen &= ~above.holds(above.back(then))
        truth[own] = np.where(seen[:, None], then - pixel[own], np.nan)
    return Pair(*pictures, truth)


def error(found: np.ndarray, pair: Pair) -> float:
    known = np.isfinite(pair.truth).all(axis=-1)
    return float(np.hypot(*np.moveaxis(found - pair.truth, -1, 0))[known].mean())


def peer_flows(name: str, pairs: list[Pair], python: Path) -> tuple[list[np.ndarray], float]:
    with tempfile.TemporaryDirectory() as folder:
        frames, result = Path(folder) / "frames.npz", Path(folder) / "result.npz"
        given = {f"{k:03}_first": p.first for k, p in enumerate(pairs)}
        np.savez(frames, **given, **{f"{k:03}_second": p.second for k, p in enumerate(pairs)})
        command = [str(python), str(WORKER), name, str(frames), str(result), "1"]
        subprocess.run(command, check=True, env=os.environ | {"OMP_NUM_THREADS": "1"})
        found = np.load(result)
        seconds = [float(found[f"{k:03}_processor"]) for k in range(len(pairs))]
        return [found[f"{k:03}"] for k in range(len(pairs))], float(np.median(seconds))


def own_flows(options: dict, pairs: list[Pair]) -> tuple[list[np.ndarray], float]:
    found, seconds = [], []
    for pair in pairs:
        start = time.process_time()
        found.append(flow(pair.first, pair.second, **options).flow)
        seconds.append(time.process_time() - start)
    return found, float(np.median(seconds))


def main() -> None:
    parser = script_parser(__doc__)
    parser.add_argument("--set", choices=tuple(SETS), default="judge")
    parser.add_argument("--sweep", action="store_true", help="the constants that were tried")
    parser.add_argument("--peers", type=Path, help="Python of the peers' environment")
    options = parser.parse_args()
    plica.set_threads(1)
    pairs = [rendered(seed) for seed in SETS[options.set]]
    moved = np.nanmean([np.nanmean(np.hypot(*np.moveaxis(p.truth, -1, 0))) for p in pairs])
    note = f"{len(pairs)} pairs, set `{options.set}`; motion {moved:.2f} px in the mean."
    methods = SWEEP if options.sweep else {f"plica {name}": {"preset": name} for name in PRESETS}
    record(
        f"layers_{options.set}{'_sweep' * options.sweep}",
        ["method", "mean (px)", "median of the pairs", "worst pair", "processor (s)"],
        rows(methods, pairs, options.peers),
        note,
    )


def rows(methods: dict[str, dict[str, Any]], pairs: list[Pair], peers: Path | None) -> Iterator[list[str]]:
    """A row for each way, and for each peer."""
    for name in [*methods, *(PEERS if peers else ())]:
        if name in methods:
            found, seconds = own_flows(methods[name], pairs)
        else:
            found, seconds = peer_flows(name, pairs, peers)
        off = [error(f, p) for f, p in zip(found, pairs, strict=True)]
        yield [name, *(f"{px:.3f}" for px in (np.mean(off), np.median(off), max(off))), f"{seconds:.2f}"]


if __name__ == "__main__":
    main()
