"""The observation from a recording: points of the tissue surface, tracked through the frames."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plica import _engine
from plica.camera.pose import Camera
from plica.errors import InvalidInput
from plica.identify.observation.observation import Observation, SurfacePoints
from plica.identify.observation.paths import correlation_length, follow_points
from plica.identify.observation.placement import Placement, place
from plica.identify.observation.recording_warnings import recording_warnings
from plica.identify.observation.sources import PixelMotion
from plica.identify.settings import Settings
from plica.scene.scene import Scene

__all__ = ["Recorded", "observe", "surface_points"]

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

STATED_SD = 0.1
"""[px] Default sd, if neither the settings nor the recording give one."""
FLOOR = 0.02
"""[px] Least sd of a flow, added in quadrature to that of the trust map."""
_LEAST_PRESSURES = 48
"""Least number of unknown pressures before a recording: they determine the states of 24 modes."""
_LEAST_SPACING = 8.0  # px
_LEAST_FACING = 0.5  # cosine of the angle between the normal and the line of sight: 60 degrees
_LEAST_VISIBLE = 0.5  # share of the frames in which a point must be visible


@dataclass(frozen=True)
class Recorded:
    """A recording in the form that the estimator uses.

    Attributes
    ----------
    observation : Observation
        N frames: `lead` missing ones, then those of the recording that are used.
    placement : Placement
    start : (r, 2) px, column and row of the points in the first frame
    spacing : px, between points
    correlation : px, correlation length of the flow's error; None if unknown
    lead : number of frames before the recording
    first : index of the first frame of the recording that is used
    rest : (r, 2) px, position of the points at rest
    notes : assumptions that were made
    computed_flow : whether the flow was computed from images, so that its error is learned from residuals
    """

    observation: Observation
    placement: Placement
    start: Floats
    spacing: float
    correlation: float | None
    lead: int
    first: int
    rest: Floats
    notes: tuple[str, ...]
    computed_flow: bool = False

    def on(self, mesh: _engine.TetMesh, seen: str) -> Recorded:
        """The same points on the surface `seen` of another mesh of the same shape."""
        points = SurfacePoints.seen(mesh, seen, self.placement.camera, self.rest)
        return replace(self, observation=replace(self.observation, points=points))


def observe(
    motion: PixelMotion,
    settings: Settings,
    scene: Scene,
    mesh: _engine.TetMesh,
    seen: str,
    progress: bool = False,
) -> Recorded:
    """Track points of the surface `seen` of a mesh through the frames of a recording.

    A point is a material point: its position in the image changes with the flow, its position in the mesh
    does not. Where its flow is not reliable its motion is missing; once its position is unknown it is lost.

    Raises InvalidInput if the recording is too short, shows no motion, or no point of the surface.
    """
    fps = settings.fps or motion.fps
    if fps is None:
        raise InvalidInput(
            f"identify: the frame rate is not in {motion.name}; must be known. Give --fps, the rate of "
            "recording and not of playback."
        )
    first, pairs = _pairs(motion, settings)
    if settings.spacing is not None and settings.spacing > min(motion.shape):
        raise InvalidInput(
            f"identify: spacing = {settings.spacing:g} px; must be <= {min(motion.shape)} px, the shorter "
            "side of the image."
        )
    placement = place(motion, settings, scene, mesh, seen)
    correlation = _correlation(motion, pairs)
    spacing = settings.spacing or max(_LEAST_SPACING, correlation or 0.0)
    start = _grid(motion.shape, spacing) if settings.points is None else _given_points(motion, settings)
    paths, flow, errors = follow_points(motion, pairs, start, progress)
    there = np.isfinite(flow).all(axis=2).mean(axis=0) >= _LEAST_VISIBLE
    rest = paths[0] if settings.from_rest else _mean(paths)
    on_surface = surface_points(mesh, seen, placement.camera, rest)
    if settings.points is not None and not np.all(on_surface):
        k = int(np.argmin(on_surface))
        raise InvalidInput(
            f"identify: points[{k}] = [{start[k, 0]:g}, {start[k, 1]:g}] px; must show the surface "
            f'"{seen}" of the mesh. Check --centre, --roll and --mm-per-px.'
        )
    if not on_surface.any():
        raise InvalidInput(
            f'identify: number of points that show the surface "{seen}" = 0; must be >= 1. Is the camera '
            "pose right (--centre, --roll, --mm-per-px)?"
        )
    kept = np.flatnonzero(on_surface & there)
    if not len(kept):
        raise InvalidInput(
            f"identify: number of points visible in {_LEAST_VISIBLE:.0%} of the frames = 0; must be >= 1. "
            "Use fewer frames (--from, --to), or a recording with a reliable flow in px per frame."
        )
    if settings.points is None:
        kept, spacing = _thinned(kept, start, spacing, settings.most_points)
    flow, errors = flow[:, kept], errors[:, kept]
    lead = 0 if settings.from_rest else max(_least_lead(settings), round(settings.lead * fps))
    closed = _closed(motion, pairs, settings)
    observation = Observation(
        SurfacePoints.seen(mesh, seen, placement.camera, rest[kept]),
        placement.camera,
        np.concatenate([np.full((lead, *flow.shape[1:]), np.nan), flow]),
        sd=_sd(errors, settings, motion, lead),
        frame_rate=fps,
        closed=np.concatenate([np.zeros(lead, dtype=bool), closed]),
        tilt_sd=placement.tilt_sd,
    )
    return Recorded(
        observation,
        placement,
        start[kept],
        spacing,
        correlation,
        lead,
        first,
        rest[kept],
        placement.notes + recording_warnings(motion, settings),
        computed_flow=motion.error is not None,
    )


def surface_points(mesh: _engine.TetMesh, seen: str, camera: Camera, pixels: Floats) -> Mask:
    """(r) Whether each pixel (r, 2), column and row, shows the surface at less than 60 degrees."""
    points, there = SurfacePoints.met(mesh, seen, camera, pixels)
    a, b, c = np.moveaxis(np.asarray(mesh.points)[points.nodes[:, :3]], 1, 0)
    normal = np.cross(b - a, c - a)
    there[there] = normal @ camera.axes[2] >= _LEAST_FACING * np.linalg.norm(normal, axis=1)
    return there


def _pairs(motion: PixelMotion, settings: Settings) -> tuple[int, range]:
    last = motion.pairs if settings.last is None else settings.last
    if last > motion.pairs or settings.first > last - 2:
        raise InvalidInput(
            f"identify: frames {settings.first} to {last}; must be three or more in [0, {motion.pairs}], the "
            f"frames of {motion.name}."
        )
    return settings.first, range(settings.first, last)


def _correlation(motion: PixelMotion, pairs: range) -> float | None:
    if motion.error is None:
        return None
    chosen = np.unique(np.linspace(pairs[0], pairs[-1], min(8, len(pairs))).round().astype(int))
    error = motion.error
    return correlation_length(error(int(k))[..., c] for k in chosen for c in (0, 1))


def _grid(shape: tuple[int, int], spacing: float) -> Floats:
    height, width = shape
    x, y = np.meshgrid(
        np.arange(spacing / 2, width - 1, spacing), np.arange(spacing / 2, height - 1, spacing)
    )
    return np.column_stack([x.ravel(), y.ravel()])


def _given_points(motion: PixelMotion, settings: Settings) -> Floats:
    points = np.array(settings.points, dtype=float)
    height, width = motion.shape
    outside = ~((points >= 0) & (points <= [width - 1, height - 1])).all(axis=1)
    if outside.any():
        k = int(np.argmax(outside))
        raise InvalidInput(
            f"identify: points[{k}] = [{points[k, 0]:g}, {points[k, 1]:g}] px; must be in the image of "
            f"{width} x {height} px."
        )
    return points


def _thinned(kept: NDArray[Any], start: Floats, spacing: float, most: int) -> tuple[NDArray[Any], float]:
    """Every second, third, ... column and row of the grid, so that there are at most `most` points."""
    stride = 1
    column, row = (np.round((start[kept] - spacing / 2) / spacing).astype(int)).T
    while True:
        chosen = (column % stride == stride // 2) & (row % stride == stride // 2)
        if chosen.sum() <= most and chosen.any():
            return kept[chosen], spacing * stride
        if not chosen.any():
            return kept[np.linspace(0, len(kept) - 1, most).astype(int)], spacing
        stride += 1


def _closed(motion: PixelMotion, pairs: range, settings: Settings) -> Mask:
    """(N) Pairs in which the glottis of either frame is closed."""
    if motion.area is None or not settings.closed_below:
        return np.zeros(len(pairs), dtype=bool)
    area = motion.area[pairs[0] : pairs[-1] + 2]
    known = np.flatnonzero(np.isfinite(area))
    if not known.size:
        return np.zeros(len(pairs), dtype=bool)
    closed = area < settings.closed_below * area[known].max()
    # Between known frames, the glottis is closed if it is in either: forces there must not be left out.
    before, after = (
        np.searchsorted(known, np.arange(area.size), "right") - 1,
        np.searchsorted(known, np.arange(area.size)),
    )
    last = known.size - 1
    closed |= closed[known[np.clip(before, 0, last)]] | closed[known[np.clip(after, 0, last)]]
    return np.asarray(closed[:-1] | closed[1:])


def _sd(errors: Floats, settings: Settings, motion: PixelMotion, lead: int) -> Floats:
    """(N, r, 1) px. From a trust map, one value per point: values of single frames are too random."""
    frames, points = errors.shape
    if settings.sd is not None:
        sd = np.full((frames, points), settings.sd)
    elif motion.sd is not None:
        most = np.nanmax(errors) if np.isfinite(errors).any() else STATED_SD
        sd = np.where(np.isfinite(errors), errors, most)  # what is not known is trusted least
    elif motion.error is not None:
        known = np.isfinite(errors)
        square = np.where(known, errors, 0.0) ** 2
        mean = square.sum(axis=0) / np.maximum(known.sum(axis=0), 1)
        sd = np.tile(settings.trust_factor * np.sqrt(mean / 2 + FLOOR**2), (frames, 1))
    else:
        sd = np.full((frames, points), STATED_SD)
    return np.concatenate([np.full((lead, points), sd.mean()), sd])[..., None]


def _mean(paths: Floats) -> Floats:
    """(r, 2) mean over the frames in which the position of a point is known."""
    known = np.isfinite(paths)
    return np.asarray(np.where(known, paths, 0.0).sum(axis=0) / known.sum(axis=0))


def _least_lead(settings: Settings) -> int:
    """Least number of frames before a recording."""
    return -(-_LEAST_PRESSURES // (3 if settings.heights is None else len(settings.heights)))
