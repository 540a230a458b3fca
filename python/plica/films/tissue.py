"""Appearance of tissue: a texture fixed to the material, light, highlights."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plica._engine import corner_normals, periodic_spline
from plica.films.settings import Film

__all__ = ["Shading", "normals"]

Floats = NDArray[np.float64]
Rows = NDArray[np.int32]

_TILE = 96  # samples of a side of the periodic tile
_SAMPLES = 4  # a shortest wavelength
_COARSER = 2  # than the texture: the roughness of the wet surface


class Shading:
    """Grey levels of tissue from its reference position and its direction to camera and lamp.

    axes (3, 3) are the camera's: to the right in the picture, up in it, towards the camera.
    """

    def __init__(self, film: Film, axes: Floats) -> None:
        self._film = film
        self._spacing = film.seconds("grain") / _SAMPLES
        self._texture, self._slopes, self._rotation = _material(film.seed)
        self._lamp = film.lamp @ axes
        half = self._lamp + axes[2]
        self._half = half / np.linalg.norm(half)

    def grey(self, place: Floats, normal: Floats, *, wet: bool = True) -> Floats:
        """(p) grey levels, not limited above; highlights only if `wet`.

        place (p, 3) m, reference positions; normal (p, 3), outward and of any length.
        """
        film = self._film
        normal = normal / np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
        at = place @ self._rotation / self._spacing
        own = film.brightness + film.texture * periodic_spline(self._texture, at, 3)
        facing = np.maximum(normal @ self._lamp, 0.0)
        grey = own * (film.ambient + (1 - film.ambient) * facing)
        if wet and film.highlights:
            grey += film.highlights * self._reflection(at, normal)
        return np.asarray(np.maximum(grey, 0.0))

    def _reflection(self, at: Floats, normal: Floats) -> Floats:
        """Blinn's (n . h)^gloss of the normals tilted by the surface's roughness."""
        film = self._film
        tilted = normal.copy()
        slope = np.tan(np.radians(film.roughness))
        if slope:
            for axis, tile in enumerate(self._slopes):
                tilted[:, axis] += slope * periodic_spline(tile, at / _COARSER, 1)
            tilted /= np.linalg.norm(tilted, axis=1, keepdims=True)
        return np.asarray(np.maximum(tilted @ self._half, 0.0) ** film.gloss)


@lru_cache(maxsize=2)
def _material(seed: int) -> tuple[Floats, tuple[Floats, Floats], Floats]:
    """The texture as a spline, slopes in two directions, and a rotation (3, 3).

    The rotation keeps the period of the tiles off the axes of the larynx.
    """
    from scipy import ndimage

    random = np.random.default_rng([seed, 0])
    texture = ndimage.spline_filter(_band(random), order=3, mode="grid-wrap")
    slopes = _band(random), _band(random)
    rotation, _ = np.linalg.qr(random.standard_normal((3, 3)))
    return np.asarray(texture, dtype=float), slopes, rotation


def _band(random: Any) -> Floats:
    """A periodic cube of noise, mean 0 and variance 1: wavelengths of 4 to 32 samples, equal in each
    octave."""
    frequency = np.fft.fftfreq(_TILE)
    half = np.fft.rfftfreq(_TILE)
    k = np.sqrt(frequency[:, None, None] ** 2 + frequency[None, :, None] ** 2 + half[None, None, :] ** 2)
    highest = 1 / _SAMPLES
    inside = (k <= highest) & (k >= highest / 8)
    weight = np.where(inside, np.maximum(k, highest / 8) ** -1.5, 0.0)
    white = np.fft.rfftn(random.standard_normal((_TILE,) * 3))
    noise = np.fft.irfftn(white * weight, s=(_TILE,) * 3, axes=(0, 1, 2))
    return np.asarray((noise - noise.mean()) / noise.std())


def normals(points: Floats, triangles: Rows) -> Floats:
    """(v, 3) outward, of any length: the area-weighted sum of the triangles' normals at each corner."""
    return corner_normals(points, triangles)
