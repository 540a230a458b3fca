"""Pictures of parametric larynges whose cross-section is known."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

import plica
from filmed_folds import moved, shifted
from plica import larynx_fit

__all__ = ["MM_PER_PX", "PicturedFolds", "coverage", "pictured"]

Floats = NDArray[np.float64]

MM_PER_PX = 0.06


@dataclass(frozen=True, eq=False)
class PicturedFolds:
    """A film of two alike frames of a mesh, and the geometry that the mesh was made of; itself alone."""

    section: larynx_fit.CrossSection
    clip: Any

    @property
    def frame(self) -> Floats:
        return np.asarray(self.clip.frame(0), dtype=float)

    @property
    def mask(self) -> NDArray[np.bool_]:
        return np.asarray(self.clip.glottis(0))


@cache
def pictured(
    *,
    half_width: float = 0.4e-3,
    r_in: float = 6.3e-3,
    roll: float = 0.0,
    tilt: float = 0.0,
    lean: float = 0.0,
    larynx: str = "demo",
) -> PicturedFolds:
    """A larynx with O at column 120.3, row 131.8; its second frame is displaced by 1.5 px to the right."""
    settings = larynx_fit.FitSettings(mm_per_px=MM_PER_PX, tilt=tilt, lean=lean, larynx=larynx)  # type: ignore[arg-type]
    camera = settings.camera(MM_PER_PX, (256, 256), (120.3, 131.8), roll)
    section = larynx_fit.CrossSection(settings, camera, half_width, r_in)
    mesh = plica.build_mesh(larynx_fit.larynx_of(section))
    folds = moved(shifted(1.5e-3 * MM_PER_PX), [0, 1e-3], mesh)
    return PicturedFolds(section, plica.film(folds, camera))


def coverage(shape: tuple[int, int], centre: tuple[float, float], axes: tuple[float, float]) -> Floats:
    """(h, w) share of each pixel that an upright ellipse covers, of 15 x 15 samples."""
    offset = (np.arange(15) - 7) / 15
    y, x = np.mgrid[: shape[0], : shape[1]].astype(float)
    inside = np.zeros(shape)
    for dx in offset:
        for dy in offset:
            inside += ((x + dx - centre[0]) / axes[0]) ** 2 + ((y + dy - centre[1]) / axes[1]) ** 2 <= 1
    return inside / 225
