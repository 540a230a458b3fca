"""Flow on real tissue with known motion: frames of a recording, moved as folds part, with noise.

    python -m benchmarks.flow.planted larynx.mp4

Frames of the recording (without its own motion), blurred by 1 px, are moved by up to 1.6 px away from the
midline, falling to 1 / e over 25 px and towards the ends of the midline, opposite on its two sides; both
frames of a pair get noise of their own. For each preset, the mean distance (px) from the true flow on tissue
that moves by more than a tenth of a pixel and is 5 px or more from the midline and from highlights.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from scipy import ndimage

from benchmarks.harness.study import record, script_parser
from plica.video.analysis import analyse
from plica.video.glottis.midline import Midline, pixels
from plica.video.motion.flow import PRESETS, flow
from plica.video.motion.frame_content import Seen

NOISE = (0.0, 2.0, 5.0)  # standard deviation, grey levels of 255
FRAMES = 4
LARGEST, REACH = 1.6, 25.0  # px

Pair = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]  # two frames; mask used, mask evaluated


def motion(points: np.ndarray, midline: Midline) -> np.ndarray:
    """(..., 2) px, where a point of the second frame came from, subtracted from it."""
    along, off = np.moveaxis(midline.place(points), -1, 0)
    share = np.clip(along / midline.length, 0, 1)
    size = LARGEST * 4 * share * (1 - share) * np.exp(-np.abs(off) / REACH) * np.sign(off)
    return size[..., None] * midline.across


def main() -> None:
    parser = script_parser(__doc__)
    parser.add_argument("recording", type=Path)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        found = analyse(options.recording, folder, until="glottis", progress=False)
        steady, midline = found.frames(), found.midline
        chosen = np.linspace(0, found.count - 1, FRAMES).round().astype(int).tolist()
        frames = [np.clip(steady.frame(k), 0, 255).astype(float) for k in chosen]
        glottis = [found.mask(k) for k in chosen]

    place = pixels(frames[0].shape)
    truth = np.zeros_like(place)
    for _ in range(60):  # u(x) = motion(x + u(x))
        truth = motion(place + truth, midline)
    source = place - motion(place, midline)
    pairs = []
    for frame, mask in zip(frames, glottis, strict=True):
        first = ndimage.gaussian_filter(frame, 1.0)
        second = ndimage.map_coordinates(first, [source[..., 1], source[..., 0]], order=5, mode="mirror")
        torn = np.abs(midline.place(place)[..., 1]) < 5
        used = Seen(first, mask).tissue & ~torn
        pairs.append((first, second, used, used & (np.hypot(*np.moveaxis(truth, -1, 0)) > 0.1)))
    columns = ["preset", *(f"noise {noise:g}" for noise in NOISE)]
    record("flow_planted", columns, rows(pairs, truth), "Mean distance from the true flow, px.")


def rows(pairs: list[Pair], truth: np.ndarray) -> Iterator[list[str]]:
    random = np.random.default_rng(1)
    for preset in PRESETS:
        cells = []
        for noise in NOISE:
            errors = []
            for first, second, used, counted in pairs:
                one, other = (
                    image + noise * random.standard_normal(image.shape) for image in (first, second)
                )
                seen = flow(one, other, preset=preset, mask=used, intensity=(0.0, 255.0)).flow
                errors.append(np.hypot(*np.moveaxis(seen - truth, -1, 0))[counted].mean())
            cells.append(f"{np.mean(errors):.3f}")
        yield [preset, *cells]
    moved = np.mean([np.hypot(*np.moveaxis(truth, -1, 0))[counted].mean() for *_, counted in pairs])
    yield ["no motion", *[f"{moved:.3f}"] * len(NOISE)]


if __name__ == "__main__":
    main()
