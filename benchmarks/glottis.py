"""Segmentation of single laryngeal frames against masks drawn by experts: intersection over union.

    python benchmarks/glottis.py ../shared/data/laryngeal/bagls_mini
    python benchmarks/glottis.py ../shared/data/laryngeal/bagls_mini --pictures failures

Each frame stands alone here; in a recording the motion tells where the glottis is, and every frame has the
same two grey levels. Two empty masks agree completely (1), an empty one with another not at all (0). Beside
what is found without help stands what help makes of it, by its cost: a region of 10 px about the glottis (two
clicks; as --region), and a mask drawn with eight clicks along the outline of each part (as --masks). Where
the glottis is closed, help is to say so.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from plica.video.image_file import read_image
from plica.video.segmentation import segment

_MARGIN = 10  # px about the glottis
_CLICKS = 8


def overlap(one: np.ndarray, other: np.ndarray) -> float:
    """Intersection over union; 1 for two empty masks."""
    union = (one | other).sum()
    return float((one & other).sum() / union) if union else 1.0


def in_region(image: np.ndarray, truth: np.ndarray) -> np.ndarray:
    """The glottis found in a rectangle about the true one; nothing where there is none."""
    found = np.zeros_like(truth)
    if truth.any():
        rows, columns = np.flatnonzero(truth.any(axis=1)), np.flatnonzero(truth.any(axis=0))
        cut = np.s_[
            max(rows[0] - _MARGIN, 0) : rows[-1] + _MARGIN + 1,
            max(columns[0] - _MARGIN, 0) : columns[-1] + _MARGIN + 1,
        ]
        found[cut] = segment(image[cut]).mask
    return found


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
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", type=Path, help="with N.png and N_seg.png")
    parser.add_argument("--pictures", type=Path, help="write frames below 0.5 there: true green, found red")
    options = parser.parse_args()
    rows = []
    for path in sorted(options.folder.glob("*_seg.png")):
        name = path.name.removesuffix("_seg.png")
        truth = read_image(path) > 127
        image = read_image(path.with_name(f"{name}.png"))
        found = segment(image).mask
        overlaps = [overlap(truth, mask) for mask in (found, in_region(image, truth), clicked(truth))]
        rows.append((*overlaps, name, int(truth.sum()), int(found.sum())))
        if options.pictures and overlaps[0] < 0.5:
            write_picture(options.pictures / f"{name}.png", image, truth, found)
    print(
        "| frame | alone | region | eight clicks | true (px) | found (px) |\n"
        "| --- | --- | --- | --- | --- | --- |"
    )
    for alone, region, clicks, name, true, area in sorted(rows):
        if alone < 0.5:
            print(f"| {name} | {alone:.2f} | {region:.2f} | {clicks:.2f} | {true} | {area} |")
    for what, value in (("mean", np.mean), ("median", np.median)):
        print(
            f"| {what} of {len(rows)} | "
            + " | ".join(f"{value([r[k] for r in rows]):.2f}" for k in range(3))
            + " | | |"
        )
    print("| below 0.5 | " + " | ".join(str(sum(row[k] < 0.5 for row in rows)) for k in range(3)) + " | | |")


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
