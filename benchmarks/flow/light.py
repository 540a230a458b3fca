"""Flow under light that changes, and beside a slit that opens from closed: plica's presets and peers.

    python -m benchmarks.flow.light --peers peers/bin/python
    python -m benchmarks.flow.light --peers peers/bin/python --part slit

Recordings of the synthetic glottis, 192 x 192, that no choice was made on: the endoscope moves (by up to
1.5 px and 0.006 rad), the light falls off towards the corners and highlights stay where they are as the
endoscope sees them, noise of 2 grey levels, 8 bits. From frame to frame the light changes by the share in the
head, up and down in turn: by 3/4 of it at the left border and by 5/4 at the right one. All are taken through
the steps of `plica video` up to the midline; every method gets the same steadied frames, plica's also what
`plica video` tells the flow (highlights, glottis, midline, as found). The truth is that of the frames as
steadied, with what the endoscope's motion was missed by.

Light: mean distance (px) from the true flow, of tissue (no glottis, no highlight, two pixels about both left
out) 12 px and more from the border. Slit: tissue within 3 px of an edge, in rows that open from closed (or
close) and move by over 0.2 px: slope of the motion across the midline over the true one through the origin,
correlation and root mean square of the difference, px.

Peers need an environment of their own: python -m venv peers, then
peers/bin/pip install opencv-contrib-python-headless scikit-image
"""

from __future__ import annotations

import os
import subprocess
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy import ndimage

from benchmarks.harness.study import record, script_parser
from plica.synthetic.glottis import Synthetic, SyntheticGlottis
from plica.video.analysis import analyse
from plica.video.glottis.brightness import dark_level
from plica.video.motion.flow import flow
from plica.video.motion.fold_edges import Folds
from plica.video.motion.frame_content import Seen, informing

CHANGES = (0.0, 0.01, 0.02, 0.04, 0.06)
PRESETS = ("video", "robust", "fast", "gradient")
PEERS = ("DeepFlow", "OpenCV TV-L1")
SIZE, FRAMES, NOISE, BORDER = 192, 22, 2.0, 12
WORKER = Path(__file__).with_name("method.py")
GLOTTIS = {"height": SIZE, "width": SIZE, "frames": FRAMES, "highlights": 0, "light": 0.0, "noise": 0.0}
LIT = (
    Synthetic(**GLOTTIS, amplitude=(8, 6.5), opening=(2.5, 2.5), phase=(0, 0.4), lag=0.5, seed=21),
    Synthetic(**GLOTTIS, amplitude=(6, 6), opening=(4, 4), reach=35.0, grain=2.6, seed=22),
)
PARTED = (
    Synthetic(**GLOTTIS, amplitude=(7.5, 6), opening=(-1.5, -1), phase=(0, 0.2), seed=31),
    Synthetic(**GLOTTIS, amplitude=(9, 9), opening=(-2, -2), reach=18.0, lag=0.6, seed=32),
    Synthetic(**GLOTTIS, amplitude=(6, 8), opening=(0.5, 0.5), grain=2.6, seed=33),
)


@dataclass
class Pair:
    one: np.ndarray  # (h, w) grey, steadied
    two: np.ndarray
    counted: np.ndarray  # (h, w) bool
    folds: Folds
    truth: np.ndarray  # (h, w, 2) px
    tissue: np.ndarray  # (h, w) bool, whose flow is counted
    opening: np.ndarray  # (h, w) bool, tissue beside edges that leave the midline
    closing: np.ndarray


def endoscope() -> np.ndarray:
    """(frames, 3) how it moves the picture: px right, px down, rad clockwise."""
    k = np.arange(FRAMES)
    return np.stack([1.5 * np.sin(0.31 * k), 1.5 * np.sin(0.23 * k), 0.006 * np.sin(0.17 * k)], axis=1)


def picture(points: np.ndarray, motion: np.ndarray) -> np.ndarray:
    """Where points (..., 2) px about the centre are in a picture that has so moved."""
    (x, y), (cos, sin) = np.moveaxis(points, -1, 0), (np.cos(motion[2]), np.sin(motion[2]))
    return np.stack([cos * x - sin * y + motion[0], sin * x + cos * y + motion[1]], axis=-1)


def scene(points: np.ndarray, motion: np.ndarray) -> np.ndarray:
    """The inverse."""
    (x, y), (cos, sin) = np.moveaxis(points - motion[:2], -1, 0), (np.cos(motion[2]), np.sin(motion[2]))
    return np.stack([cos * x + sin * y, cos * y - sin * x], axis=-1)


def steadied(truth: np.ndarray, k: int, found: np.ndarray) -> np.ndarray:
    """The true flow (h, w, 2) from k to k + 1 as frames show it that were steadied by the motion found."""
    y, x = np.mgrid[0:SIZE, 0:SIZE] - (SIZE - 1) / 2
    pixel, true = np.stack([x, y], axis=-1), endoscope()
    place = scene(picture(pixel, found[k]), true[k])
    at = np.moveaxis(place, -1, 0)[::-1] + (SIZE - 1) / 2
    moved = [ndimage.map_coordinates(part, at, order=1, mode="nearest") for part in np.moveaxis(truth, -1, 0)]
    then = picture(place + np.stack(moved, axis=-1), true[k + 1])
    return scene(then, found[k + 1]) - pixel


def filmed(glottis: SyntheticGlottis, change: float) -> np.ndarray:
    """(frames, h, w) uint8."""
    random = np.random.default_rng([glottis.options.seed, 7])
    y, x = np.mgrid[0:SIZE, 0:SIZE] - (SIZE - 1) / 2
    vignette = 1 - 0.5 * (x**2 + y**2) / SIZE**2
    spots = np.zeros((SIZE, SIZE), bool)
    for row, column in random.uniform(-0.4 * SIZE, 0.4 * SIZE, (6, 2)):
        spots |= (y - row) ** 2 + (x - column) ** 2 < 2.5**2
    spots = ndimage.gaussian_filter(np.where(spots, 400.0, 0.0), 0.8)
    frames = []
    pixel = np.stack([x, y], axis=-1)
    for k, motion in enumerate(endoscope()):
        column, row = np.moveaxis(scene(pixel, motion), -1, 0) + (SIZE - 1) / 2
        grey = ndimage.map_coordinates(glottis.frame(k).astype(float), [row, column], order=3, mode="mirror")
        lit = 1 + (k % 2) * change * (1 + 0.5 * x / SIZE)
        grey = (grey * vignette + spots) * lit + NOISE * random.standard_normal(grey.shape)
        frames.append(np.clip(np.round(grey), 0, 255).astype(np.uint8))
    return np.stack(frames)


def pairs(options: Synthetic, change: float) -> list[Pair]:
    glottis = SyntheticGlottis(options)
    with tempfile.TemporaryDirectory() as folder:
        np.save(Path(folder) / "film.npy", filmed(glottis, change))
        found = analyse(Path(folder) / "film.npy", Path(folder) / "found", until="glottis", progress=False)
        seen = [Seen(frame, found.mask(k)) for k, frame in enumerate(found.frames().frames())]
        midline, motion = found.midline, found["drift/motion"]
    widest = max(seen, key=lambda one: int(one.glottis.sum()))
    dark = dark_level(widest.frame, widest.glottis)
    rows, columns = np.mgrid[0:SIZE, 0:SIZE].astype(float)
    inside = np.zeros((SIZE, SIZE), bool)
    inside[BORDER:-BORDER, BORDER:-BORDER] = True
    made = []
    for k in range(FRAMES - 1):
        truth, known = glottis.flow(k, k + 1)
        moves = known & (np.abs(truth[..., 0]) > 0.2)
        beside = {"opening": np.zeros_like(known), "closing": np.zeros_like(known)}
        for side, sign in ((0, -1.0), (1, 1.0)):
            before, after = (glottis.edge(side, rows, t) for t in (k, k + 1))
            far = (columns - glottis.midline) * sign - before
            near = moves & (far >= 0) & (far < 3)
            beside["opening"] |= near & (before == 0) & (after > 0)
            beside["closing"] |= near & (before > 0) & (after == 0)
        made.append(
            Pair(
                seen[k].frame,
                seen[k + 1].frame,
                informing(seen[k], seen[k + 1]),
                Folds(seen[k].glottis, seen[k + 1].glottis, midline, dark),
                steadied(truth, k, motion),
                seen[k].tissue & known & inside,
                **beside,
            )
        )
    return made


def flows(method: str, given: list[Pair], peers: Path | None) -> list[np.ndarray]:
    """(h, w, 2) px of each pair."""
    if method not in PEERS:
        preset, *how = method.split(", ")
        without = {"light": "none"} if "constant light" in how else {}
        return [
            flow(
                p.one,
                p.two,
                preset=preset,
                mask=p.counted,
                intensity=(0.0, 255.0),
                folds=None if "without edges" in how else p.folds,
                **without,
            ).flow
            for p in given
        ]
    with tempfile.TemporaryDirectory() as folder:
        frames, result = Path(folder) / "frames.npz", Path(folder) / "result.npz"
        cut = {f"{k:03}_first": np.clip(p.one, 0, 255) for k, p in enumerate(given)}
        cut |= {f"{k:03}_second": np.clip(p.two, 0, 255) for k, p in enumerate(given)}
        np.savez(frames, **cut)
        command = [str(peers), str(WORKER), method, str(frames), str(result), "1"]
        subprocess.run(command, check=True, env=os.environ | {"OMP_NUM_THREADS": "1"})
        found = np.load(result)
        return [found[f"{k:03}"] for k in range(len(given))]


def light_rows(methods: list[str], peers: Path | None) -> Iterator[list[str]]:
    """Errors by change of the light."""
    given = [[pair for options in LIT for pair in pairs(options, change)[::2]] for change in CHANGES]
    for method in methods:
        errors = []
        for of_change in given:
            found = flows(method, of_change, peers)
            off = [
                np.hypot(*np.moveaxis(f - p.truth, -1, 0))[p.tissue].mean()
                for f, p in zip(found, of_change, strict=True)
            ]
            errors.append(float(np.mean(off)))
        yield [method, *(f"{error:.3f}" for error in errors), f"{errors[-1] / errors[0]:.2f}"]


def slit_rows(methods: list[str], peers: Path | None, given: list[Pair]) -> Iterator[list[str]]:
    """Motion across the midline beside edges that part and meet."""
    for method in methods:
        found = flows(method, given, peers)
        cells = []
        for name in ("opening", "closing"):
            fields = ([p.truth for p in given], found)
            true, seen = (
                np.concatenate([one[getattr(p, name), 0] for one, p in zip(field, given, strict=True)])
                for field in fields
            )
            slope, alike = true @ seen / (true @ true), np.corrcoef(true, seen)[0, 1]
            off = np.sqrt(np.mean((true - seen) ** 2))
            cells += [f"{slope:.2f}", f"{alike:.2f}", f"{off:.2f}"]
        of_all = [
            np.hypot(*np.moveaxis(f - p.truth, -1, 0))[p.tissue].mean()
            for f, p in zip(found, given, strict=True)
        ]
        yield [method, *cells, f"{np.mean(of_all):.3f}"]


def main() -> None:
    parser = script_parser(__doc__)
    parser.add_argument("--peers", type=Path, help="Python of the peers' environment")
    parser.add_argument("--part", choices=("both", "light", "slit"), default="both")
    options = parser.parse_args()
    peers = list(PEERS) if options.peers else []
    if options.part != "slit":
        before = [f"{preset}, constant light" for preset in ("video", "robust")]
        columns = ["method", *(f"{100 * change:g} %" for change in CHANGES), "6 % over 0 %"]
        record("flow_light", columns, light_rows([*PRESETS, *before, *peers], options.peers))
    if options.part != "light":
        before = [f"{preset}, without edges" for preset in PRESETS]
        given = [pair for one in PARTED for pair in pairs(one, 0.0)]
        opening, closing = (sum(int(getattr(p, way).sum()) for p in given) for way in ("opening", "closing"))
        record(
            "flow_slit",
            [
                *("method", "opening: slope", "correlation", "difference (px)"),
                *("closing: slope", "correlation", "difference (px)", "all tissue (px)"),
            ],
            slit_rows([*PRESETS, *before, *peers], options.peers, given),
            f"Pixels: {opening} opening, {closing} closing.",
        )


if __name__ == "__main__":
    main()
