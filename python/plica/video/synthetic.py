"""A synthetic glottis: an analytic motion of textured tissue, with the true flow, mask, area and phase.

The folds lie left and right of a vertical midline; y runs along them, from 0 at the anterior to 1 at the
posterior end. Each edge stands at

    edge_s(y, t) = shape(y) * max(0, open_s + amplitude_s * sin(2 pi f t + phase_s + lag * y)),  shape = 4 y
    (1 - y)

to the left or right of the midline: where the bracket would be negative the folds touch and stand still, as
tissue that collides does. Tissue at a distance d outside its edge moves with it by exp(-d / reach), so a
pixel of tissue comes from the place that solves X + motion(X, t) = x, found by fixed-point iteration.
Texture is bound to X, light and highlights to x; the glottis is dark.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

__all__ = ["Synthetic", "SyntheticGlottis"]

Floats = npt.NDArray[np.float64]
_SIDES = (-1.0, 1.0)  # left and right in the image


@dataclass(frozen=True)
class Synthetic:
    """What the glottis looks like and how it moves; lengths in pixels, times in frames."""

    height: int = 256
    width: int = 256
    frames: int = 80
    frequency: float = 0.05
    """Cycles a frame; 0.05: 20 frames a cycle."""
    amplitude: tuple[float, float] = (9.0, 9.0)
    """Of the edges in the image's left and right, at mid-length."""
    opening: tuple[float, float] = (4.0, 4.0)
    """Mean distance of the edges from the midline; below the amplitude the folds collide."""
    phase: tuple[float, float] = (0.0, 0.0)
    """rad, of both edges."""
    lag: float = 0.0
    """rad, by which the posterior end lags behind the anterior."""
    reach: float = 25.0
    """Distance over which the tissue's motion falls to 1 / e."""
    texture: float = 25.0
    """Standard deviation of the tissue's brightness, grey values of 255."""
    grain: float = 2.0
    """Size of the texture's features."""
    light: float = 0.25
    """Share by which the light falls off towards the corners."""
    highlights: int = 6
    """Saturated spots; they stay where they are while the tissue moves."""
    noise: float = 2.0
    """Standard deviation, grey values of 255."""
    blur: float = 0.8
    """Standard deviation of the lens' Gaussian blur."""
    seed: int = 1


class SyntheticGlottis:
    """Frames of a :class:`Synthetic`, each with its truth. Frames depend on their number alone."""

    def __init__(self, options: Synthetic | None = None) -> None:
        from scipy import ndimage

        self.options = o = options or Synthetic()
        random = np.random.default_rng(o.seed)
        self._y, self._x = np.mgrid[0 : o.height, 0 : o.width].astype(float)
        self._margin = 48
        size = (o.height + 2 * self._margin, o.width + 2 * self._margin)
        texture = ndimage.gaussian_filter(random.standard_normal(size), o.grain)
        texture += 0.7 * ndimage.gaussian_filter(random.standard_normal(size), 4 * o.grain) * 4
        self._texture = ndimage.spline_filter(140 + o.texture * texture / texture.std())
        r2 = ((self._x - o.width / 2) / o.width) ** 2 + ((self._y - o.height / 2) / o.height) ** 2
        self._light = 1 - o.light * 2 * r2
        spots = random.uniform(
            [0.1 * o.height, 0.1 * o.width], [0.9 * o.height, 0.9 * o.width], (o.highlights, 2)
        )
        self._spots = np.zeros((o.height, o.width), dtype=bool)
        for y, x in spots:
            self._spots |= (self._y - y) ** 2 + (self._x - x) ** 2 < 3.0**2

    @property
    def count(self) -> int:
        return self.options.frames

    @property
    def midline(self) -> float:
        """Column of the midline, px."""
        return (self.options.width - 1) / 2

    def along(self, y: Floats) -> Floats:
        """Place along the folds, 0 to 1 within the glottis, of rows y."""
        top, bottom = 0.15 * self.options.height, 0.85 * self.options.height
        return (y - top) / (bottom - top)

    def edge(self, side: int, y: Floats, t: float) -> Floats:
        """Distance of the edge of side 0 (the image's left) or 1 from the midline at rows y, px."""
        o = self.options
        s = self.along(y)
        shape = np.where((s > 0) & (s < 1), 4 * s * (1 - s), 0.0)
        angle = 2 * np.pi * o.frequency * t + o.phase[side] - o.lag * s
        return shape * np.maximum(0.0, o.opening[side] + o.amplitude[side] * np.sin(angle))

    def _motion(self, x: Floats, y: Floats, t: float) -> Floats:
        """Displacement along x of the tissue whose place with closed folds is x, y."""
        motion = np.zeros_like(x)
        for side, sign in enumerate(_SIDES):
            own = (x - self.midline) * sign
            falloff = np.exp(-np.maximum(own, 0.0) / self.options.reach)
            motion += np.where(own >= 0, sign * self.edge(side, y, t) * falloff, 0.0)
        return motion

    def _place(self, t: float) -> tuple[Floats, npt.NDArray[np.bool_]]:
        """Where the tissue at each pixel was with closed folds, and where there is glottis instead."""
        glottis = np.zeros(self._x.shape, dtype=bool)
        place = self._x.copy()
        for side, sign in enumerate(_SIDES):
            distance = (self._x - self.midline) * sign
            edge = self.edge(side, self._y, t)
            glottis |= (distance >= 0) & (distance < edge)
            own = distance >= 0
            back = np.maximum(distance, edge)  # d solves d + edge exp(-d / reach) = back, d >= 0
            d = back - edge
            for _ in range(60):
                d = np.maximum(0.0, back - edge * np.exp(-d / self.options.reach))
            place = np.where(own, self.midline + sign * d, place)
        return place, glottis

    def mask(self, t: float) -> npt.NDArray[np.bool_]:
        """(h, w) where the glottis is open."""
        return self._place(t)[1]

    def area(self, t: float) -> tuple[float, float]:
        """Exact area of the glottis left and right of the midline in the image, px^2."""
        y = np.linspace(-0.5, self.options.height - 0.5, 20001)
        left, right = (float(np.trapezoid(self.edge(side, y, t), y)) for side in (0, 1))
        return left, right

    def flow(self, first: float, second: float) -> tuple[Floats, npt.NDArray[np.bool_]]:
        """(h, w, 2) px, motion (u, v) from the first time to the second on the first frame's pixels; where
        known."""
        place, glottis = self._place(first)
        u = self._motion(place, self._y, second) - self._motion(place, self._y, first)
        return np.stack([u, np.zeros_like(u)], axis=-1), ~glottis

    def frame(self, t: float) -> npt.NDArray[np.float32]:
        """(h, w) grey, 0 to 255."""
        from scipy import ndimage

        o = self.options
        place, glottis = self._place(t)
        tissue = ndimage.map_coordinates(
            self._texture,
            [self._y + self._margin, place + self._margin],
            order=3,
            prefilter=False,
            mode="mirror",
        )
        image = np.where(glottis, 12.0, tissue) * self._light
        image[self._spots & ~glottis] = 255.0
        if o.blur:
            image = ndimage.gaussian_filter(image, o.blur)
        noise = np.random.default_rng([o.seed, round(1000 * t)]).standard_normal(image.shape)
        return np.asarray(np.clip(image + o.noise * noise, 0, 255), dtype=np.float32)

    def frames(self) -> Iterator[npt.NDArray[np.float32]]:
        """All frames."""
        for t in range(self.count):
            yield self.frame(t)

    def stack(self) -> npt.NDArray[np.uint8]:
        """(frames, h, w), as a camera would store them."""
        return np.stack([np.round(frame) for frame in self.frames()]).astype(np.uint8)
