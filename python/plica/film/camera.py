"""Where the camera stands and what it makes of a point of the larynx."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plica.errors import InvalidInput
from plica.units import read_quantity

__all__ = ["Camera", "number", "quantity"]

Floats = NDArray[np.float64]
_MOST = 4096  # px, of a side


@dataclass(frozen=True)
class Camera:
    """A camera far away (orthographic) that looks down on the folds, x to the right and y up in the picture.

    With x towards the right fold and z up, as the parametric larynx has it, the right fold is on the right of
    the picture; ``roll = 180`` turns it as most endoscopes show it.

    Raises
    ------
    InvalidInput
        For a field that is out of range.
    """

    mm_per_px: float = 0.06
    """Size of a pixel across the line of sight, mm, in [1e-4, 10]."""
    width: int = 256
    """px, 16 to 4096."""
    height: int = 256
    """px, 16 to 4096."""
    centre: tuple[float | str, float | str, float | str] = (0.0, 0.0, 0.0)
    """The point (x, y, z) of the larynx that is in the middle of the picture, m."""
    tilt: float = 0.0
    """Degrees, in (-90, 90), about the larynx's x axis; above 0 the camera stands towards +y."""
    lean: float = 0.0
    """Degrees, in (-90, 90), about the tilted y axis; above 0 the camera stands towards +x."""
    roll: float = 0.0
    """Degrees by which the picture is turned, anticlockwise as seen."""

    def __post_init__(self) -> None:
        number("Camera", "mm_per_px", self.mm_per_px, 1e-4, 10.0, "mm")
        for name in ("width", "height"):
            value = getattr(self, name)
            if isinstance(value, bool) or not isinstance(value, int | np.integer) or not 16 <= value <= _MOST:
                raise InvalidInput(f"Camera: {name} = {value!r} px; must be a whole number in [16, {_MOST}].")
        if len(self.centre) != 3:
            raise InvalidInput(f"Camera: centre = {self.centre!r}; must be three lengths, x, y and z.")
        read = tuple(quantity("Camera", "centre", value, "m", -1.0, 1.0) for value in self.centre)
        object.__setattr__(self, "centre", read)
        for name in ("tilt", "lean"):
            number("Camera", name, getattr(self, name), -89.999, 89.999, "degrees")
        number("Camera", "roll", self.roll, -360.0, 360.0, "degrees")

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width of the picture, px."""
        return self.height, self.width

    @property
    def pixel(self) -> float:
        """Size of a pixel, m."""
        return 1e-3 * self.mm_per_px

    @property
    def axes(self) -> Floats:
        """(3, 3) unit vectors of the larynx: to the right in the picture, up in it, towards the camera."""
        tilt, lean, roll = (math.radians(angle) for angle in (self.tilt, self.lean, self.roll))
        tilted = np.array(
            [[1, 0, 0], [0, math.cos(tilt), -math.sin(tilt)], [0, math.sin(tilt), math.cos(tilt)]]
        )
        leant = np.array(
            [[math.cos(lean), 0, -math.sin(lean)], [0, 1, 0], [math.sin(lean), 0, math.cos(lean)]]
        )
        turned = np.array(
            [[math.cos(roll), -math.sin(roll), 0], [math.sin(roll), math.cos(roll), 0], [0, 0, 1]]
        )
        return np.asarray(turned @ leant @ tilted, dtype=float)

    @property
    def projection(self) -> Floats:
        """(3, 4): P (x, 1) are a point's column (px, to the right), row (px, down) and height (m).

        The height is that above the plane through `centre` across the line of sight, towards the camera.
        """
        right, up, towards = self.axes
        rows = np.array([right / self.pixel, -up / self.pixel, towards])
        middle = [(self.width - 1) / 2, (self.height - 1) / 2, 0.0]
        return np.column_stack([rows, middle - rows @ np.array(self.centre, dtype=float)])

    def project(self, points: Floats) -> Floats:
        """(n, 3) column px, row px and height m of points (n, 3) m; see `projection`."""
        projection = self.projection
        return np.asarray(points @ projection[:, :3].T + projection[:, 3])


def number(where: str, name: str, value: Any, least: float, most: float, unit: str) -> None:
    """Raises InvalidInput unless `value` is a number in [least, most]."""
    kind = isinstance(value, int | float | np.integer | np.floating) and not isinstance(value, bool)
    if not kind or not least <= value <= most:
        shown = f"{value:g}" if kind else repr(value)
        raise InvalidInput(
            f"{where}: {name} = {shown} {unit}; must be a number in [{least:g}, {most:g}]. Is the unit right?"
        )


def quantity(where: str, name: str, value: Any, unit: str, least: float, most: float) -> float:
    """A number in SI, or a text with a unit, as a number; raises InvalidInput outside [least, most]."""
    try:
        found = read_quantity(float(value) if isinstance(value, np.number) else value, unit)
    except ValueError as error:
        raise InvalidInput(f"{where}: {name} = {value!r}; {error}") from None
    number(where, name, found, least, most, unit)
    return found
