"""Motion of the endoscope: the rigid motion of what does not vibrate, by frame, and frames without it.

Each frame is aligned to the first: a translation and a small rotation about the frame's centre that minimise
the Huber norm of the brightness difference over the still region, by Gauss and Newton's iteration on frames
blurred coarse to fine. Neighbouring frames move little, so the motion of one frame is the start for the next.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np
import numpy.typing as npt

from plica.video.errors import VideoError

__all__ = ["Drift", "drift", "still_region", "without_drift"]

Floats = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]
Drift = npt.NDArray[np.float64]
"""(frames, 3): right and down, px, and clockwise about the centre as seen, rad, against the first frame."""

_BLURS = (4.0, 1.5)  # px
_HUBER = 10.0  # grey values of 255


def still_region(spread: Floats, share: float = 0.5) -> Mask:
    """(h, w) the `share` of all pixels that vary least (`spread`: standard deviation over the frames)."""
    from scipy import ndimage

    smooth = ndimage.gaussian_filter(spread, 0.02 * max(spread.shape))
    return np.asarray(smooth <= np.quantile(smooth, share))


def drift(frames: Iterable[npt.NDArray[np.floating]], still: Mask) -> Drift:
    """The endoscope's motion against the first frame.

    Parameters
    ----------
    frames : (h, w) each, grey values of 255
    still : (h, w) bool
        Pixels that do not vibrate.

    Raises
    ------
    VideoError
        Where the still region has too little texture to tell a motion.
    """
    found: list[Floats] = []
    levels: list[_Level] = []
    motion = np.zeros(3)
    for frame in frames:
        if not levels:
            levels = [_Level(frame, still, blur) for blur in _BLURS]
        for level in levels:
            motion = level.align(frame, motion)
        found.append(motion.copy())
    return np.array(found)


def without_drift(
    frames: Iterable[npt.NDArray[np.floating]], motion: Drift
) -> Iterator[npt.NDArray[np.float32]]:
    """The frames as a still endoscope would have seen them, by cubic splines."""
    from scipy import ndimage

    for frame, moved in zip(frames, motion, strict=True):
        if not moved.any():
            yield np.asarray(frame, dtype=np.float32)
            continue
        y, x = _moved(frame.shape, moved)
        seen = ndimage.map_coordinates(np.asarray(frame, dtype=float), [y, x], order=3, mode="mirror")
        yield seen.astype(np.float32)


def _moved(shape: tuple[int, ...], motion: Floats) -> tuple[Floats, Floats]:
    """Where each pixel of the first frame is in the moved one."""
    y, x = np.mgrid[0 : shape[0], 0 : shape[1]].astype(float)
    cy, cx = (shape[0] - 1) / 2, (shape[1] - 1) / 2
    cos, sin = np.cos(motion[2]), np.sin(motion[2])
    return (
        cy + sin * (x - cx) + cos * (y - cy) + motion[1],
        cx + cos * (x - cx) - sin * (y - cy) + motion[0],
    )


class _Level:
    """The first frame at one blur, with what an alignment to it needs."""

    def __init__(self, first: npt.NDArray[np.floating], still: Mask, blur: float) -> None:
        from scipy import ndimage

        self._blur = blur
        self._first = ndimage.gaussian_filter(np.asarray(first, dtype=float), blur, mode="mirror")
        rim = np.zeros(still.shape, dtype=bool)
        rim[8:-8, 8:-8] = True
        self._used = still & rim
        gy, gx = np.gradient(self._first)
        y, x = np.mgrid[0 : still.shape[0], 0 : still.shape[1]].astype(float)
        y, x = y - (still.shape[0] - 1) / 2, x - (still.shape[1] - 1) / 2
        self._slopes = np.stack([gx, gy, gy * x - gx * y], axis=-1)[self._used]
        normal = self._slopes.T @ self._slopes
        scale = np.sqrt(np.diag(normal))
        if not (scale > 0).all() or np.linalg.cond(normal / np.outer(scale, scale)) > 1e6:
            raise VideoError(
                f"Drift: the {int(self._used.sum())} still pixels have too little texture to tell the "
                "endoscope's motion; must have some. Leave the correction out (--no-drift), or take in more "
                "of the frame."
            )

    def align(self, frame: npt.NDArray[np.floating], start: Floats) -> Floats:
        from scipy import ndimage

        image = ndimage.spline_filter(
            ndimage.gaussian_filter(np.asarray(frame, dtype=float), self._blur, mode="mirror")
        )
        motion = start.copy()
        for _ in range(12):
            y, x = _moved(frame.shape, motion)
            places = [y[self._used], x[self._used]]
            error = (
                ndimage.map_coordinates(image, places, prefilter=False, mode="mirror")
                - self._first[self._used]
            )
            error -= np.median(error)  # the light may change
            weights = np.minimum(1.0, _HUBER / np.maximum(np.abs(error), 1e-12))
            weighted = self._slopes * weights[:, None]
            change = np.linalg.solve(weighted.T @ self._slopes, -weighted.T @ error)
            motion += change
            if np.abs(change[:2]).max() < 1e-3 and abs(change[2]) < 1e-5:
                break
        return motion
