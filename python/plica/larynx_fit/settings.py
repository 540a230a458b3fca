"""Settings of a larynx fit: geometry that a picture of the folds does not show."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from plica.camera.pose import Camera
from plica.errors import InvalidInput
from plica.units import read_quantity

__all__ = ["FitSettings"]

Length = float | str
Point = tuple[float, float]


@dataclass(frozen=True, kw_only=True)
class FitSettings:
    """Predefined geometry of Paper D, Sec. 2.3, and the mesh of the larynx; lengths in m, or with a unit.

    Either `mm_per_px` or `r_in` gives the scale: the length follows from the pixel's size or, as in the
    thesis, the pixel's size from a predefined length.

    Raises
    ------
    InvalidInput
        For a field that is out of range, and if not exactly one of `mm_per_px` and `r_in` is given.
    """

    mm_per_px: float | None = None
    """Size of a pixel across the line of sight, mm, in [1e-4, 10]."""
    r_in: Length | None = None
    """Half the distance from the anterior to the posterior commissure, > 0."""
    wall: Length = 1e-3
    """r_out - r_in: from the airway's circle to the outer boundary, > 0."""
    l_occ: Length = 0.0
    """Length of the folds' posterior end hidden by cartilage, in [0, r_in)."""
    z: tuple[Length, Length, Length, Length, Length, Length] = (
        -12e-3,
        -7e-3,
        -4e-3,
        0.0,
        2e-3,
        12e-3,
    )
    """z0 ... z5, ascending: lower end, end of the lower tube, lower and upper edge of the glottis, start of
    the upper tube, upper end."""
    layer_thickness: Length = 0.5e-3
    """Thickness of cover and of ligament, > 0."""
    tilt: float = 0.0
    """Tilt of the camera towards anterior, degrees, in (-45, 45)."""
    lean: float = 0.0
    """Tilt of the camera towards the right fold, degrees, in (-45, 45)."""
    anterior: Literal["upper", "lower"] = "upper"
    """The anterior end of the glottis in the picture."""
    commissures: tuple[Point, Point] | None = None
    """Points A and P0 (column, row) px, where the visible glottis ends; None: fitted."""
    larynx: Literal["coarse", "demo", "fine", "finest"] = "demo"
    """Preset that defines the cell sizes."""
    order: Literal[1, 2] = 2
    """2: quadratic tetrahedra."""
    largest_error: float = 0.05
    """Largest distance between glottal edge and contour, 95th percentile relative to the visible length, in
    (0, 1]; a larynx with a larger one is refused."""

    def __post_init__(self) -> None:
        if (self.mm_per_px is None) == (self.r_in is None):
            raise InvalidInput(
                f"Larynx fit: mm_per_px = {self.mm_per_px}, r_in = {self.r_in}; must be exactly one of the "
                "two. A picture has no scale: give the size of a pixel, or half the folds' length."
            )
        if self.mm_per_px is not None:
            self._number("mm_per_px", 1e-4, 10.0, "mm")
        if self.r_in is not None:
            self._length("r_in", positive=True)
        self._length("wall", positive=True)
        self._length("layer_thickness", positive=True)
        self._length("l_occ", positive=False)
        if self.r_in is not None and not self.metres("l_occ") < self.metres("r_in"):
            raise InvalidInput(
                f"Larynx fit: l_occ = {self.l_occ} m; must be < r_in = {self.r_in} m. Is the unit right?"
            )
        self._heights()
        for name in ("tilt", "lean"):
            self._number(name, -44.999, 44.999, "degrees")
        self._number("largest_error", 1e-6, 1.0, "")
        for name, choices in (
            ("anterior", ("upper", "lower")),
            ("larynx", ("coarse", "demo", "fine", "finest")),
            ("order", (1, 2)),
        ):
            if getattr(self, name) not in choices:
                raise InvalidInput(f"Larynx fit: {name} = {getattr(self, name)!r}; must be one of {choices}.")
        if self.commissures is not None:
            self._points()

    def metres(self, name: str) -> float:
        """A length as a number, m."""
        return float(getattr(self, name))

    @property
    def heights(self) -> tuple[float, ...]:
        """z0 ... z5, m."""
        return tuple(float(z) for z in self.z)

    def camera(self, mm_per_px: float, shape: tuple[int, ...], centre: Point, roll: float) -> Camera:
        """The camera that shows (0, 0, z3), between the folds' upper edges, at `centre` (column, row)."""
        own = Camera(
            mm_per_px=mm_per_px,
            height=shape[0],
            width=shape[1],
            tilt=self.tilt,
            lean=self.lean,
            roll=roll,
        )
        right, up, _ = own.axes
        seen = own.project(np.array([[0.0, 0.0, self.heights[3]]]))[0]
        off = own.pixel * ((seen[0] - centre[0]) * right - (seen[1] - centre[1]) * up)
        return Camera(
            mm_per_px=mm_per_px,
            height=shape[0],
            width=shape[1],
            centre=(float(off[0]), float(off[1]), float(off[2])),
            tilt=self.tilt,
            lean=self.lean,
            roll=roll,
        )

    def _length(self, name: str, *, positive: bool) -> None:
        value = self._metres(name, getattr(self, name))
        if value < 0 or (positive and value == 0):
            raise InvalidInput(f"Larynx fit: {name} = {value:g} m; must be {'> 0' if positive else '>= 0'}.")
        object.__setattr__(self, name, value)

    def _heights(self) -> None:
        if len(self.z) != 6:
            raise InvalidInput(f"Larynx fit: z has {len(self.z)} heights; must have 6, z0 to z5.")
        z = tuple(self._metres(f"z[{k}]", value) for k, value in enumerate(self.z))
        for k in range(5):
            if not z[k] < z[k + 1]:
                raise InvalidInput(
                    f"Larynx fit: z[{k + 1}] = {z[k + 1]:g} m; must be > z[{k}] = {z[k]:g} m. z points up."
                )
        object.__setattr__(self, "z", z)

    def _points(self) -> None:
        try:
            ends = np.array(self.commissures, dtype=float)
        except (TypeError, ValueError):
            ends = np.zeros(0)
        if ends.shape != (2, 2) or not np.isfinite(ends).all() or np.array_equal(ends[0], ends[1]):
            raise InvalidInput(
                f"Larynx fit: commissures = {self.commissures!r}; must be two points, (column, row) of A and "
                "of P0 in px."
            )
        rows = (float(ends[0, 1]), float(ends[1, 1]))
        if (rows[0] < rows[1]) != (self.anterior == "upper"):
            raise InvalidInput(
                f"Larynx fit: rows of A and P0 = {rows[0]:g}, {rows[1]:g} px; must have A as the "
                f"{self.anterior} one, since anterior = {self.anterior!r}."
            )

    @staticmethod
    def _metres(name: str, value: object) -> float:
        try:
            return read_quantity(float(value) if isinstance(value, np.number) else value, "m")
        except ValueError as error:
            raise InvalidInput(f"Larynx fit: {name} = {value!r}; {error}") from None

    def _number(self, name: str, least: float, most: float, unit: str) -> None:
        value = getattr(self, name)
        if (
            isinstance(value, bool)
            or not isinstance(value, int | float | np.integer | np.floating)
            or not least <= value <= most
        ):
            shown = f"{value!r} {unit}".rstrip()
            raise InvalidInput(
                f"Larynx fit: {name} = {shown}; must be a number in [{least:g}, {most:g}]. Is the unit right?"
            )
