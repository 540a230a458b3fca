"""The cross-sectional geometry of Paper D, Fig. 1, in the picture and in metres.

The anterior and the posterior commissure A and P lie on a circle of radius r_in about O, the middle between
them; the tissue ends at r_out. The visible glottis ends at P0, l_occ before P. Between z2 and z3 the airway
is the ellipse of half-axes (half_width, r_in); at z0, z1, z4 and z5 the circle. As the camera sees it, the
opening is what the airway's sections at all heights have in common, cut at P0.

Paper D closes the ends by circular sectors of angles alpha_R, alpha_L and epsilon, which its text does not
define; here the ellipse is complete.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from plica.camera.pose import Camera
from plica.larynx_fit.settings import FitSettings

__all__ = ["CrossSection", "Rays"]

Floats = NDArray[np.float64]

_BETWEEN = 6  # heights in a slope of the airway, including both ends


@dataclass(frozen=True)
class Rays:
    """Directions from O in which the opening is measured, in units of (half_width, r_in).

    Attributes
    ----------
    direction : (k, 2)
        Unit vectors (x, y) in these units.
    """

    direction: Floats

    @classmethod
    def of(cls, count: int) -> Rays:
        """Rays at equal angles."""
        angle = 2 * np.pi * (np.arange(count) + 0.5) / count
        return cls(np.stack([np.cos(angle), np.sin(angle)], axis=1))

    def ellipse(self, offset: Floats, axes: Floats) -> Floats:
        """(k) distance to the ellipse of half-axes (2) about `offset` (2) along the rays, in their units.

        |(s d - offset) / axes| = 1, the larger root; 0 where O is outside.
        """
        d, e = self.direction / axes, offset / axes
        a, b, c = (d * d).sum(axis=1), d @ e, float(e @ e) - 1.0
        return np.zeros(len(d)) if c >= 0 else np.asarray((b + np.sqrt(b * b - a * c)) / a)


@dataclass(frozen=True)
class CrossSection:
    """Cross-section of a larynx from a frame and the predefined lengths; lengths in m.

    Attributes
    ----------
    settings : FitSettings
    camera : Camera
        Camera of the frame, with the larynx's origin O at the height z = 0.
    half_width : float
        Half-width of the glottis at mid-length.
    r_in : float
    """

    settings: FitSettings
    camera: Camera
    half_width: float
    r_in: float

    @property
    def r_out(self) -> float:
        """Radius of the outer boundary."""
        return self.r_in + self.settings.metres("wall")

    @property
    def l_occ(self) -> float:
        """Hidden length at the posterior end."""
        return self.settings.metres("l_occ")

    @property
    def axes(self) -> Floats:
        """(2) half_width and r_in: the units of the rays."""
        return np.array([self.half_width, self.r_in])

    @cached_property
    def picture(self) -> tuple[Floats, Floats]:
        """M (2, 2) and o (2): the point (x, y, z3), x and y in `axes`, is at o + M (x, y) px."""
        projection = self.camera.projection
        origin = projection[:2, 2] * self.settings.heights[3] + projection[:2, 3]
        return projection[:2, :2] * self.axes, origin

    def place(self, points: Floats) -> Floats:
        """(n, 2) px of points (n, 2) m of the plane z = z3."""
        matrix, origin = self.picture
        return np.asarray(points / self.axes @ matrix.T + origin)

    def inside(self, pixels: Floats) -> Floats:
        """(n, 2) m in the plane z = z3 of positions (n, 2) px; the inverse of `place`."""
        matrix, origin = self.picture
        return np.asarray(np.linalg.solve(matrix, (pixels - origin).T).T * self.axes)

    @cached_property
    def climb(self) -> Floats:
        """(2) shift of a point in the picture with its height, in the rays' units per m."""
        matrix, _ = self.picture
        return np.asarray(np.linalg.solve(matrix, self.camera.projection[:2, 2]))

    @property
    def middle(self) -> float:
        """m, height of the glottis' middle, where the rays start: the visible opening is symmetric about
        it."""
        return 0.5 * (self.settings.heights[2] + self.settings.heights[3])

    @property
    def centre(self) -> Floats:
        """(2) px, where the rays start."""
        matrix, origin = self.picture
        return np.asarray(origin + matrix @ self.climb * (self.middle - self.settings.heights[3]))

    def from_centre(self, pixels: Floats) -> Floats:
        """(n, 2) positions (n, 2) px relative to `centre`, in the rays' units; the inverse of `outline`."""
        matrix, _ = self.picture
        return np.asarray(np.linalg.solve(matrix, (pixels - self.centre).T).T)

    @property
    def commissures(self) -> Floats:
        """(3, 2) px: A, P0 and P, at the height z3."""
        y = np.array([self.r_in, self.l_occ - self.r_in, -self.r_in])
        return self.place(np.stack([np.zeros(3), y], axis=1))

    @property
    def sections(self) -> tuple[tuple[float, float], ...]:
        """(z, half-axis x) of the airway, m, upward."""
        circle, slit = self.r_in, self.half_width
        return tuple(zip(self.settings.heights, (circle, circle, slit, slit, circle, circle), strict=True))

    def reach(self, rays: Rays) -> Floats:
        """(k) extent of the visible opening along the rays, in their units."""
        heights, minors = np.array(self.sections).T
        z = np.concatenate(
            [heights[[0, 2, 5]], *(np.linspace(heights[k], heights[k + 1], _BETWEEN) for k in (1, 3))]
        )
        reach = np.full(len(rays.direction), np.inf)
        for height, minor in zip(z, np.interp(z, heights, minors), strict=True):
            offset = self.climb * (height - self.middle)
            np.minimum(reach, rays.ellipse(offset, np.array([minor / self.half_width, 1.0])), out=reach)
        return self.cut(rays, reach)

    def cut(self, rays: Rays, reach: Floats) -> Floats:
        """(k) the extent limited at P0."""
        if self.l_occ == 0:
            return reach
        end = self.l_occ / self.r_in - 1 + self.climb[1] * (self.settings.heights[3] - self.middle)
        return np.asarray(np.minimum(reach, end / np.minimum(rays.direction[:, 1], -1e-12)))

    def outline(self, rays: Rays, reach: Floats) -> Floats:
        """(k, 2) px: the edge of the opening, once around."""
        matrix, _ = self.picture
        return np.asarray((rays.direction * reach[:, None]) @ matrix.T + self.centre)

    def asymmetry(self, contour: Floats) -> float:
        """(right - left) / (right + left) of the areas that a contour (n, 2) px has beside the midline."""
        x, y = self.from_centre(contour).T
        areas = []
        for side in (-1.0, 1.0):
            u = np.maximum(side * x, 0.0)
            areas.append(abs(0.5 * float(u @ np.roll(y, -1) - np.roll(u, -1) @ y)))
        return (areas[1] - areas[0]) / max(areas[0] + areas[1], 1e-300)
