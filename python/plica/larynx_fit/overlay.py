"""A picture of the fitted larynx over the frame."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from plica.larynx_fit.fit import LarynxFit
from plica.report.drawing import Drawing, blue, draw, green, label_ends, purple, red

__all__ = ["overlay"]

Floats = NDArray[np.float64]

_WIDE = 6.0  # inches
_AROUND = 1.4  # of r_in: the part of the picture shown


def overlay(fitted: LarynxFit) -> Drawing:
    """The frame, the contour, the mesh's superior surface and glottal edge, A, P0 and P, as SVG."""
    error, camera = fitted.error, fitted.camera
    caption = (
        f"Distance between contour and glottal edge of the mesh: mean {error.mean:.2f} px, 95th percentile "
        f"{error.percentile_95:.2f} px, largest {error.largest:.2f} px. Half-width "
        f"{1e3 * fitted.section.half_width:.3g} mm, r_in {1e3 * fitted.section.r_in:.3g} mm, "
        f"{camera.mm_per_px:.3g} mm per pixel."
    )
    (left, top), (right, bottom) = _shown(fitted)
    size = (_WIDE, float(np.clip(_WIDE * (bottom - top) / (right - left), 3.0, 9.0)) + 0.4)
    return draw(
        "Larynx fitted to a frame",
        caption,
        "Frame of the folds with the glottal contour and the edges of the fitted mesh",
        size,
        lambda figure: _paint(figure, fitted),
    )


def _paint(figure: Figure, fitted: LarynxFit) -> None:
    axes = figure.add_subplot()
    picture = fitted.contour.mask.astype(float) if fitted.frame is None else fitted.frame
    axes.imshow(picture, cmap="gray", interpolation="nearest")
    corners, triangles = fitted.seen.corners
    z = fitted.seen.rest[:, 2]
    own = (z[triangles] >= fitted.seen.z_from - 1e-9).all(axis=1)
    own &= (z[triangles] <= fitted.seen.z_to + 1e-9).all(axis=1)
    axes.triplot(corners[:, 0], corners[:, 1], triangles[own], color=purple, linewidth=0.35, alpha=0.7)
    axes.plot(*_closed(fitted.contour.points).T, color=red, linewidth=1.2)
    axes.plot(*_closed(fitted.edge).T, color=blue, linewidth=1.0)
    ends = fitted.section.commissures
    for name, (x, y) in zip(("A", "P0", "P"), ends, strict=True):
        if name == "P" and fitted.section.l_occ == 0:
            continue
        axes.plot(x, y, "o", color=green, markersize=3)
        axes.annotate(name, (x, y), (4, 4), textcoords="offset points", color=green)
    (left, top), (right, bottom) = _shown(fitted)
    axes.set_xlim(left, right)
    axes.set_ylim(bottom, top)
    axes.set_xlabel("px")
    axes.set_ylabel("px")
    label_ends(axes, [("contour", red), ("glottal edge of the mesh", blue), ("superior surface", purple)])


def _shown(fitted: LarynxFit) -> tuple[Floats, Floats]:
    """Smallest and largest column and row, px: the picture around the circle of radius r_in."""
    section = fitted.section
    reach = _AROUND * section.r_in / section.camera.pixel
    middle = section.place(np.zeros((1, 2)))[0]
    last = np.array([section.camera.width, section.camera.height]) - 0.5
    return np.maximum(middle - reach, -0.5), np.minimum(middle + reach, last)


def _closed(outline: Floats) -> Floats:
    return np.concatenate([outline, outline[:1]])
