"""Flow on a recording of a larynx: what measures without a truth say of plica's presets and of peers.

    python -m benchmarks.flow.clip larynx.mp4 --peers peers/bin/python
    python -m benchmarks.flow.clip --peers peers/bin/python             the synthetic glottis, with the truth

Of every second pair of frames (--every), without the endoscope's motion, on the recording's scale and cut to
[0, 255]; peers that take 8 bits get them rounded. Over the pixels of tissue (no glottis, no highlight of 250
and above in either frame, two pixels about both left out) whose flow stays in the frame by every method:

    residual     root mean square of I2(x + u) - I1(x), grey levels, by cubic splines
    round trip   |u(x) + b(x + u(x))|, px, b the flow from the second frame to the first: median and 95th
                 percentile
    motion       |u(x)|, px: 95th percentile
    edge         slope and correlation of the flow beside a fold's edge with the way of that edge in the masks
    true error   |u(x) - truth(x)|, px, of the synthetic glottis: mean

over the tenth that varies most in the recording: most of what an endoscope sees stands still.

The edge is a second witness: across the midline, flow in the mean over the tissue within 8 px of the edge in
the middle tenth of the midline, for all pairs and both sides that are open in both frames. Tissue farther
away moves less, so that the slope of the true flow is below 1.

"masked": the data term used the mask of `plica video` (motion.frame_content); "tissue alone": the tissue
above, so not the folds' edges. "no motion" stands for u = b = 0: its round trip is perfect. Neither residual
nor round trip sees a fault that both directions share; the residual is least for flow that follows the noise,
the round trip for flow that is smooth. How far they tell methods apart is their rank correlation with the
true error, where that is known.

Peers need an environment of their own: python -m venv peers, then
peers/bin/pip install opencv-contrib-python-headless scikit-image
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy import ndimage, stats

from benchmarks.flow.method import PEERS
from benchmarks.harness.study import record, script_parser
from plica.synthetic.glottis import Synthetic, SyntheticGlottis
from plica.video.analysis import analyse
from plica.video.files.recording import spread
from plica.video.glottis.glottal_area import areas
from plica.video.glottis.midline import find_midline, pixels
from plica.video.motion.frame_content import Seen, bright, informing

PRESETS = ("video", "robust", "fast", "gradient")
WORKER = Path(__file__).with_name("method.py")
WAYS = ("masked", "tissue alone")


@dataclass
class Pair:
    first: np.ndarray  # (h, w) grey
    second: np.ndarray
    tissue: np.ndarray  # (h, w) bool
    masks: dict[str, np.ndarray]  # (h, w) bool of each way
    moving: np.ndarray  # (h, w) bool, the tenth of the tissue that varies most
    beside: list[np.ndarray]  # of the edges left and right: (h, w) bool, tissue that is near
    way: list[float]  # px, of these edges across the midline, to the right; not a number where one is closed
    across: np.ndarray  # (2,) unit vector, to the right
    truth: np.ndarray | None = None  # (h, w, 2) px, not a number where unknown


@dataclass
class Found:
    there: list[np.ndarray]  # (h, w, 2) px, of each pair
    back: list[np.ndarray]
    processor: float  # s a flow


def main() -> None:
    parser = script_parser(__doc__)
    parser.add_argument("clip", type=Path, nargs="?", help="a recording; left out: the synthetic glottis")
    parser.add_argument("--peers", type=Path, help="Python of the peers' environment")
    parser.add_argument("--every", type=int, default=2, help="of how many pairs one is taken")
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
        methods.insert(1, ("plica video tissue alone", sys.executable))
        if options.peers:
            methods += [(name, str(options.peers)) for name in PEERS]
        found = {name: run(name, python, pairs, folder, options.threads) for name, python in methods}
    still = [np.zeros((*pair.first.shape, 2)) for pair in pairs]
    found["no motion"] = Found(still, still, 0.0)
    table(pairs, found)


def recorded(clip: Path, folder: Path, every: int) -> list[Pair]:
    """Pairs of a recording as `plica video` sees them."""
    found = analyse(clip, folder / "analysis", until="glottis", progress=False)
    return paired(list(found.frames().frames()), list(found["glottis/mask"] > 0), every)


def synthetic(noise: float, every: int) -> list[Pair]:
    """Pairs of two cycles of the synthetic glottis, which collides and is not symmetric."""
    glottis = SyntheticGlottis(
        Synthetic(frames=44, frequency=2 / 43, amplitude=(9, 7), phase=(0.0, 0.6), noise=noise)
    )
    times = range(glottis.count)
    pairs = paired(list(glottis.frames()), [glottis.mask(t) for t in times], every)
    for t, pair in zip(times[:-1:every], pairs, strict=True):
        truth, known = glottis.flow(t, t + 1)
        pair.truth = np.where(known[..., None], truth, np.nan)
    return pairs


def paired(frames: list[np.ndarray], glottis: list[np.ndarray], every: int) -> list[Pair]:
    midline = find_midline(glottis)
    area = areas(glottis, midline)
    shape = (frames[0].shape[0], frames[0].shape[1])
    along, right = np.moveaxis(midline.place(pixels(shape)), -1, 0)
    middle, side = np.abs(along / midline.length - 0.5) < 0.05, right > 0
    varies = spread(frames)
    pairs = []
    for k in range(0, len(frames) - 1, every):
        first, second, both = frames[k], frames[k + 1], glottis[k] | glottis[k + 1]
        tissue = ~ndimage.binary_dilation(both | (np.maximum(first, second) >= bright), iterations=2)
        moving = tissue & (varies > np.quantile(varies[tissue], 0.9))
        near = tissue & middle & ndimage.binary_dilation(glottis[k], iterations=8)
        way = [
            sign * (edge[k + 1] - edge[k]) if min(edge[k], edge[k + 1]) > 0 else np.nan
            for sign, edge in ((-1, area.left_edge), (1, area.right_edge))
        ]
        beside = [near & ~side, near & side]
        used = informing(Seen(first, glottis[k]), Seen(second, glottis[k + 1]))
        masks = {"masked": used, "tissue alone": tissue}
        one, two = np.clip(first, 0, 255), np.clip(second, 0, 255)
        pairs.append(Pair(one, two, tissue, masks, moving, beside, way, midline.across))
    return pairs


def run(name: str, python: str, pairs: list[Pair], folder: Path, threads: int) -> Found:
    """The flows there and back by one method, in a process of its own."""
    frames, result = folder / "frames.npz", folder / "result.npz"
    told_by = next((way for way in WAYS if name.endswith(way)), None)
    arrays: dict[str, np.ndarray] = {}
    for k, pair in enumerate(pairs):
        for key, one, two in ((f"there{k}", pair.first, pair.second), (f"back{k}", pair.second, pair.first)):
            arrays |= {f"{key}_first": one, f"{key}_second": two}
            if told_by:
                arrays[f"{key}_mask"] = pair.masks[told_by]
    np.savez(frames, **arrays)
    command = [python, WORKER, name.removesuffix(f" {told_by}"), frames, result, str(threads)]
    subprocess.run(command, check=True, env=os.environ | {"OMP_NUM_THREADS": str(threads)})
    result_arrays = dict(np.load(result))
    spent = [result_arrays[f"{way}{k}_processor"] for way in ("there", "back") for k in range(len(pairs))]
    return Found(
        [result_arrays[f"there{k}"] for k in range(len(pairs))],
        [result_arrays[f"back{k}"] for k in range(len(pairs))],
        float(np.median(spent)),
    )


def landing(flow: np.ndarray) -> np.ndarray:
    """(2, h, w) row and column of x + u."""
    y, x = np.mgrid[0 : flow.shape[0], 0 : flow.shape[1]]
    return np.stack([y + flow[..., 1], x + flow[..., 0]])


def inside(flow: np.ndarray) -> np.ndarray:
    y, x = landing(flow)
    return (y >= 0) & (y <= flow.shape[0] - 1) & (x >= 0) & (x <= flow.shape[1] - 1)


def table(pairs: list[Pair], found: dict[str, Found]) -> None:
    """A row a method, over the tissue that varies most; the edges over all of their ways."""
    known = pairs[0].truth is not None
    used = counted(pairs, found)
    columns = ["method", "residual (grey)", "round trip, median (px)", "95th percentile (px)", "motion (px)"]
    columns += ["true error (px)"] * known + ["edge: slope", "correlation", "processor (s)"]
    height, width = pairs[0].first.shape
    part = np.mean([mask.mean() for mask in used])
    values, rows = [], []
    for name, method in found.items():
        values.append(judged(pairs, used, method))
        cells = [f"{values[-1][0]:.2f}", *(f"{value:.3f}" for value in values[-1][1:])]
        rows.append([name, *cells, *edges(pairs, method), f"{method.processor:.3f}"])
    note = f"{len(pairs)} pairs of {width} x {height} px, {part:.1%} of the pixels."
    if known:
        truth = Found([np.nan_to_num(pair.truth) for pair in pairs], [], 0.0)
        slope, alike = edges(pairs, truth)
        note += f" The edges of the true flow: slope {slope}, correlation {alike}. Rank correlations with the"
        ranked = np.array(values)
        both = [stats.spearmanr(ranked[:, k], ranked[:, -1]).statistic for k in range(3)]
        correlations = (f"{name} {value:+.2f}" for name, value in zip(columns[1:4], both, strict=True))
        note += f" true error: {', '.join(correlations)}."
    record("flow_synthetic" if known else "flow_clip", columns, rows, note)


def counted(pairs: list[Pair], found: dict[str, Found]) -> list[np.ndarray]:
    """(h, w) bool of each pair: the tissue that varies most, whose flow stays in the frame by all methods."""
    used = []
    for k, pair in enumerate(pairs):
        mask = pair.moving.copy()
        for method in found.values():
            mask &= inside(method.there[k])
        if pair.truth is not None:
            mask &= np.isfinite(pair.truth[..., 0])
        used.append(mask)
    return used


def edges(pairs: list[Pair], method: Found) -> list[str]:
    """Slope and correlation of the flow beside the edges with the way of the edges."""
    there = [(k, s) for k, pair in enumerate(pairs) for s in (0, 1) if usable(pair, s)]
    way = np.array([pairs[k].way[s] for k, s in there])
    flow = np.array([(method.there[k][pairs[k].beside[s]] @ pairs[k].across).mean() for k, s in there])
    alike = np.corrcoef(flow, way)[0, 1] if flow.any() else 0.0
    return [f"{flow @ way / (way @ way):.2f}", f"{alike:.2f}"]


def usable(pair: Pair, side: int) -> bool:
    return bool(np.isfinite(pair.way[side]) and pair.beside[side].any())


def judged(pairs: list[Pair], used: list[np.ndarray], method: Found) -> list[float]:
    """Residual, median and 95th percentile of the round trip, motion; the true error where it is known."""
    left, missed, moved, wrong = [], [], [], []
    for pair, mask, there, back in zip(pairs, used, method.there, method.back, strict=True):
        to = landing(there)[:, mask]
        seen = ndimage.map_coordinates(pair.second.astype(float), to, order=3, mode="mirror")
        left.append(seen - pair.first[mask])
        home = [ndimage.map_coordinates(back[..., c], to, order=1, mode="nearest") for c in (0, 1)]
        missed.append(np.hypot(*(there[mask].T + home)))
        moved.append(np.hypot(*there[mask].T))
        if pair.truth is not None:
            wrong.append(np.hypot(*(there - pair.truth)[mask].T))
    figures = [np.sqrt(np.mean(np.concatenate(left) ** 2)), *np.percentile(np.concatenate(missed), [50, 95])]
    figures.append(np.percentile(np.concatenate(moved), 95))
    return [float(figure) for figure in figures + ([np.concatenate(wrong).mean()] if wrong else [])]


if __name__ == "__main__":
    main()
