"""Fit of the cross-section whose visible opening is closest to a contour."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from plica.camera.pose import Camera
from plica.errors import InvalidInput, SolveFailed
from plica.larynx_fit.contour import Contour
from plica.larynx_fit.cross_section import CrossSection, Rays
from plica.larynx_fit.distances import to_outline
from plica.larynx_fit.settings import FitSettings

__all__ = ["fit_cross_section"]

Floats = NDArray[np.float64]

_RAYS = 180
_POINTS = 300  # of the contour, at most


def fit_cross_section(contour: Contour, settings: FitSettings, shape: tuple[int, ...]) -> CrossSection:
    """Least squares of the distances between the contour and the visible opening's edge, both ways.

    Unknown are the half-width and, unless the commissures are given, A and P0: position of O, rotation of the
    picture, length of the visible glottis. Gauss-Newton in a trust region, starting from the contour's
    midline.

    Raises
    ------
    InvalidInput
        If the glottis is as wide as half its length, or its hidden end as long as its visible part.
    """
    from scipy import optimize

    line = contour.midline
    upper, lower = np.array(line.upper), np.array(line.lower)
    ends = (upper, lower) if settings.anterior == "upper" else (lower, upper)
    if settings.commissures is not None:
        ends = (np.array(settings.commissures[0], float), np.array(settings.commissures[1], float))
        _check_commissures(ends, shape)
    begin = _turn(ends[0] - ends[1])
    _check_hidden(settings, float(np.hypot(*(ends[0] - ends[1]))))
    start = _start(contour, settings, ends)
    free = np.array([settings.commissures is None] * 4 + [True])
    points = contour.points[:: len(contour.points) // _POINTS + 1]
    rays = Rays.of(_RAYS)

    def section_of(values: Floats) -> CrossSection:
        every = start.copy()
        every[free] = values
        return _section(settings, shape, every, begin)

    def residuals(values: Floats) -> Floats:
        section = section_of(values)
        edge = section.outline(rays, section.reach(rays))
        apart = to_outline(points, edge)
        off = np.where(_beyond(section, points), apart, -apart) * _share(points)
        return np.concatenate([off, to_outline(edge, points) * _share(edge)])

    found: Any = optimize.least_squares(
        residuals, start[free], x_scale=np.array([1.0, 1.0, 0.01, 0.01, 0.1])[free]
    )
    if not found.success:
        raise SolveFailed(f"Larynx fit: {found.message} Is the contour that of a single opening?")
    section = section_of(found.x)
    if not section.half_width < 0.5 * section.r_in:
        raise InvalidInput(
            f"Larynx fit: half-width = {1e3 * section.half_width:.3g} mm; must be < r_in / 2 = "
            f"{500 * section.r_in:.3g} mm. Is this a glottis with the folds near each other?"
        )
    return section


def _start(contour: Contour, settings: FitSettings, ends: tuple[Floats, Floats]) -> Floats:
    """Initial unknowns of `_section` from the contour's ends and area, and the width hidden by the lean."""
    length = float(np.hypot(*(ends[0] - ends[1])))
    pixel = 2 * settings.metres("r_in") / length if settings.mm_per_px is None else 1e-3 * settings.mm_per_px
    depth = settings.heights[3] - settings.heights[2]
    hidden = 0.5 * depth * abs(np.sin(np.radians(settings.lean))) / pixel
    width = 0.6 * contour.area / length + hidden
    return np.array([*(0.5 * (ends[0] + ends[1])), 0.0, np.log(length), np.log(width)])


def _section(settings: FitSettings, shape: tuple[int, ...], values: Floats, begin: float) -> CrossSection:
    """The cross-section of values: column and row of the middle of A and P0, px, their direction, rad, log of
    their distance, px; log of the half-width, px."""
    column, row, turn, length, width = values
    upright = Camera(tilt=settings.tilt, lean=settings.lean)
    seen = upright.axes[:2, 1]  # of y: right and up in the picture
    roll = float(np.degrees(begin + turn - np.arctan2(seen[1], seen[0])))
    visible = float(np.exp(length) / np.hypot(*seen))  # px, were it seen from straight above
    if settings.mm_per_px is None:
        r_in = settings.metres("r_in")
        mm_per_px = 1e3 * (2 * r_in - settings.metres("l_occ")) / visible
    else:
        mm_per_px = settings.mm_per_px
        r_in = 0.5 * (1e-3 * mm_per_px * visible + settings.metres("l_occ"))
    along = np.array([np.cos(begin + turn), -np.sin(begin + turn)])  # column, row: towards anterior
    hidden = settings.metres("l_occ") / (1e-3 * mm_per_px) * np.hypot(*seen)
    middle = np.array([column, row]) - 0.5 * hidden * along
    camera = settings.camera(mm_per_px, shape, (float(middle[0]), float(middle[1])), (roll + 180) % 360 - 180)
    return CrossSection(settings, camera, float(np.exp(width)) * 1e-3 * mm_per_px, r_in)


def _share(outline: Floats) -> Floats:
    """(n) root of each corner's share of a closed polygon's length."""
    side = np.linalg.norm(np.roll(outline, -1, axis=0) - outline, axis=1)
    return np.asarray(np.sqrt(0.5 * (side + np.roll(side, 1)) / max(float(side.sum()), 1e-300)))


def _turn(to_anterior: Floats) -> float:
    """Angle of a direction (column, row), rad, anticlockwise as seen, 0 to the right."""
    return float(np.arctan2(-to_anterior[1], to_anterior[0]))


def _beyond(section: CrossSection, points: Floats) -> NDArray[np.bool_]:
    """(n) whether points (n, 2) px lie outside the visible opening."""
    place = section.from_centre(points)
    far = np.maximum(np.hypot(*place.T), 1e-12)
    return np.asarray(far > section.reach(Rays(place / far[:, None])))


def _check_hidden(settings: FitSettings, length: float) -> None:
    """Raises InvalidInput if the hidden end is as long as the visible glottis (px)."""
    if settings.mm_per_px is None:
        return
    visible = 1e-3 * settings.mm_per_px * length
    hidden = settings.metres("l_occ")
    if not hidden < visible:
        raise InvalidInput(
            f"Larynx fit: l_occ = {hidden:g} m; must be < {visible:.3g} m, the length of the visible "
            "glottis. Are l_occ and mm_per_px right?"
        )


def _check_commissures(ends: tuple[Floats, Floats], shape: tuple[int, ...]) -> None:
    for name, (column, row) in zip(("A", "P0"), ends, strict=True):
        if not (0 <= column <= shape[1] - 1 and 0 <= row <= shape[0] - 1):
            raise InvalidInput(
                f"Larynx fit: {name} = ({column:g}, {row:g}) px; must lie in the picture of {shape[1]} x "
                f"{shape[0]} px. Column first, then row."
            )
