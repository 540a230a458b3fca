"""Motion of the endoscope: how what does not vibrate moves, turns and grows, by frame, and frames without it.

Each frame is aligned to the first: a translation, a small rotation about the frame's centre and a change of
size, as the endoscope comes nearer or is zoomed, that minimise the Huber norm of the brightness difference
over the still region, by Gauss and Newton's iteration on frames blurred coarse to fine. Neighbouring frames
move little, so the motion of one frame is the start for the next. A frame in which the still region does not
look like the first's keeps the motion of the one before it.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from plica.video.errors import VideoError
from plica.video.files.recording import Grey, Recording

__all__ = ["Drift", "Steadied", "drift", "still_region", "without_drift"]

Floats = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

_BLURS = (4.0, 1.5)  # px
_HUBER = 10.0  # grey values of 255
_BLANK = 0.1  # grey values of 255; turned and cut, a frame of one value differs from it by round-off
_SLOWLY = 20.0  # frames, standard deviation: the least in which a picture grows
_ALIKE = 0.5  # correlation with the first frame below which a frame shows another thing


@dataclass(frozen=True)
class Drift:
    """The motion of the picture against the first frame, as the endoscope moves.

    Attributes
    ----------
    motion : (frames, 4)
        Of the picture: right and down, px, clockwise about the centre as seen, rad, and the logarithm of how
        many times as large it is.
    likeness : (frames)
        Correlation of the still region, aligned, with the first frame's.
    """

    motion: Floats
    likeness: Floats

    @classmethod
    def none(cls, frames: Iterable[npt.NDArray[np.floating]]) -> Drift:
        """Of an endoscope that does not move; a frame without contrast is like no other."""
        likeness = np.array([float(np.ptp(frame) > _BLANK) for frame in frames])
        return cls(np.zeros((likeness.size, 4)), likeness)

    @property
    def lost(self) -> Mask:
        """(frames) where the still region is not that of the first frame: the motion is not known."""
        return self.likeness < _ALIKE


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
        Where the still region has too little texture to tell a motion, or looks otherwise than the first
        frame's in more than half of the frames.
    """
    found: list[Floats] = []
    likeness: list[float] = []
    levels: list[_Level] = []
    last = np.zeros(4)
    for frame in frames:
        if not levels:
            levels = [_Level(frame, still, blur) for blur in _BLURS]
        moved, alike = last, 0.0
        for level in levels:
            moved, alike = level.align(frame, moved)
        if alike >= _ALIKE:
            last = moved
        found.append(last)
        likeness.append(alike)
    motion = np.array(found)
    motion[:, 3] = _slow(motion[:, 3])
    made = Drift(motion, np.array(likeness))
    if made.lost.mean() > 0.5:
        raise VideoError(
            f"Drift: {int(made.lost.sum())} of {made.lost.size} frames do not look like the first where "
            "nothing vibrates; must in most. Is the first frame of the same view? Cut the recording, or "
            "leave the correction out (--no-drift)."
        )
    return made


def _slow(values: Floats) -> Floats:
    """(frames) what changes slowly: lines by least squares about each frame, weighted by a Gaussian. Folds
    that open and close look a little like a picture that grows."""
    from scipy import ndimage

    frames = np.arange(values.size, dtype=float)
    moments = [np.ones(values.size), frames, frames**2, values, frames * values]
    one, t, tt, v, tv = (
        ndimage.gaussian_filter1d(part, _SLOWLY, mode="constant", truncate=6.0) for part in moments
    )
    spread = one * tt - t * t
    slope = np.divide(one * tv - t * v, spread, out=np.zeros(values.size), where=spread > 1e-9)
    return np.asarray((v - slope * t) / one + slope * frames)


def without_drift(
    frames: Iterable[npt.NDArray[np.floating]], motion: Floats
) -> Iterator[npt.NDArray[np.float32]]:
    """The frames as a still endoscope would have seen them, by cubic splines."""
    from scipy import ndimage

    for frame, moved in zip(frames, motion, strict=True):
        if not moved.any():
            yield np.asarray(frame, dtype=np.float32)
            continue
        y, x = _moved(frame.shape, moved, *np.mgrid[0 : frame.shape[0], 0 : frame.shape[1]].astype(float))
        seen = ndimage.map_coordinates(np.asarray(frame, dtype=float), [y, x], order=3, mode="mirror")
        yield seen.astype(np.float32)


@dataclass(frozen=True)
class Steadied:
    """A recording as a still endoscope would have seen it, by the motion that was found."""

    recording: Recording
    motion: Floats

    @property
    def count(self) -> int:
        """Frames."""
        return self.recording.count

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width, px."""
        return self.recording.shape

    def frames(self, begin: int = 0) -> Iterator[Grey]:
        """Frames from this one on."""
        return without_drift(self.recording.frames(begin), self.motion[begin:])

    def some(self, wanted: Collection[int]) -> Iterator[tuple[int, Grey]]:
        """Of these frames each with its number, in order; the recording is read once."""
        last = max(wanted, default=-1) + 1
        for index, frame in enumerate(self.recording.frames(0, last)):
            if index in wanted:
                yield index, next(without_drift([frame], self.motion[index : index + 1]))

    def pictures(self, wanted: Collection[int]) -> dict[int, npt.NDArray[np.uint8]]:
        """(h, w, 3) of these frames by number, in the recording's colours: to be looked at, not measured."""
        found = {}
        for index, picture in self.recording.pictures(wanted):
            motion = self.motion[index : index + 1]
            grey = bool((picture[..., 1:] == picture[..., :1]).all())
            parts = np.moveaxis(picture, -1, 0)[: 1 if grey else 3]
            colours = np.stack([next(without_drift([part], motion)) for part in parts], axis=-1)
            seen = np.clip(np.round(colours), 0, 255).astype(np.uint8)
            found[index] = np.repeat(seen, 3, axis=-1) if grey else seen
        return found

    def coloured_lines(self, points: Floats) -> npt.NDArray[np.uint8]:
        """(lines, frames, w, 3) colours at points (lines, w, 2) px, x and y, of each frame, interpolated
        linearly; black beyond the frame. To be looked at, not measured."""
        from scipy import ndimage

        rows = []
        for index, picture in self.recording.pictures(range(self.count)):
            at = _moved(self.shape, self.motion[index], points[..., 1], points[..., 0])
            seen = [ndimage.map_coordinates(part, at, order=1) for part in np.moveaxis(picture, -1, 0)]
            rows.append(np.clip(np.round(np.stack(seen, axis=-1)), 0, 255).astype(np.uint8))
        return np.stack(rows, axis=1)

    def frame(self, index: int) -> Grey:
        """One of them."""
        return next(without_drift(self.recording.frames(index, index + 1), self.motion[index : index + 1]))


def _moved(shape: tuple[int, ...], motion: Floats, y: Floats, x: Floats) -> tuple[Floats, Floats]:
    """Where what is at y, x px in the first frame is in the moved one."""
    cy, cx = (shape[0] - 1) / 2, (shape[1] - 1) / 2
    cos, sin = np.exp(motion[3]) * np.cos(motion[2]), np.exp(motion[3]) * np.sin(motion[2])
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
        apart = round(blur)  # px: a blurred frame says no more between them
        grid = np.zeros(still.shape, dtype=bool)
        grid[8:-8:apart, 8:-8:apart] = True
        self._used = still & grid
        gy, gx = np.gradient(self._first)
        y, x = self._pixels = np.mgrid[0 : still.shape[0], 0 : still.shape[1]].astype(float)
        y, x = y - (still.shape[0] - 1) / 2, x - (still.shape[1] - 1) / 2
        self._slopes = np.stack([gx, gy, gy * x - gx * y, gx * x + gy * y], axis=-1)[self._used]
        normal = self._slopes.T @ self._slopes
        scale = np.sqrt(np.diag(normal))
        if not (scale > 0).all() or np.linalg.cond(normal / np.outer(scale, scale)) > 1e6:
            raise VideoError(
                f"Drift: in frame 0 the {int(self._used.sum())} still pixels have too little texture to tell "
                "the endoscope's motion; must have some. Is that frame blank? Cut it off; else leave the "
                "correction out (--no-drift), or take in more of the frame."
            )

    def align(self, frame: npt.NDArray[np.floating], start: Floats) -> tuple[Floats, float]:
        """The motion, and the correlation with the first frame before its last step."""
        from scipy import ndimage

        image = ndimage.spline_filter(
            ndimage.gaussian_filter(np.asarray(frame, dtype=float), self._blur, mode="mirror")
        )
        motion = start.copy()
        for _ in range(12):
            y, x = _moved(frame.shape, motion, *self._pixels)
            places = [y[self._used], x[self._used]]
            seen = ndimage.map_coordinates(image, places, prefilter=False, mode="mirror")
            error = seen - self._first[self._used]
            error -= np.median(error)  # the light may change
            weights = np.minimum(1.0, _HUBER / np.maximum(np.abs(error), 1e-12))
            weighted = self._slopes * weights[:, None]
            change = np.linalg.solve(weighted.T @ self._slopes, -weighted.T @ error)
            motion += change
            if np.abs(change[:2]).max() < 1e-3 and np.abs(change[2:]).max() < 1e-5:
                break
        return motion, _correlation(seen, self._first[self._used])


def _correlation(one: Floats, other: Floats) -> float:
    """-1 to 1; 0 where one of them is plain."""
    a, b = one - one.mean(), other - other.mean()
    size = float(np.sqrt((a @ a) * (b @ b)))
    return float(a @ b) / size if size > 0 else 0.0
