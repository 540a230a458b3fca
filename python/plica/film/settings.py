"""What a film is taken with: instants, exposure, tissue, light and noise."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from plica.errors import InvalidInput
from plica.units import number, quantity

__all__ = ["Film"]

_GREY = {  # grey levels of 255: least and most
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
    """When and how pictures are taken; grey levels are of 0 to 255.

    Raises
    ------
    InvalidInput
        For a field that is out of range.
    """

    fps: float | None = None
    """Frames a second, in [1, 1e7]; None: a frame for each stored field."""
    start: float | str | None = None
    """s, middle of the first frame's exposure; None: the first stored instant that leaves room for it."""
    end: float | str | None = None
    """s, no frame is later; None: the last stored instant that leaves room for its exposure."""
    exposure: float | str = 0.0
    """s, at most 1 / fps; 0: an instant."""
    samples: int = 4
    """Pictures that a frame is the mean of, 1 to 256: each at a time of its own within the exposure and a
    place of its own within the pixel."""
    brightness: float = 150.0
    """Mean grey of tissue that faces the light."""
    texture: float = 25.0
    """Standard deviation of the tissue's own brightness, grey levels."""
    grain: float | str = 0.25e-3
    """Shortest wavelength of the texture, m, in [1e-6, 0.1]; the longest is eight times as long."""
    ambient: float = 0.35
    """Share of the light that comes from everywhere, in [0, 1]; 1: brightness does not change with motion."""
    light: tuple[float, float, float] = (0.15, 0.1, 1.0)
    """Direction towards the lamp: right and up in the picture, towards the camera (> 0)."""
    highlights: float = 200.0
    """Grey levels that wet tissue adds where it mirrors the lamp."""
    gloss: float = 200.0
    """Exponent of the highlights (Blinn 1977), in [1, 1e4]; larger ones are smaller."""
    roughness: float = 8.0
    """Standard deviation of the wet surface's slopes, degrees, in [0, 45]: it breaks highlights up."""
    glottis: float = 12.0
    """Grey of what is below the glottis."""
    vignetting: float = 0.25
    """Share of the light that is lost in the corners, in [0, 1]."""
    blur: float = 0.7
    """Standard deviation of the lens' Gaussian blur, px, in [0, 20]."""
    photon_noise: float = 2.0
    """Standard deviation at white, grey levels; its square falls with the grey."""
    read_noise: float = 1.0
    """Standard deviation at any grey, grey levels."""
    seed: int = 1
    """Of texture and noise, >= 0."""

    def __post_init__(self) -> None:
        if self.fps is not None:
            number("Film", "fps", self.fps, 1.0, 1e7, "/s")
        for name in ("start", "end"):
            if getattr(self, name) is not None:
                self._set(name, quantity("Film", name, getattr(self, name), "s", 0.0, 1e6))
        self._set("exposure", quantity("Film", "exposure", self.exposure, "s", 0.0, 1.0))
        self._set("grain", quantity("Film", "grain", self.grain, "m", 1e-6, 0.1))
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
        """A time, or a length, as the number it was read to."""
        return float(getattr(self, name))

    @property
    def lamp(self) -> np.ndarray[Any, np.dtype[np.float64]]:
        """(3) `light` at unit length."""
        light = np.array(self.light, dtype=float)
        return np.asarray(light / math.sqrt(float(light @ light)))

    def _set(self, name: str, value: object) -> None:
        object.__setattr__(self, name, value)


def _whole(name: str, value: object, least: int, most: int) -> None:
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or not least <= value <= most:
        raise InvalidInput(f"Film: {name} = {value!r}; must be a whole number in [{least}, {most}].")
