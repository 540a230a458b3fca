"""The camera's pose relative to the mesh, and its uncertainty."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from plica import _engine
from plica.camera.pose import Camera
from plica.errors import InvalidInput
from plica.identify.observation.sources import PixelMotion
from plica.identify.settings import Settings
from plica.scene.mesh.parts import Larynx
from plica.scene.scene import Scene

__all__ = ["Placement", "place"]

Floats = NDArray[np.float64]
DEFAULT_TILT_SD = 6.0
"""Degrees, for a camera that is only known to look down on the folds."""
_LENGTH_TOLERANCE = 0.05
"""Relative difference of the glottal lengths in recording and mesh without a note."""


@dataclass(frozen=True)
class Placement:
    """Pose of a camera.

    Attributes
    ----------
    camera : Camera
    tilt_sd : float
        Degrees, of its tilt and lean; 0: known.
    notes : assumptions that were made
    """

    camera: Camera
    tilt_sd: float
    notes: tuple[str, ...] = ()


def place(
    motion: PixelMotion, settings: Settings, scene: Scene, mesh: _engine.TetMesh, seen: str
) -> Placement:
    """The pose from the settings, else from the recording, else from the ends of its glottis.

    Raises InvalidInput if the size of a pixel or the position of the image is unknown.
    """
    given = [name for name in ("centre", "tilt", "lean", "roll") if getattr(settings, name) is not None]
    tilt_sd = settings.tilt_sd
    if motion.camera is not None and not given:
        if settings.mm_per_px is not None:
            raise InvalidInput(
                f"identify: mm_per_px = {settings.mm_per_px:g}; must be left out: {motion.name} contains the "
                "pose of its camera. To override it, give centre and roll too."
            )
        return Placement(motion.camera, tilt_sd or 0.0)
    if motion.camera is not None and settings.centre is None:
        raise InvalidInput(
            f"identify: {given[0]} = {getattr(settings, given[0]):g}; must be left out: {motion.name} "
            "contains the pose of its camera. To override it, give centre, roll and mm_per_px too."
        )
    mm_per_px = settings.mm_per_px or motion.mm_per_px
    if mm_per_px is None:
        raise InvalidInput(
            f"identify: the size of a pixel is not in {motion.name}; must be known to estimate stiffness in "
            "Pa. Give --mm-per-px."
        )
    notes: tuple[str, ...] = motion.notes
    roll, centre = settings.roll, settings.centre
    if centre is None:
        if motion.glottis is None:
            raise InvalidInput(
                f"identify: the position of the image on the mesh is unknown: {motion.name} has neither a "
                "projection nor a midline; must have one. Give --centre and --roll."
            )
        (a0, a1), (p0, p1) = motion.glottis
        if roll is None:
            roll = math.degrees(math.atan2(-(a0 - p0), -(a1 - p1)))
        notes += _length_note(math.hypot(a0 - p0, a1 - p1) * mm_per_px, scene)
    height, width = motion.shape
    camera = Camera(
        mm_per_px=mm_per_px,
        width=width,
        height=height,
        centre=centre or (0.0, 0.0, 0.0),
        tilt=settings.tilt or 0.0,
        lean=settings.lean or 0.0,
        roll=roll or 0.0,
    )
    if centre is None and motion.glottis is not None:
        faces = np.unique(np.asarray(mesh.surfaces[seen]))
        x = np.asarray(mesh.points)[faces]
        middle = 0.5 * (x.min(axis=0) + x.max(axis=0))
        off = np.mean(motion.glottis, axis=0) - [(camera.width - 1) / 2, (camera.height - 1) / 2]
        right, up, _ = camera.axes
        shift = middle - camera.pixel * (off[0] * right - off[1] * up)
        camera = replace(camera, centre=(float(shift[0]), float(shift[1]), float(shift[2])))
    return Placement(camera, DEFAULT_TILT_SD if tilt_sd is None else tilt_sd, notes)


def _length_note(seen_mm: float, scene: Scene) -> tuple[str, ...]:
    """A note if recording and mesh have different glottal lengths: geometry is not estimated."""
    if not isinstance(scene.mesh, Larynx):
        return ()
    own = 2e3 * float(scene.mesh.all_options()["major"])
    if abs(seen_mm / own - 1) <= _LENGTH_TOLERANCE:
        return ()
    return (
        f"The glottis is {seen_mm:.3g} mm long in the recording and {own:.3g} mm in the mesh. Geometry is "
        "not estimated: the difference biases the stiffness.",
    )
