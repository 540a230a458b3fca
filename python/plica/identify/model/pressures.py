"""The pressures in a scene's glottis according to the settings: where they act and which are known."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from plica import _engine
from plica.errors import InvalidInput, nearest, one_of
from plica.identify.model.forcing import Forcing
from plica.identify.observation.observation import Observation
from plica.identify.settings import Settings
from plica.scene.mesh.parts import Larynx
from plica.scene.scene import Scene
from plica.storage.files import require_file

__all__ = ["fed_back", "forcing_of", "heights_of", "pressed_surface", "seen_surface"]

Floats = NDArray[np.float64]
_LEAST_ROWS = 3  # of a table, within the recording


def pressed_surface(settings: Settings, scene: Scene, mesh: _engine.TetMesh) -> str:
    """The surface on which the pressures act."""
    default = "airway" if scene.airflow is None else scene.airflow.surface
    return _known(settings.surface or default, mesh, "surface")


def fed_back(settings: Settings, scene: Scene) -> bool:
    """Whether the motion generates its own pressures, according to the settings or else the scene."""
    if settings.voiced is not None:
        return settings.voiced
    return scene.airflow is not None or (isinstance(scene.mesh, Larynx) and settings.drive is None)


def seen_surface(settings: Settings, scene: Scene, mesh: _engine.TetMesh) -> str:
    """The surface that the camera sees."""
    return _known(settings.seen or pressed_surface(settings, scene, mesh), mesh, "seen")


def heights_of(settings: Settings, scene: Scene, mesh: _engine.TetMesh) -> Floats:
    """(q) m: those of the settings; else three, over the medial part of a larynx or the whole surface."""
    if settings.heights is not None:
        return np.array(settings.heights, dtype=float)
    if isinstance(scene.mesh, Larynx):
        fields = scene.mesh.all_options()
        z = [section[0] for section in fields["sections"]]
        low, high = z[max(fields["layers_from_section"] - 2, 0)], z[fields["layers_to_section"]]
    else:
        faces = np.asarray(mesh.surfaces[pressed_surface(settings, scene, mesh)])
        z = np.asarray(mesh.points)[np.unique(faces), 2]
        low, high = float(np.min(z)), float(np.max(z))
        if not high > low:
            raise InvalidInput(
                f"identify: the surface of the pressures is at one height, z = {low:g} m; must have an "
                "extent in z. Give heights, or another surface."
            )
    return np.linspace(low, high, 3)


def forcing_of(
    settings: Settings, scene: Scene, mesh: _engine.TetMesh, seen: Observation, lead: int
) -> Forcing:
    """Pressures at the heights, a drive that is known up to a factor, and collision forces in closed frames:
    pressures at the same heights that are concentrated on the middle of the folds' length."""
    surface = pressed_surface(settings, scene, mesh)
    heights = heights_of(settings, scene, mesh)
    patterns = Forcing.on_surface(mesh, surface, heights.tolist())
    moving = np.abs(patterns).sum(axis=0) > 0
    if not moving.all():
        k = int(np.argmin(moving))
        raise InvalidInput(
            f"identify: heights[{k}] = {heights[k]:g} m; must be where a pressure acts on the surface "
            f'"{surface}".'
        )
    closed = np.asarray(seen.closed)
    drive = None
    if settings.drive is not None:
        drive = _drive(settings.drive, len(heights), scene, seen, lead)
    return Forcing(
        patterns,
        drive=drive,
        collision=_on_the_middle(patterns, mesh, surface) if closed.any() else None,
        gain_sd=settings.gain_sd if drive is not None else 0.0,
    )


def _on_the_middle(patterns: Floats, mesh: _engine.TetMesh, surface: str) -> Floats:
    """The patterns times 1 - (y / b)^2, b the half-length of the surface."""
    x = np.asarray(mesh.points)
    y = x[:, 1]
    on = y[np.unique(np.asarray(mesh.surfaces[surface]))]
    middle, half = 0.5 * (on.min() + on.max()), 0.5 * (on.max() - on.min())
    share = np.clip(1 - ((y - middle) / half) ** 2, 0, None)
    return np.ascontiguousarray(patterns * np.repeat(share, 3)[:, None])


def _drive(path: Path, heights: int, scene: Scene, seen: Observation, lead: int) -> Floats:
    """(steps, q) Pa at the times of the steps' loads; before the recording it ramps up to its first value."""
    times, values = _table(path, heights)
    step, rate = scene.time.step, seen.frame_rate
    ratio = round(1 / (step * rate))
    alpha = getattr(scene.time.scheme.choice, "alpha", 0.0)
    at = step * (np.arange(seen.frames * max(ratio, 1)) + 1 + alpha) - lead / rate
    end = (seen.frames - lead) / rate
    if times[0] > 1e-9 or times[-1] < end - 1.5 / rate:
        raise InvalidInput(
            f"{path.name}: has times from {times[0]:g} to {times[-1]:g} s; must cover the recording, 0 to "
            f"{end:g} s."
        )
    within = int(np.sum((times >= 0) & (times <= end)))
    if within < _LEAST_ROWS:
        raise InvalidInput(
            f"{path.name}: has {within} rows from 0 to {end:g} s, the time of the recording; must have "
            f"{_LEAST_ROWS} or more. Are the times in s?"
        )
    found = np.column_stack([np.interp(at, times, column) for column in values.T])
    rise = np.clip(1 + at * rate / max(lead, 1), 0, 1)
    return np.asarray(found * (0.5 - 0.5 * np.cos(np.pi * rise))[:, None])


def _table(path: Path, heights: int) -> tuple[Floats, Floats]:
    require_file(path, f"drive = {path}")
    try:
        with path.open(newline="", encoding="utf-8") as file:
            rows = [row for row in csv.reader(file) if row]
        found = np.array([[float(cell) for cell in row] for row in rows[1:]])
    except OSError as error:
        raise InvalidInput(f"{path}: cannot be read: {error.strerror}.") from None
    except ValueError:
        raise InvalidInput(f"{path.name}: all cells below the heading must be numbers.") from None
    if rows and all(_is_number(cell) for cell in rows[0]):
        raise InvalidInput(
            f"{path.name}: has no heading; the first line must name the columns, as in time,p1,p2."
        )
    if found.ndim != 2 or len(found) < 2 or found.shape[1] != heights + 1:
        columns = len(rows[-1]) if rows else 0
        raise InvalidInput(
            f"{path.name}: has {len(rows)} lines, the last with {columns} columns; must have {heights + 1}: "
            f"time (s) and a pressure (Pa) at each of {heights} heights, with a heading and two rows or more."
        )
    if not np.isfinite(found).all() or not (np.diff(found[:, 0]) > 0).all():
        raise InvalidInput(f"{path.name}: times must increase, and all numbers must be finite.")
    return found[:, 0], found[:, 1:]


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True


def _known(name: str, mesh: _engine.TetMesh, key: str) -> str:
    if name not in mesh.surfaces:
        known = list(mesh.surfaces)
        raise InvalidInput(f'identify: {key} = "{name}"; must be {one_of(known)}.{nearest(name, known)}')
    return name
