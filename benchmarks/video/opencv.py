"""What OpenCV would do in the analysis of a recording, beside what does it: error and processor time.

    python -m venv peers && peers/bin/pip install opencv-python-headless
    PYTHONPATH=peers/lib/python3.11/site-packages python -m benchmarks.video.opencv

The endoscope's motion: the films of flow/light.py (which has the true motion), found twice as `plica video`
does, the second time over the stiller region of the steadied frames; root mean square distance from the
truth.
ECC is findTransformECC with a Euclidean motion, told the same region, at the same blurs or the finer alone.
Filters: the same frames, results compared, milliseconds a frame.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator

import contourpy
import cv2
import numpy as np
from scipy import ndimage

from benchmarks.flow.light import LIT, endoscope, filmed
from benchmarks.harness.study import script_parser
from benchmarks.harness.table import show
from plica.synthetic.glottis import SyntheticGlottis
from plica.video.motion.drift import drift, still_region, without_drift

BLURS = (4.0, 1.5)  # px, of video/drift.py
MARGIN = 8  # px
Motion = Callable[[np.ndarray, np.ndarray], np.ndarray]


def by_ecc(frames: np.ndarray, still: np.ndarray, blurs: tuple[float, ...], least: float) -> np.ndarray:
    """(frames, 3) px right, px down, rad, of frames against the first."""
    centre = (np.array(still.shape[::-1]) - 1) / 2
    inside = np.zeros(still.shape, np.uint8)
    inside[MARGIN:-MARGIN, MARGIN:-MARGIN] = 255
    region = np.where(still, inside, 0).astype(np.uint8)
    first = [cv2.GaussianBlur(frames[0], (0, 0), blur) for blur in blurs]
    warp, found = np.eye(2, 3, dtype=np.float32), []
    stop = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 50, least)
    for frame in frames:
        for blur, one in zip(blurs, first, strict=True):
            other = cv2.GaussianBlur(frame, (0, 0), blur)
            _, warp = cv2.findTransformECC(one, other, warp, cv2.MOTION_EUCLIDEAN, stop, region, 1)
        shift = warp[:, :2] @ centre + warp[:, 2] - centre
        found.append([*shift, np.arctan2(warp[1, 0], warp[0, 0])])
    return np.array(found)


def twice(find: Motion, frames: np.ndarray) -> np.ndarray:
    first = find(frames, still_region(frames.std(axis=0)))
    steady = np.stack(list(without_drift(frames, first)))
    return find(frames, still_region(steady.std(axis=0), 0.3))


def motion_rows() -> Iterator[list[str]]:
    methods: dict[str, Motion] = {
        "plica": lambda frames, still: drift(frames, still).motion,
        "ECC, both blurs": lambda frames, still: by_ecc(frames, still, BLURS, 1e-5),
        "ECC, the finer": lambda frames, still: by_ecc(frames, still, BLURS[1:], 1e-4),
    }
    true = endoscope() - endoscope()[0]
    for options in LIT:
        for change in (0.0, 0.04):
            frames = filmed(SyntheticGlottis(options), change).astype(np.float32)
            for name, find in methods.items():
                start = time.process_time()
                off = twice(find, frames) - true
                seconds = time.process_time() - start
                shift = np.sqrt(np.square(off[:, :2]).sum(axis=1).mean())
                turn = np.sqrt(np.mean(off[:, 2] ** 2))
                off_by = [f"{shift:.3f}", f"{turn:.4f}"]
                yield [str(options.seed), f"{100 * change:g} %", name, *off_by, f"{seconds:.2f}"]


def filter_rows() -> Iterator[list[str]]:
    glottis = SyntheticGlottis(LIT[0])
    frames = [glottis.frame(k) for k in range(10)]
    masks = [glottis.mask(k) for k in range(10)]
    y, x = np.ogrid[-3:4, -3:4]
    disc, cross = x * x + y * y <= 9, ndimage.generate_binary_structure(2, 1)

    def whole(array: np.ndarray) -> np.ndarray:
        return np.asarray(array).astype(np.uint8)

    pairs = {
        "opening": (
            lambda k: ndimage.binary_opening(frames[k] >= 200, disc),
            lambda k: cv2.morphologyEx(
                whole(frames[k] >= 200),
                cv2.MORPH_OPEN,
                whole(disc),
                borderType=cv2.BORDER_CONSTANT,
                borderValue=0,
            ),
        ),
        "dilation": (
            lambda k: ndimage.binary_dilation(masks[k], iterations=2),
            lambda k: cv2.dilate(whole(masks[k]), whole(cross), iterations=2),
        ),
        "labels": (
            lambda k: ndimage.label(frames[k] < 60)[1],
            lambda k: cv2.connectedComponents(whole(frames[k] < 60), connectivity=4)[0] - 1,
        ),
        "Gaussian": (
            lambda k: ndimage.gaussian_filter(frames[k].astype(float), 1.5, mode="mirror"),
            lambda k: cv2.GaussianBlur(
                frames[k].astype(float), (13, 13), 1.5, borderType=cv2.BORDER_REFLECT_101
            ),
        ),
        "outline: area over the mask's": (
            lambda k: outlined(contourpy.contour_generator(z=masks[k].astype(float)).lines(0.5), masks[k]),
            lambda k: outlined(
                [
                    np.vstack([line[:, 0], line[:1, 0]]).astype(float)
                    for line in cv2.findContours(whole(masks[k]), cv2.RETR_LIST, cv2.CHAIN_APPROX_NONE)[0]
                ],
                masks[k],
            ),
        ),
    }
    for name, sides in pairs.items():
        found, spent = [], []
        for side in sides:
            start = time.process_time()
            found.append([np.asarray(side(k), float) for k in range(len(frames))])
            spent.append(1000 * (time.process_time() - start) / len(frames))
        apart = max(np.abs(a - b).max() for a, b in zip(*found, strict=True))
        yield [name, f"{spent[0]:.2f}", f"{spent[1]:.2f}", f"{apart:.2g}"]


def outlined(lines: list[np.ndarray], mask: np.ndarray) -> float:
    area = sum(abs(float(np.sum(a[:-1, 0] * a[1:, 1] - a[1:, 0] * a[:-1, 1]))) / 2 for a in lines)
    return area / mask.sum() if mask.any() else 1.0


if __name__ == "__main__":
    script_parser(__doc__).parse_args()
    cv2.setNumThreads(1)
    show(("film", "light", "method", "off (px)", "off (rad)", "processor (s)"), motion_rows())
    print()
    show(("filter", "now (ms)", "OpenCV (ms)", "largest difference"), filter_rows())
