"""Settings of a film: times, exposure, tissue, light and noise."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from plica.errors import InvalidInput
from plica.units import number, quantity_within

__all__ = ["Film"]

_GREY = {  # smallest and largest grey levels
    "brightness": (0.0, 255.0),
    "texture": (0.0, 100.0),
    "glottis": (0.0, 255.0),
    "highlights": (0.0, 1000.0),
    "photon_noise": (0.0, 50.0),
    "read_noise": (0.0, 50.0),
}
_SHARES = ("ambient", "vignetting")


@dataclass(frozen=True)
class Film:
    """Settings of the frames; grey levels range from 0 to 255.

    Raises
    ------
    InvalidInput
        For a field that is out of range.
    """

    fps: float | None = None
    """Frames per second, in [1, 1e7]; None: one frame for each stored field."""
    start: float | str | None = None
    """s, middle of the first frame's exposure; None: the first stored instant possible."""
    end: float | str | None = None
    """s, time of the last frame at the latest; None: the last stored instant possible."""
    exposure: float | str = 0.0
    """s, at most 1 / fps; 0: an instant."""
    samples: int = 4
    """Samples averaged in a frame, 1 to 256: each has its own time within the exposure and its own position
    within the pixel."""
    brightness: float = 150.0
    """Mean grey level of tissue that faces the light."""
    texture: float = 25.0
    """Standard deviation of the tissue's brightness, grey levels."""
    grain: float | str = 0.25e-3
    """Shortest wavelength of the texture, m, in [1e-6, 0.1]; the longest is eight times as long."""
    ambient: float = 0.35
    """Ambient share of the light, in [0, 1]; 1: brightness does not change with motion."""
    light: tuple[float, float, float] = (0.15, 0.1, 1.0)
    """Direction towards the lamp: right and up in the picture, towards the camera (> 0)."""
    highlights: float = 200.0
    """Grey levels of the lamp's mirror reflection on wet tissue."""
    gloss: float = 200.0
    """Exponent of the highlights (Blinn 1977), in [1, 1e4]; the larger, the smaller the highlights."""
    roughness: float = 8.0
    """Standard deviation of the wet surface's slopes, degrees, in [0, 45]: breaks up highlights."""
    glottis: float = 12.0
    """Grey level in the glottis."""
    vignetting: float = 0.25
    """Share of the light lost in the corners, in [0, 1]."""
    blur: float = 0.7
    """Standard deviation of the lens' Gaussian blur, px, in [0, 20]."""
    photon_noise: float = 2.0
    """Standard deviation at white, grey levels; its square is proportional to the grey level."""
    read_noise: float = 1.0
    """Standard deviation at any grey level, grey levels."""
    seed: int = 1
    """Seed of texture and noise, >= 0."""

    def __post_init__(self) -> None:
        if self.fps is not None:
            number("Film", "fps", self.fps, 1.0, 1e7, "/s")
        for name in ("start", "end"):
            if getattr(self, name) is not None:
                self._set(name, quantity_within("Film", name, getattr(self, name), "s", 0.0, 1e6))
        self._set("exposure", quantity_within("Film", "exposure", self.exposure, "s", 0.0, 1.0))
        self._set("grain", quantity_within("Film", "grain", self.grain, "m", 1e-6, 0.1))
        for name, (least, most) in _GREY.items():
            number("Film", name, getattr(self, name), least, most, "grey levels")
        for name in _SHARES:
            number("Film", name, getattr(self, name), 0.0, 1.0, "")
        number("Film", "gloss", self.gloss, 1.0, 1e4, "")
        number("Film", "roughness", self.roughness, 0.0, 45.0, "degrees")
        number("Film", "blur", self.blur, 0.0, 20.0, "px")
        _whole("samples", self.samples, 1, 256)
        _whole("seed", self.seed, 0, 2**63)
        light = self.light
        try:
            known = np.shape(light) == (3,) and np.isfinite(light).all() and light[2] > 0
        except TypeError:
            known = False
        if not known:
            raise InvalidInput(
                f"Film: light = {light!r}; must be three numbers, the third, towards the camera, > 0."
            )
        if self.fps is not None and self.seconds("exposure") * self.fps > 1 + 1e-9:
            raise InvalidInput(
                f"Film: exposure = {self.exposure:g} s; must be at most 1 / fps = {1 / self.fps:g} s."
            )

    def seconds(self, name: str) -> float:
        """A time (s) or a length (m) as a number."""
        return float(getattr(self, name))

    @property
    def lamp(self) -> np.ndarray[Any, np.dtype[np.float64]]:
        """(3) unit vector of `light`."""
        light = np.array(self.light, dtype=float)
        return np.asarray(light / math.sqrt(float(light @ light)))

    def _set(self, name: str, value: object) -> None:
        object.__setattr__(self, name, value)


def _whole(name: str, value: object, least: int, most: int) -> None:
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or not least <= value <= most:
        raise InvalidInput(f"Film: {name} = {value!r}; must be a whole number in [{least}, {most}].")
