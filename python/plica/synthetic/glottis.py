"""A synthetic glottis: an analytic motion of textured tissue, with the true flow, mask, area and phase.

The folds lie left and right of a vertical midline; y runs along them, from 0 at the anterior to 1 at the
posterior end. Each edge stands at

    edge_s(y, t) = shape(y) * max(0, open_s + amplitude_s * sin(2 pi f t + phase_s + lag * y)),  shape = 4 y
    (1 - y)

to the left or right of the midline: where the bracket would be negative the folds touch and stand still, as
tissue that collides does. With jitter and shimmer each cycle has a period and an amplitude of its own, from
one rise of the sine through zero to the next, so that the edges stay continuous. Tissue at a distance d
outside its edge moves with it by exp(-d / reach), so a pixel of tissue comes from the place that solves X +
motion(X, t) = x, found by fixed-point iteration. Texture is bound to X, light, highlights, the crease and
the shadow to x. The glottis is dark; a pixel that an edge crosses is as dark as its share of it, as a
camera's is: were it dark or not by its centre, edges would move in whole pixels.
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
    jitter: float = 0.0
    """Relative standard deviation of the periods, independent of each other."""
    shimmer: float = 0.0
    """Relative standard deviation of the amplitudes."""
    alternation: float = 0.0
    """Share by which every second cycle's amplitude is less."""
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
    crease: float = 0.0
    """Width of a dark line beside the glottis, as long as it and as dark, that is there in every frame."""
    shadow: float = 1.0
    """Share of the light that is left in a shadow to the image's left of the glottis."""
    shadow_width: float = 30.0
    """Of the shadow, whose right border lies where the left fold is when the glottis is widest."""
    shadow_speed: float = 0.0
    """px to the right a frame; 0: it stays."""
    shade: float = 0.0
    """Width at mid-length of the steep surface beside the right fold that a lamp at that side leaves in
    shade: all of it as the fold parts, less as it closes."""
    seed: int = 1


class SyntheticGlottis:
    """Frames of a :class:`Synthetic`, each with its truth. Frames depend on their number alone."""

    def __init__(self, options: Synthetic | None = None) -> None:
        from scipy import ndimage

        self.options = o = options or Synthetic()
        random = np.random.default_rng(o.seed)
        self._y, self._x = np.mgrid[0 : o.height, 0 : o.width].astype(float)
        self._rows = np.ascontiguousarray(self._y[:, :1])
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
        self._periods, self._amplitudes = self._cycles()
        self._spots = np.zeros((o.height, o.width), dtype=bool)
        for y, x in spots:
            self._spots |= (self._y - y) ** 2 + (self._x - x) ** 2 < 3.0**2

    def _cycles(self) -> tuple[Floats, Floats]:
        """Period (frames) and relative amplitude of every cycle of the recording, and of one more."""
        o = self.options
        random = np.random.default_rng([o.seed, 77])
        size = int(np.ceil(o.frames * o.frequency / max(1 - 4 * o.jitter, 0.1))) + 2
        periods = (1 + o.jitter * random.standard_normal(size)) / o.frequency
        amplitudes = 1 + o.shimmer * random.standard_normal(size)
        return periods, amplitudes * np.where(np.arange(size) % 2, 1 - o.alternation, 1.0)

    @property
    def begins(self) -> Floats:
        """Instants (frames) at which cycles begin: where the sine of a fold of phase 0 rises through zero."""
        return np.concatenate([[0.0], np.cumsum(self._periods)])

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

    def _shape(self, y: Floats) -> Floats:
        """Of the edges: 0 at the ends of the folds and beyond, 1 at mid-length."""
        s = self.along(y)
        return np.where((s > 0) & (s < 1), 4 * s * (1 - s), 0.0)

    def edge(self, side: int, y: Floats, t: float) -> Floats:
        """Distance of the edge of side 0 (the image's left) or 1 from the midline at rows y, px."""
        o = self.options
        s, shape = self.along(y), self._shape(y)
        begins = self.begins
        turns = float(np.interp(t, begins, np.arange(begins.size))) if t >= 0 else t * o.frequency
        angle = 2 * np.pi * turns + o.phase[side] - o.lag * s
        cycle = np.clip(np.floor(angle / (2 * np.pi)).astype(int), 0, self._amplitudes.size - 1)
        swing = o.amplitude[side] * self._amplitudes[cycle] * np.sin(angle)
        return np.asarray(shape * np.maximum(0.0, o.opening[side] + swing))

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
            edge = self.edge(side, self._rows, t)
            glottis |= (distance >= 0) & (distance < edge)
            place = np.where(distance >= 0, self.midline + sign * distance, place)
            moved = np.ix_(edge[:, 0] > 0, distance[0] >= 0)
            edge = edge[edge[:, 0] > 0]
            back = np.maximum(distance[moved], edge)  # d solves d + edge exp(-d / reach) = back, d >= 0
            d = back - edge
            for _ in range(60):
                before, d = d, np.maximum(0.0, back - edge * np.exp(-d / self.options.reach))
                if np.array_equal(before, d):
                    break
            place[moved] = self.midline + sign * d
        return place, glottis

    def _share(self, t: float) -> Floats:
        """(h, w) how much of each pixel is glottis: 1 within it, 0 in tissue, between them at its edges."""
        share = np.zeros(self._x.shape)
        for side, sign in enumerate(_SIDES):
            distance = (self._x - self.midline) * sign
            end = np.minimum(distance + 0.5, self.edge(side, self._rows, t))
            share += np.maximum(end - np.maximum(distance - 0.5, 0.0), 0.0)
        return share

    def mask(self, t: float) -> npt.NDArray[np.bool_]:
        """(h, w) the pixels whose centres the open glottis holds."""
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
        dark = self._share(t)
        image = ((1 - dark) * tissue + dark * 12.0) * self._light
        image[self._spots & ~glottis] = 255.0
        image = self._darkened(image, t)
        if o.blur:
            image = ndimage.gaussian_filter(image, o.blur)
        noise = np.random.default_rng([o.seed, round(1000 * t)]).standard_normal(image.shape)
        return np.asarray(np.clip(image + o.noise * noise, 0, 255), dtype=np.float32)

    def _darkened(self, image: Floats, t: float) -> Floats:
        """With the shade, the shadow and the crease."""
        o = self.options
        if o.shade > 0:
            edge, bare = self.edge(1, self._y, t), self._shape(self._y)
            beside = bare * o.shade * (1 + np.cos(2 * np.pi * o.frequency * t)) / 2
            end = np.minimum(self._x - self.midline + 0.5, edge + np.where(edge > 0, beside, 0.0))
            part = np.maximum(end - np.maximum(self._x - self.midline - 0.5, edge), 0.0)
            image = image + part * np.minimum(55.0 * self._light - image, 0.0)
        along = self.along(self._y)
        reach = max(o.opening[0] + o.amplitude[0], 0.0)
        if o.shadow < 1:
            right = self.midline - reach + o.shadow_speed * t
            where = (self._x > right - o.shadow_width) & (self._x <= right) & (along > 0.2) & (along < 0.8)
            image = np.where(where, np.maximum(o.shadow * image, 12.0 * self._light), image)
        if o.crease > 0:
            left = self.midline + o.opening[1] + o.amplitude[1] - 1
            where = (self._x >= left) & (self._x < left + o.crease) & (along > 0.3) & (along < 0.7)
            image = np.where(where, 12.0 * self._light, image)
        return image

    def frames(self) -> Iterator[npt.NDArray[np.float32]]:
        """All frames."""
        for t in range(self.count):
            yield self.frame(t)

    def stack(self) -> npt.NDArray[np.uint8]:
        """(frames, h, w), as a camera would store them."""
        return np.stack([np.round(frame) for frame in self.frames()]).astype(np.uint8)
