"""Flow on a recording of a larynx: what two measures without a truth say of plica's presets and of peers.

    python benchmarks/clip.py larynx.mp4 --peers peers/bin/python
    python benchmarks/clip.py --peers peers/bin/python                  the synthetic glottis, with the truth

Of every third pair of frames (--every), without the endoscope's motion, on the recording's scale and cut to
[0, 255]; peers that take 8 bits get them rounded. Over the pixels of tissue (no glottis, no highlight of 250
and above in either frame, two pixels about both left out) whose flow stays in the frame by every method:

    residual     root mean square of I2(x + u) - I1(x), grey levels, by cubic splines
    round trip   |u(x) + b(x + u(x))|, px, b the flow from the second frame to the first: median and 95th
                 percentile
    true error   |u(x) - truth(x)|, px, of the synthetic glottis: mean

once over all of them and once over the tenth that varies most in the recording: most of what an endoscope
sees stands still.

"masked": plica was told which pixels are tissue, as `plica video` does. "no motion" stands for u = b = 0: its
round trip is perfect. Neither measure sees a fault that both directions share; the residual is least for flow
that follows the noise, the round trip for flow that is smooth. The last table says how far they tell methods
apart where the truth is known: the rank correlation of each with the true error.

Peers need an environment of their own: python -m venv peers, then
peers/bin/pip install opencv-contrib-python-headless scikit-image
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np
from flow_method import PEERS
from scipy import ndimage, stats

from plica.video.analysis import Settings, analyse
from plica.video.drift import without_drift
from plica.video.recording import Recording, spread
from plica.video.synthetic import Synthetic, SyntheticGlottis

PRESETS = ("video", "robust", "fast")
WORKER = Path(__file__).with_name("flow_method.py")
BRIGHT = 250.0


@dataclass
class Pair:
    first: np.ndarray  # (h, w) grey
    second: np.ndarray
    tissue: np.ndarray  # (h, w) bool
    moving: np.ndarray  # (h, w) bool, the tenth of the tissue that varies most
    truth: np.ndarray | None = None  # (h, w, 2) px, not a number where unknown


@dataclass
class Found:
    there: list[np.ndarray]  # (h, w, 2) px, of each pair
    back: list[np.ndarray]
    processor: float  # s a flow


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("clip", type=Path, nargs="?", help="a recording; left out: the synthetic glottis")
    parser.add_argument("--peers", type=Path, help="Python of the peers' environment")
    parser.add_argument("--every", type=int, default=3, help="of how many pairs one is taken")
    parser.add_argument("--noise", type=float, default=2.0, help="of the synthetic glottis, grey levels")
    parser.add_argument("--threads", type=int, default=2)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        if options.clip:
            pairs = recorded(options.clip, folder, options.every)
        else:
            pairs = synthetic(options.noise, options.every)
        methods = [(f"plica {preset}{way}", sys.executable) for preset in PRESETS for way in (" masked", "")]
        if options.peers:
            methods += [(name, str(options.peers)) for name in PEERS]
        found = {name: run(name, python, pairs, folder, options.threads) for name, python in methods}
    still = [np.zeros((*pair.first.shape, 2)) for pair in pairs]
    found["no motion"] = Found(still, still, 0.0)
    for region in ("all", "moving"):
        table(pairs, found, region)


def recorded(clip: Path, folder: Path, every: int) -> list[Pair]:
    """Pairs of a recording as `plica video` sees them."""
    analyse(clip, folder / "analysis", Settings(), until="glottis", progress=False)
    recording = Recording.open(clip)
    with h5py.File(folder / "analysis" / "results.h5") as file:
        glottis, motion = file["glottis/mask"][:], file["frames/drift"][:]
    frames = list(without_drift(recording.frames(), motion))
    varies = spread(frames)
    return [
        pair(frames[k], frames[k + 1], glottis[k] | glottis[k + 1], varies)
        for k in range(0, len(frames) - 1, every)
    ]


def synthetic(noise: float, every: int) -> list[Pair]:
    """Pairs of two cycles of the synthetic glottis, which collides and is not symmetric."""
    glottis = SyntheticGlottis(
        Synthetic(frames=44, frequency=2 / 43, amplitude=(9, 7), phase=(0.0, 0.6), noise=noise)
    )
    frames = list(glottis.frames())
    varies = spread(frames)
    pairs = []
    for t in range(0, glottis.count - 1, every):
        made = pair(frames[t], frames[t + 1], glottis.mask(t) | glottis.mask(t + 1), varies)
        truth, known = glottis.flow(t, t + 1)
        made.truth = np.where(known[..., None], truth, np.nan)
        pairs.append(made)
    return pairs


def pair(first: np.ndarray, second: np.ndarray, glottis: np.ndarray, varies: np.ndarray) -> Pair:
    hidden = ndimage.binary_dilation(glottis | (np.maximum(first, second) >= BRIGHT), iterations=2)
    moving = ~hidden & (varies > np.quantile(varies[~hidden], 0.9))
    return Pair(np.clip(first, 0, 255), np.clip(second, 0, 255), ~hidden, moving)


def run(name: str, python: str, pairs: list[Pair], folder: Path, threads: int) -> Found:
    """The flows there and back by one method, in a process of its own."""
    frames, result = folder / "frames.npz", folder / "result.npz"
    arrays: dict[str, np.ndarray] = {}
    for k, pair in enumerate(pairs):
        for key, one, two in ((f"there{k}", pair.first, pair.second), (f"back{k}", pair.second, pair.first)):
            arrays |= {f"{key}_first": one, f"{key}_second": two}
            if name.endswith(" masked"):
                arrays[f"{key}_mask"] = pair.tissue
    np.savez(frames, **arrays)
    command = [python, WORKER, name.removesuffix(" masked"), frames, result, str(threads)]
    subprocess.run(command, check=True, env=os.environ | {"OMP_NUM_THREADS": str(threads)})
    told = dict(np.load(result))
    spent = [told[f"{way}{k}_processor"] for way in ("there", "back") for k in range(len(pairs))]
    return Found(
        [told[f"there{k}"] for k in range(len(pairs))],
        [told[f"back{k}"] for k in range(len(pairs))],
        float(np.median(spent)),
    )


def landing(flow: np.ndarray) -> np.ndarray:
    """(2, h, w) row and column of x + u."""
    y, x = np.mgrid[0 : flow.shape[0], 0 : flow.shape[1]]
    return np.stack([y + flow[..., 1], x + flow[..., 0]])


def inside(flow: np.ndarray) -> np.ndarray:
    y, x = landing(flow)
    return (y >= 0) & (y <= flow.shape[0] - 1) & (x >= 0) & (x <= flow.shape[1] - 1)


def table(pairs: list[Pair], found: dict[str, Found], region: str) -> None:
    known = pairs[0].truth is not None
    used = []
    for k, pair in enumerate(pairs):
        mask = (pair.moving if region == "moving" else pair.tissue).copy()
        for method in found.values():
            mask &= inside(method.there[k])
        if pair.truth is not None:
            mask &= np.isfinite(pair.truth[..., 0])
        used.append(mask)
    height, width = pairs[0].first.shape
    part = np.mean([mask.mean() for mask in used])
    print(f"\n{len(pairs)} pairs of {width} x {height} px, {region} tissue: {part:.0%} of the pixels\n")
    head = ["Method", "residual (grey)", "round trip, median (px)", "95th percentile (px)"]
    head += ["true error (px)"] if known else []
    head += ["processor (s)"]
    print("| " + " | ".join(head) + " |\n" + "|---" * len(head) + "|")
    rows = []
    for name, method in found.items():
        rows.append(judged(pairs, used, method))
        cells = [f"{rows[-1][0]:.2f}", *(f"{value:.3f}" for value in rows[-1][1:]), f"{method.processor:.3f}"]
        print(f"| {name} | " + " | ".join(cells) + " |", flush=True)
    if known:
        values = np.array(rows)
        print('\n| rank correlation with the true error | all | without "no motion" |\n|---|---|---|')
        for column, what in enumerate(head[1:4]):
            both = [stats.spearmanr(part[:, column], part[:, 3]).statistic for part in (values, values[:-1])]
            print(f"| {what} | {both[0]:+.2f} | {both[1]:+.2f} |")


def judged(pairs: list[Pair], used: list[np.ndarray], method: Found) -> list[float]:
    """Residual, median and 95th percentile of the round trip, and the true error where there is a truth."""
    left, missed, wrong = [], [], []
    for pair, mask, there, back in zip(pairs, used, method.there, method.back, strict=True):
        to = landing(there)[:, mask]
        seen = ndimage.map_coordinates(pair.second.astype(float), to, order=3, mode="mirror")
        left.append(seen - pair.first[mask])
        home = [ndimage.map_coordinates(back[..., c], to, order=1, mode="nearest") for c in (0, 1)]
        missed.append(np.hypot(*(there[mask].T + home)))
        if pair.truth is not None:
            wrong.append(np.hypot(*(there - pair.truth)[mask].T))
    figures = [np.sqrt(np.mean(np.concatenate(left) ** 2)), *np.percentile(np.concatenate(missed), [50, 95])]
    return [float(figure) for figure in figures + ([np.concatenate(wrong).mean()] if wrong else [])]


if __name__ == "__main__":
    main()
