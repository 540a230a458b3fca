"""What a report's pictures are made of: a cycle in pictures, kymograms with the edges, the mean cycle."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes

from plica.video.analysis import Analysis

__all__ = [
    "Kymogram",
    "MeanCycle",
    "Pose",
    "about",
    "cycle_poses",
    "kymograms",
    "mean_cycle",
    "paint_pose",
    "row_height",
]

Floats = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]
Bytes = npt.NDArray[np.uint8]

outline = "#ff8c28"
_ROOM = 1.5  # of the folds' largest way from the midline: what a kymogram shows on either side
_LEAST = 8.0  # px
_PHASES = 200


@dataclass(frozen=True)
class Pose:
    """The glottis in one frame: time since the cycle began, picture (h, w, 3) and mask (h, w) about it."""

    passed: float
    picture: Bytes
    mask: Mask


def about(found: Analysis, beside: float, beyond: float) -> tuple[slice, slice]:
    """Rows and columns about the midline: so many of its lengths beside it and beyond its ends."""
    height, width = found.frames().shape
    line = found.midline
    x, y = np.sort([line.upper[0], line.lower[0]]), np.sort([line.upper[1], line.lower[1]])
    beside, beyond = beside * line.length, beyond * line.length
    return (
        slice(max(int(y[0] - beyond), 0), min(int(y[1] + beyond) + 1, height)),
        slice(max(int(x[0] - beside), 0), min(int(x[1] + beside) + 1, width)),
    )


def cycle_poses(found: Analysis, instants: Floats) -> list[Pose]:
    """The frames from these shares of the middle one of the cycles on, in the recording's colours."""
    cycles = found.cycles
    begin, end = cycles.starts[cycles.count // 2 : cycles.count // 2 + 2]
    step = found.time[1] - found.time[0]
    frames = np.ceil((begin + instants * (end - begin)) / step - 1e-9).astype(int)
    frames = np.unique(np.clip(frames, 0, found.count - 1))
    box = about(found, 0.35, 0.1)
    pictures = found.frames().pictures(set(frames.tolist()))
    return [Pose(float(found.time[k] - begin), pictures[k][box], found.mask(k)[box]) for k in frames.tolist()]


def paint_pose(axes: Axes, pose: Pose) -> None:
    """The picture with the outline of the glottis."""
    axes.imshow(pose.picture)
    if pose.mask.any() and not pose.mask.all():
        axes.contour(pose.mask, levels=[0.5], colors=[outline], linewidths=0.8)
    axes.set(xticks=[], yticks=[])
    axes.spines[:].set_visible(False)


def row_height(poses: list[Pose], width: float) -> float:
    """Inches of a row of poses that is so wide, with their titles."""
    tallest: float = max(pose.picture.shape[0] / pose.picture.shape[1] for pose in poses)
    return 0.4 + tallest * width / len(poses)


@dataclass(frozen=True)
class Kymogram:
    """A line across the midline, frame by frame.

    Attributes
    ----------
    place : float
        Along the midline, 0 at its upper end.
    picture : (w, frames, 3)
        From the image's left (first row) to its right.
    edges : (2, frames) px
        Of the left and of the right fold from the midline; not a number where they are not known.
    half : float
        px shown on either side of the midline: the slit at its widest, and half as much again.
    """

    place: float
    picture: Bytes
    edges: Floats
    half: float

    def paint(self, axes: Axes, time: Floats, size: float, unit: str, *, mirrored: bool = False) -> None:
        """The picture over the frames' times, a pixel being `size` units; `mirrored` with the right above."""
        rows, step = self.picture.shape[0], time[1] - time[0]
        extent = (time[0] - 0.5 * step, time[-1] + 0.5 * step, 0.5 * size * rows, -0.5 * size * rows)
        axes.imshow(self.picture[::-1] if mirrored else self.picture, aspect="auto", extent=extent)
        above, below = self.edges[::-1] if mirrored else self.edges
        for way in (-above, below):
            axes.plot(time, size * way, color=outline, lw=0.7)
        axes.set_ylim(size * self.half, -size * self.half)
        axes.set_ylabel(f"across ({unit})")


def kymograms(found: Analysis) -> list[Kymogram]:
    """At the places of the settings, in the recording's colours."""
    stored, places, line = found["sides/kymogram"], found.settings.places, found.midline
    half = (stored.shape[2] - 1) // 2
    if found.frames().recording.coloured:
        along, across = line.length * np.asarray(places), np.arange(-half, half + 1.0)
        points = line.points(np.stack(np.meshgrid(along, across, indexing="ij"), axis=-1))
        pictures = found.frames().coloured_lines(points)
    else:
        grey = np.clip(np.round(stored), 0, 255).astype(np.uint8)
        pictures = np.repeat(grey[..., None], 3, axis=-1)
    rows = found.vibrogram.shape[1]
    edges = [found.vibrogram[:, min(int(place * rows), rows - 1)] for place in places]
    widest = max((float(np.nanmax(ways)) for ways in edges if np.isfinite(ways).any()), default=0.0)
    shown = min(max(_ROOM * widest, _LEAST), half + 0.5)
    return [
        Kymogram(place, picture.swapaxes(0, 1), ways, shown)
        for place, picture, ways in zip(places, pictures, edges, strict=True)
    ]


@dataclass(frozen=True)
class MeanCycle:
    """The glottal area over the share of a cycle that has passed.

    Attributes
    ----------
    phase : (k)
        From 0 to 1.
    mean, spread : (k)
        Over the cycles used: mean and standard deviation, in px^2.
    """

    phase: Floats
    mean: Floats
    spread: Floats


def mean_cycle(found: Analysis) -> MeanCycle:
    """Of the cycles over which measures are taken."""
    phase, cycles, area = np.linspace(0, 1, _PHASES + 1), found.cycles, found.area.filled().total
    used = [k for k in range(cycles.count) if k not in cycles.left_out]
    rows = np.array([np.interp(cycles.starts[k] + phase * cycles.periods[k], found.time, area) for k in used])
    return MeanCycle(phase, rows.mean(axis=0), rows.std(axis=0, ddof=1))
