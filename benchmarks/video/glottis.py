"""Segmentation of single laryngeal frames against masks drawn by experts: intersection over union.

    python -m benchmarks.video.glottis ../shared/data/laryngeal/bagls_mini
    python -m benchmarks.video.glottis ../shared/data/laryngeal/bagls_mini --pictures failures
    python -m benchmarks.video.glottis ../shared/data/laryngeal/bagls_mini --segmenter model.onnx

Each frame stands alone here; in a recording the motion tells where the glottis is, and every frame has the
same two grey levels. Two empty masks agree completely (1), an empty one with another not at all (0). Beside
what is found without help stands what help makes of it, by its cost: a region of 10 px about the glottis (two
clicks; as --region), and a mask drawn with eight clicks along the outline of each part (as --masks). Where
the glottis is closed, help is to say so.

The frames are in two halves, of which the first alone may be looked at to choose how plica segments, and the
second judges: sorted by their experts' masks (openings, 0, 1 or more; then area; then number), every other
one, so that both have as many closed glottides, several openings and slits. Few recordings have closed
frames, so each open frame stands for another one, closed: its glottis, and 3 px about it, painted over by
what is around it (the harmonic function, with the frame's own noise). Nothing is to be found there.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.harness.study import record, script_parser
from benchmarks.harness.table import show
from plica.video.files.image_file import read_image
from plica.video.glottis.frame_segmentation import segment

_MARGIN = 10  # px about the glottis
_CLICKS = 8
_PAINTED = 3  # px about the glottis
_EIGHT = np.ones((3, 3))  # neighbours

Find = Callable[[np.ndarray], np.ndarray]


@dataclass(frozen=True)
class Frame:
    """A frame, its expert's mask and its number."""

    name: str
    image: np.ndarray
    truth: np.ndarray

    @property
    def openings(self) -> int:
        from scipy import ndimage

        return int(ndimage.label(self.truth, _EIGHT)[1])


def halves(folder: Path) -> dict[str, list[Frame]]:
    """The frames to choose on, and those that judge."""
    frames = []
    for path in folder.glob("*_seg.png"):
        name = path.name.removesuffix("_seg.png")
        frames.append(Frame(name, read_image(path.with_name(f"{name}.png")), read_image(path) > 127))
    frames.sort(key=lambda one: (min(one.openings, 2), int(one.truth.sum()), int(one.name)))
    return {"chosen on": frames[::2], "judged on": frames[1::2]}


def overlap(one: np.ndarray, other: np.ndarray) -> float:
    """Intersection over union; 1 for two empty masks."""
    union = (one | other).sum()
    return float((one & other).sum() / union) if union else 1.0


def in_region(image: np.ndarray, truth: np.ndarray, find: Find) -> np.ndarray:
    """The glottis found in a rectangle about the true one; nothing where there is none."""
    found = np.zeros_like(truth)
    if truth.any():
        rows, columns = np.flatnonzero(truth.any(axis=1)), np.flatnonzero(truth.any(axis=0))
        cut = np.s_[
            max(rows[0] - _MARGIN, 0) : rows[-1] + _MARGIN + 1,
            max(columns[0] - _MARGIN, 0) : columns[-1] + _MARGIN + 1,
        ]
        found[cut] = find(image[cut])
    return found


def painted_over(frame: Frame) -> np.ndarray:
    """The frame without its glottis: inside, the harmonic function of what is around it, and noise."""
    from scipy import ndimage, sparse
    from scipy.sparse.linalg import spsolve

    hole = ndimage.binary_dilation(frame.truth, _EIGHT, iterations=_PAINTED)
    image = frame.image.astype(float)
    numbers = np.cumsum(hole.ravel()).reshape(hole.shape) - 1
    y, x = np.nonzero(hole)
    count = y.size
    matrix, right = sparse.lil_matrix((count, count)), np.zeros(count)
    for down, across in ((0, 1), (0, -1), (1, 0), (-1, 0)):
        near = y + down, x + across
        inside = (np.minimum(*near) >= 0) & (near[0] < hole.shape[0]) & (near[1] < hole.shape[1])
        for k in np.flatnonzero(inside):
            matrix[k, k] += 1
            place = near[0][k], near[1][k]
            if hole[place]:
                matrix[k, numbers[place]] -= 1
            else:
                right[k] += image[place]
    filled = image.copy()
    filled[hole] = spsolve(matrix.tocsr(), right)
    fine = image - ndimage.gaussian_filter(image, 1.0)
    level = 1.4826 * np.median(np.abs(fine))
    random = np.random.default_rng(int(frame.name))
    return np.where(hole, filled + level * random.standard_normal(image.shape), image)


def clicked(truth: np.ndarray) -> np.ndarray:
    """The polygon of eight points on the outline of each part, at equal angles about its centre."""
    from PIL import Image, ImageDraw
    from scipy import ndimage

    drawn = Image.new("1", truth.shape[::-1])
    labels, count = ndimage.label(truth)
    for label in range(1, count + 1):
        y, x = np.nonzero(labels == label)
        centre = np.array([x.mean(), y.mean()])
        _, axes = (
            np.linalg.eigh(np.cov(np.stack([x, y])) + 1e-9 * np.eye(2)) if x.size > 1 else (0, np.eye(2))
        )
        place = (np.stack([x, y], axis=1) - centre) @ axes
        size = np.maximum(np.abs(place).max(axis=0), 0.5)
        angle = np.arctan2(place[:, 1] / size[1], place[:, 0] / size[0])
        corners = []
        for wanted in np.arange(_CLICKS) * 2 * np.pi / _CLICKS:
            near = np.abs((angle - wanted + np.pi) % (2 * np.pi) - np.pi) < np.pi / _CLICKS
            if near.any():
                far = np.argmax(np.linalg.norm(place[near] / size, axis=1))
                corners.append((float(x[near][far]), float(y[near][far])))
        if len(corners) > 2:
            ImageDraw.Draw(drawn).polygon(corners, fill=1, outline=1)
        else:
            ImageDraw.Draw(drawn).point(list(zip(x.tolist(), y.tolist(), strict=True)), fill=1)
    return np.asarray(drawn)


def main() -> None:
    parser = script_parser(__doc__)
    parser.add_argument("folder", type=Path, help="with N.png and N_seg.png")
    parser.add_argument("--half", choices=("chosen on", "judged on"), help="only this one")
    parser.add_argument("--segmenter", type=Path, help="an ONNX model in place of plica's segmentation")
    parser.add_argument("--pictures", type=Path, help="write frames below 0.5 there: true green, found red")
    options = parser.parse_args()
    find: Find = lambda image: segment(image).mask  # noqa: E731
    if options.segmenter:
        from plica.video.glottis.network import Network

        network = Network(options.segmenter)
        find = lambda image: network.probability(image) >= network.threshold  # noqa: E731
    for half, frames in halves(options.folder).items():
        if options.half in (None, half):
            rows, note = report(half, frames, find, options.pictures)
            record(f"glottis_{half.split()[0]}", [half, "alone", "region", "eight clicks"], rows, note)


def report(half: str, frames: list[Frame], find: Find, pictures: Path | None) -> tuple[list[list[str]], str]:
    """The table of one half, and the sentence below it; frames below 0.5 are printed."""
    rows = []
    for frame in frames:
        found = find(frame.image)
        masks = (found, in_region(frame.image, frame.truth, find), clicked(frame.truth))
        rows.append((*(overlap(frame.truth, mask) for mask in masks), frame, int(found.sum())))
        if pictures and rows[-1][0] < 0.5:
            write_picture(pictures / f"{frame.name}.png", frame.image, frame.truth, found)
    rows.sort(key=lambda row: row[0])
    columns = ("frame", "openings", "alone", "region", "eight clicks", "true (px)", "found (px)")
    print()
    show(
        columns,
        [
            (frame.name, frame.openings, *(f"{share:.2f}" for share in shares), int(frame.truth.sum()), area)
            for *shares, frame, area in rows
            if shares[0] < 0.5
        ],
    )
    kinds = {
        "all": rows,
        "one opening": [row for row in rows if row[3].openings == 1],
        "several openings": [row for row in rows if row[3].openings > 1],
        "closed": [row for row in rows if row[3].openings == 0],
    }
    table = []
    for kind, some in kinds.items():
        columns = np.array([row[:3] for row in some])
        for what, value in (("mean", np.mean), ("median", np.median)):
            shown = [f"{value(columns[:, k]):.3f}" for k in range(3)]
            table.append([f"{kind}: {what} of {len(some)}", *shown])
    table.append(["below 0.5", *(str(sum(row[k] < 0.5 for row in rows)) for k in range(3))])
    closed = [find(painted_over(frame)).any() for frame in frames if frame.openings]
    names = ", ".join(sorted((frame.name for frame in frames), key=int))
    note = f"Painted over, so closed: nothing is found in {closed.count(False)} of {len(closed)}."
    return table, f"{note} Frames {names}."


def write_picture(path: Path, image: np.ndarray, truth: np.ndarray, found: np.ndarray) -> None:
    from PIL import Image
    from scipy import ndimage

    path.parent.mkdir(parents=True, exist_ok=True)
    seen = np.stack([np.clip(image, 0, 255).astype(np.uint8)] * 3, axis=-1)
    for mask, colour in ((truth, (60, 220, 60)), (found, (255, 60, 40))):
        seen[mask & ~ndimage.binary_erosion(mask)] = colour
    Image.fromarray(seen).save(path)


if __name__ == "__main__":
    main()
