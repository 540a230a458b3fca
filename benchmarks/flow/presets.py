"""Optical flow between rendered pictures whose motion is known, and the glottis in rendered frames."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache, partial
from math import cos, sin

import numpy as np
from numpy.typing import NDArray

from benchmarks.harness.case import Case, Claim, Method
from benchmarks.harness.case_record import Level
from benchmarks.harness.claims import at_most
from plica import _engine as engine

__all__ = ["CASES"]

Array = NDArray[np.float64]
Grey = NDArray[np.float32]
Mask = NDArray[np.bool_]

SHORTEST, WAVES, SWING = 0.9, 10, 12.0  # rad/px; of a texture; grey levels of each
NOISE = 1.0  # grey levels
SMOOTH = np.array([[0.02, -0.03], [0.01, -0.015]]), np.array([1.4, -0.7])  # slopes, px
LAYERS = np.array([-1.7, 0.6]), np.array([2.6, 1.3])  # px: what is behind, and the disc before it
BORDER = 8  # px, which leave the frame
FRAMES = 12  # of one cycle of the glottis


def _texture(x: Array, y: Array, seed: int) -> Array:
    """Grey levels at places (px): waves of 7 to 50 px in all directions."""
    random = np.random.default_rng(seed)
    total = np.full(x.shape, 128.0)
    for k in range(WAVES):
        number, direction, phase = SHORTEST * 0.8**k, *random.uniform(-np.pi, np.pi, 2)
        total += SWING * np.sin(number * (cos(direction) * x + sin(direction) * y) + phase)
    return total


@lru_cache(maxsize=1)
def _pair(scene: str, pixels: int) -> tuple[Grey, Grey, Array]:
    """Two frames, and the motion (h, w, 2) of what the first one shows, px."""
    y, x = np.mgrid[:pixels, :pixels] - 0.5 * (pixels - 1)
    if scene == "smooth":
        slopes, shift = SMOOTH
        slopes = slopes * 192 / pixels  # the same motion at the border whatever the size
        back = np.linalg.inv(np.eye(2) + slopes)
        x0, y0 = np.einsum("ij,jkl->ikl", back, np.stack([x - shift[0], y - shift[1]]))
        frames = _texture(x, y, 1), _texture(x0, y0, 1)
        motion = np.moveaxis(np.einsum("ij,jkl->ikl", slopes, np.stack([x, y])) + shift[:, None, None], 0, -1)
    else:
        behind, before = LAYERS
        radius = 0.3 * pixels
        disc = [np.hypot(x - shift[0], y - shift[1]) < radius for shift in (np.zeros(2), before)]
        frames = (
            np.where(disc[0], _texture(x, y, 2), _texture(x, y, 3)),
            np.where(
                disc[1],
                _texture(x - before[0], y - before[1], 2),
                _texture(x - behind[0], y - behind[1], 3),
            ),
        )
        motion = np.where(disc[0][..., None], before, behind)
    random = np.random.default_rng(pixels)
    noisy = (frame + NOISE * random.standard_normal(x.shape) for frame in frames)
    first, second = (np.clip(frame, 0, 255).astype(np.float32) for frame in noisy)
    return first, second, motion


def _frames(level: Level) -> tuple[Grey, Grey, Array]:
    return _pair(str(level["scene"]), int(level["pixels"]))


def _plica_flow(preset: str, level: Level) -> Callable[[], Array]:
    from plica.video.motion.flow import flow

    first, second, _ = _frames(level)
    return lambda: np.asarray(flow(first, second, preset=preset).flow, float)


def _opencv_flow(name: str, level: Level) -> Callable[[], Array]:
    import cv2

    cv2.setNumThreads(engine.threads())
    if name == "Farneback":
        method = cv2.FarnebackOpticalFlow_create()
    else:
        method = cv2.DISOpticalFlow_create(getattr(cv2, f"DISOPTICAL_FLOW_PRESET_{name.upper()}"))
    first, second = (np.round(frame).astype(np.uint8) for frame in _frames(level)[:2])  # it takes 8 bits
    return lambda: np.asarray(method.calc(first, second, None), float)


def _scikit_image_flow(name: str, level: Level) -> Callable[[], Array]:
    from skimage.registration import optical_flow_ilk, optical_flow_tvl1

    method = optical_flow_tvl1 if name == "TV-L1" else optical_flow_ilk
    first, second = (frame / 255 for frame in _frames(level)[:2])
    return lambda: np.stack(method(first, second)[::-1], axis=-1)  # it gives rows before columns


def _flow_errors(level: Level, found: Array, truth: Array) -> dict[str, float]:
    inner = (slice(BORDER, -BORDER), slice(BORDER, -BORDER))
    off = np.hypot(*np.moveaxis((found - truth)[inner], -1, 0))
    return {"end point": float(off.mean()), "worst tenth": float(np.quantile(off, 0.9))}


PRESETS = ("gradient", "robust", "fast", "reference", "thesis", "video")
OPENCV = ("DIS ultrafast", "DIS fast", "DIS medium", "Farneback")


@lru_cache(maxsize=1)
def _film(pixels: int, noise: float) -> tuple[list[Grey], list[Mask]]:
    """Frames of a cycle in which the glottis is open, and where it is."""
    from plica.synthetic.glottis import Synthetic, SyntheticGlottis

    share = pixels / 256
    glottis = SyntheticGlottis(
        Synthetic(
            height=pixels,
            width=pixels,
            frames=FRAMES,
            frequency=1 / FRAMES,
            amplitude=(9 * share, 9 * share),
            opening=(11 * share, 11 * share),
            reach=25 * share,
            noise=noise,
            seed=5,
        )
    )
    return [glottis.frame(t) for t in range(FRAMES)], [glottis.mask(t) for t in range(FRAMES)]


def _pictures(level: Level) -> tuple[list[Grey], list[Mask]]:
    return _film(int(level["pixels"]), float(level["noise"]))


def _plica_masks(level: Level) -> Callable[[], list[Mask]]:
    from plica.video.glottis.frame_segmentation import segment

    frames, _ = _pictures(level)
    return lambda: [segment(frame).mask for frame in frames]


def _scikit_image_masks(name: str, level: Level) -> Callable[[], list[Mask]]:
    """The darkest of Otsu's three classes, or a Chan-Vese contour; of these the part nearest the middle."""
    from skimage.filters import gaussian, threshold_multiotsu
    from skimage.measure import label, regionprops
    from skimage.segmentation import morphological_chan_vese

    def middle(dark: Mask) -> Mask:
        labels = label(dark)
        centre = 0.5 * np.array(dark.shape)
        parts = [part for part in regionprops(labels) if part.area > 2e-4 * dark.size]
        if not parts:
            return np.zeros(dark.shape, bool)
        nearest = min(parts, key=lambda part: float(np.linalg.norm(np.array(part.centroid) - centre)))
        return np.asarray(labels == nearest.label)

    def dark(frame: Grey) -> Mask:
        smooth = gaussian(frame, 1.0)
        if name == "multi-Otsu":
            return np.asarray(smooth < threshold_multiotsu(smooth)[0])
        inside = morphological_chan_vese(smooth, 60).astype(bool)
        return np.asarray(inside if smooth[inside].mean() < smooth[~inside].mean() else ~inside)

    frames, _ = _pictures(level)
    return lambda: [middle(dark(frame)) for frame in frames]


def _mask_errors(level: Level, found: Sequence[Mask], truth: Sequence[Mask]) -> dict[str, float]:
    overlap = [2 * (a & b).sum() / (a.sum() + b.sum()) for a, b in zip(found, truth, strict=True)]
    areas = [abs(a.sum() / b.sum() - 1) for a, b in zip(found, truth, strict=True)]
    return {"overlap": float(1 - np.mean(overlap)), "area": float(np.mean(areas))}


def _flow_levels(scenes: Sequence[str], sizes: Sequence[int]) -> tuple[Level, ...]:
    return tuple({"scene": scene, "pixels": pixels} for scene in scenes for pixels in sizes)


CASES = (
    Case(
        name="flow",
        does="Motion between two square frames with noise of one grey level: of a texture that is stretched "
        "and turned (smooth), of a disc before what moves the other way (layers).",
        reference="the motion they were rendered with, away from the border",
        errors={
            "end point": "mean distance, px",
            "worst tenth": "distance that a tenth of the pixels exceeds, px",
        },
        levels={
            "small": _flow_levels(("smooth",), (64,)),
            "full": _flow_levels(("smooth", "layers"), (96, 192, 384)),
        },
        methods=(
            *(Method(f"plica, {preset}", partial(_plica_flow, preset)) for preset in PRESETS),
            *(
                Method(f"OpenCV, {name}", partial(_opencv_flow, name.removeprefix("DIS ")), "cv2", "opencv")
                for name in OPENCV
            ),
            *(
                Method(f"scikit-image, {name}", partial(_scikit_image_flow, name), "skimage", "scikit-image")
                for name in ("TV-L1", "ILK")
            ),
        ),
        truth=lambda level: _frames(level)[2],
        judge=_flow_errors,
        problem=("scene", "pixels"),
        claims=(
            Claim(
                "plica's default is within a third of a pixel in the mean",
                at_most("plica, robust", 1 / 3, "end point"),
            ),
        ),
    ),
    Case(
        name="segmentation",
        does=f"The glottis in {FRAMES} frames of a rendered cycle, each frame by itself.",
        reference="where it was rendered",
        errors={"overlap": "one less Dice's coefficient, mean", "area": "relative, mean"},
        levels={
            "small": ({"pixels": 96, "noise": 2.0},),
            "full": tuple(
                {"pixels": pixels, "noise": noise} for noise in (2.0, 10.0) for pixels in (128, 256)
            ),
        },
        methods=(
            Method("plica", _plica_masks),
            *(
                Method(f"scikit-image, {name}", partial(_scikit_image_masks, name), "skimage", "scikit-image")
                for name in ("multi-Otsu", "Chan-Vese")
            ),
        ),
        truth=lambda level: _pictures(level)[1],
        judge=_mask_errors,
        problem=("noise", "pixels"),
        claims=(
            Claim(
                "plica's overlap is 0.9 or more at 256 pixels", at_most("plica", 0.1, "overlap", pixels=256)
            ),
            Claim("plica's overlap is 0.85 or more everywhere", at_most("plica", 0.15, "overlap")),
        ),
        threads=(1,),
    ),
)
