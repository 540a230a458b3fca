"""Films of a wave of known speed: textured tissue left and right of a line, with the exact motion and strain.

Tissue whose place at rest lies at the distance d from a vertical midline moves away from it by

    w(d, t) = a min(d / 4 px, 1) exp(-d / reach) cos(2 pi (t / period - d / wavelength)),

a wave that runs outward at wavelength / period (px a frame) on both sides. A pixel at x shows the tissue
from X with X + motion(X, t) = x, found by fixed-point iteration (a slope of w well below 1 is asked).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from plica.errors import InvalidInput
from plica.video.glottis.midline import Midline

__all__ = ["SyntheticWave"]

Floats = npt.NDArray[np.float64]
_RAMP = 4.0  # px from the midline, over which the motion begins
_MARGIN = 24  # px of texture beyond the picture
_ROUNDS = 60  # of the fixed-point iteration: a slope of 0.8 leaves 1e-6 of the way


@dataclass(frozen=True)
class SyntheticWave:
    """What the film shows; lengths in px, times in frames. InvalidInput where tissue folds."""

    height: int = 96
    width: int = 112
    wavelength: float = 40.0
    period: float = 12.0
    amplitude: float = 1.5
    reach: float = 40.0
    """Distance over which the amplitude falls to 1 / e."""
    contrast: float = 25.0
    """Standard deviation of the tissue's brightness, grey levels."""
    noise: float = 2.0
    """Standard deviation, grey levels."""
    seed: int = 1

    def __post_init__(self) -> None:
        steepest = self.amplitude * (2 * np.pi / self.wavelength + 1 / self.reach + 1 / _RAMP)
        if not 0 < steepest < 0.8:
            raise InvalidInput(
                f"SyntheticWave: amplitude = {self.amplitude:g} px makes a slope of the motion of up to "
                f"{steepest:.2g} px per px; must be above 0 and below 0.8, or tissue overtakes tissue. Take "
                "less of it, or a longer wave."
            )

    @property
    def midline(self) -> Midline:
        """From 2 px below the upper border to 2 px above the lower one."""
        middle = (self.width - 1) / 2
        return Midline((middle, 2.0), (middle, self.height - 3.0))

    @property
    def wave_number(self) -> float:
        """rad per px, by which the motion lags outward."""
        return 2 * np.pi / self.wavelength

    def motion(self, place: Floats, t: float) -> Floats:
        """px to the right at the time t (frames), of tissue whose place at rest is `place` px right of the
        midline."""
        d = np.abs(place)
        size = self.amplitude * np.minimum(d / _RAMP, 1) * np.exp(-d / self.reach)
        return np.asarray(np.sign(place) * size * np.cos(2 * np.pi * t / self.period - self.wave_number * d))

    def flow(self, t: float) -> Floats:
        """(h, w, 2) px, the true motion to the next frame on the pixels of the frame at t."""
        place = self._place(t)
        right = np.broadcast_to(self.motion(place, t + 1) - self.motion(place, t), (self.height, self.width))
        return np.stack([right, np.zeros_like(right)], axis=-1)

    def frames(self, count: int) -> Iterator[npt.NDArray[np.float32]]:
        """(h, w) grey, 0 to 255 but for rare noise, from the time 0 on."""
        from scipy import ndimage

        random = np.random.default_rng(self.seed)
        texture = random.standard_normal((self.height, self.width + 2 * _MARGIN))
        texture = ndimage.gaussian_filter(texture, 1.8)
        texture = ndimage.spline_filter(140 + self.contrast * texture / texture.std())
        rows, middle = np.arange(self.height, dtype=float), self.midline.upper[0] + _MARGIN
        for t in range(count):
            at = np.meshgrid(rows, self._place(float(t)) + middle, indexing="ij")
            seen = ndimage.map_coordinates(texture, at, order=3, prefilter=False)
            yield np.asarray(seen + self.noise * random.standard_normal(seen.shape), np.float32)

    def _place(self, t: float) -> Floats:
        """(w) px right of the midline, where the tissue that each column shows is at rest."""
        shown: Floats = np.arange(float(self.width)) - self.midline.upper[0]
        place = shown.copy()
        for _ in range(_ROUNDS):
            place = shown - self.motion(place, t)
        return np.asarray(place)
