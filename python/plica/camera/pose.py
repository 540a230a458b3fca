"""The camera's position and its projection of points of the larynx."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from plica.errors import InvalidInput
from plica.units import number, quantity_within

__all__ = ["Camera"]

Floats = NDArray[np.float64]
_MOST = 4096  # px, of a side


@dataclass(frozen=True)
class Camera:
    """An orthographic camera that looks down on the folds.

    Positions in the picture are column and row, px, rows downwards, with the middle of the first pixel at
    (0, 0); motion is to the right and down. The larynx's x is to the right and its y up in the picture, so
    that of the parametric larynx (x towards the right fold, y to the front, z up) the right fold is on the
    right and the front (anterior) at the top; ``roll = 180`` turns the picture as most endoscopes show it.

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
    """Point (x, y, z) of the larynx in the middle of the picture, m."""
    tilt: float = 0.0
    """Degrees, in (-90, 90), about the larynx's x axis; > 0: the camera is tilted towards +y."""
    lean: float = 0.0
    """Degrees, in (-90, 90), about the tilted y axis; > 0: the camera is tilted towards +x."""
    roll: float = 0.0
    """Rotation of the picture, degrees, anticlockwise."""

    def __post_init__(self) -> None:
        number("Camera", "mm_per_px", self.mm_per_px, 1e-4, 10.0, "mm")
        for name in ("width", "height"):
            value = getattr(self, name)
            if isinstance(value, bool) or not isinstance(value, int | np.integer) or not 16 <= value <= _MOST:
                raise InvalidInput(f"Camera: {name} = {value!r} px; must be a whole number in [16, {_MOST}].")
        if len(self.centre) != 3:
            raise InvalidInput(f"Camera: centre = {self.centre!r}; must be three lengths, x, y and z.")
        read = tuple(quantity_within("Camera", "centre", value, "m", -1.0, 1.0) for value in self.centre)
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
        roll, lean, tilt = self._rotations()
        return np.asarray(roll @ lean @ tilt)

    @property
    def projection(self) -> Floats:
        """(3, 4): P (x, 1) are a point's column (px, to the right), row (px, down) and height (m).

        The height is that above the plane through `centre` across the line of sight, towards the camera.
        """
        middle = [(self.width - 1) / 2, (self.height - 1) / 2, 0.0]
        projection = self._projected(self.axes)
        projection[:, 3] += middle
        return projection

    @classmethod
    def of_projection(cls, projection: Floats, shape: tuple[int, int]) -> Camera:
        """The camera with the first rows P (2 or 3, 4) of a `projection`, for a picture of (h, w) px.

        `centre` is the point closest to the larynx's origin on the line of sight in the middle of the
        picture.

        Raises
        ------
        InvalidInput
            If the rows are not orthogonal and of equal length, or look at the folds from below.
        """
        rows = np.asarray(projection, dtype=float)[:2]
        square = rows[:, :3] @ rows[:, :3].T
        if not (np.abs(square - square[0, 0] * np.eye(2)) < 1e-6 * square[0, 0]).all():
            raise InvalidInput(
                "Camera: projection must be orthographic: its first two rows orthogonal and of one length "
                "(1/m)."
            )
        per_metre = math.sqrt(square[0, 0])
        right, up = rows[0, :3] / per_metre, -rows[1, :3] / per_metre
        towards = np.cross(right, up)
        if not towards[2] > 0:
            raise InvalidInput(
                f"Camera: projection looks along z = {-towards[2]:+.3g}; must look down. Rows count "
                "downwards in the picture. Is the second row's sign that of an axis that points up?"
            )
        height, width = shape
        off = [(width - 1) / 2 - rows[0, 3], rows[1, 3] - (height - 1) / 2]
        centre = (off[0] * right + off[1] * up) / per_metre
        tilt, lean = math.atan2(towards[1], towards[2]), math.asin(min(max(towards[0], -1.0), 1.0))
        upright = cls(tilt=math.degrees(tilt), lean=math.degrees(lean)).axes
        return cls(
            mm_per_px=1e3 / per_metre,
            width=width,
            height=height,
            centre=(float(centre[0]), float(centre[1]), float(centre[2])),
            tilt=math.degrees(tilt),
            lean=math.degrees(lean),
            roll=math.degrees(math.atan2(upright[0] @ up, upright[0] @ right)),
        )

    def project(self, points: Floats) -> Floats:
        """(n, 3) column px, row px and height m of points (n, 3) m; see `projection`."""
        projection = self.projection
        return np.asarray(points @ projection[:, :3].T + projection[:, 3])

    def tilt_derivatives(self) -> tuple[Floats, Floats]:
        """(3, 4) each: derivatives of `projection` with respect to `tilt` and `lean`, per degree."""
        roll, lean, tilt = self._rotations()
        about_x = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
        about_y = np.array([[0.0, 0.0, -1.0], [0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
        degree = math.radians(1.0)
        by_tilt = self._projected(degree * roll @ lean @ tilt @ about_x)
        by_lean = self._projected(degree * roll @ lean @ about_y @ tilt)
        return by_tilt, by_lean

    def _rotations(self) -> tuple[Floats, Floats, Floats]:
        """(3, 3) rotations of roll, lean and tilt; tilt is applied first."""
        tilt, lean, roll = (math.radians(angle) for angle in (self.tilt, self.lean, self.roll))
        return (
            np.array([[math.cos(roll), -math.sin(roll), 0], [math.sin(roll), math.cos(roll), 0], [0, 0, 1]]),
            np.array([[math.cos(lean), 0, -math.sin(lean)], [0, 1, 0], [math.sin(lean), 0, math.cos(lean)]]),
            np.array([[1, 0, 0], [0, math.cos(tilt), -math.sin(tilt)], [0, math.sin(tilt), math.cos(tilt)]]),
        )

    def _projected(self, axes: Floats) -> Floats:
        """(3, 4) projection of axes (3, 3) or their derivative, without the offset of the picture's
        middle."""
        rows = axes * (np.array([1.0, -1.0, self.pixel]) / self.pixel)[:, None]
        return np.column_stack([rows, -rows @ np.array(self.centre, dtype=float)])
