"""A picture of a larynx before it moves: its middle plane with the layers, and the glottis from above."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure

from plica import _engine
from plica.errors import InvalidInput
from plica.measures.record import Floats
from plica.report.drawing import air, style, tissue
from plica.storage.files import replaced

__all__ = ["draw_glottis"]

_SUFFIXES = (".svg", ".png", ".pdf")
_LAYERS = ("#e3b7a0", "#f0d28c", "#d2603a", "#8d66bf", "#3f9b6c", "#3b82c4")
_INK = ("text.color", "axes.edgecolor", "axes.labelcolor", "xtick.color", "ytick.color")
_PAPER: dict[str, Any] = {
    **dict.fromkeys(_INK, "black"),
    "figure.facecolor": "white",
    "savefig.facecolor": "white",
    "svg.hashsalt": "glottis",
}
_BEYOND = 2.5  # mm, shown below and above the layers
_HEIGHTS = 400  # lines across the glottis, from back to front


def draw_glottis(mesh: _engine.TetMesh, path: Path) -> None:
    """Draw the middle plane and the view from above to an SVG, PNG or PDF file.

    Raises
    ------
    InvalidInput
        For another suffix, or a mesh without a surface ``airway`` between two folds.
    """
    if path.suffix.lower() not in _SUFFIXES:
        raise InvalidInput(f"{path}: must be a picture, {', '.join(_SUFFIXES)}.")
    airway = mesh.surfaces.get("airway")
    if airway is None:
        raise InvalidInput(f'{path}: the mesh has no surface "airway"; a glottis cannot be drawn.')
    points = 1e3 * np.asarray(mesh.points)  # mm
    corners = points[np.asarray(airway)[:, :3]]
    middle = 0.5 * float(corners[..., 1].min() + corners[..., 1].max())
    settings: Any = {**style, **_PAPER}
    with mpl.rc_context(settings):
        figure = Figure(figsize=(9.5, 4.2), layout="constrained")
        coronal, above = figure.subplots(1, 2)
        _paint_coronal(coronal, mesh, points, middle)
        _paint_above(above, corners, float(np.abs(points[:, 0]).max()))
        options: dict[str, Any] = {"format": path.suffix.lower()[1:]}
        if options["format"] == "svg":
            options["metadata"] = {"Date": None}
        replaced(path, lambda draft: figure.savefig(draft, **options))


def _paint_coronal(axes: Axes, mesh: _engine.TetMesh, points: Floats, middle: float) -> None:
    """Layers in the plane of constant y, seen from the front's side: the right fold is on the right."""
    layer = np.asarray(mesh.cell_layer)
    cells = np.asarray(mesh.cells)[:, :4]
    names = list(mesh.layer_names)
    heights = []
    for number, name in enumerate(names):
        polygons = plane_cut(points[cells[layer == number]], middle)
        colour = _LAYERS[number % len(_LAYERS)]
        axes.add_collection(PolyCollection(polygons, facecolor=colour, edgecolor=colour, linewidth=0.3))
        axes.plot([], [], color=colour, linewidth=6, label=name)
        if number > 0 and polygons:
            heights += [z for polygon in polygons for z in polygon[:, 1]]
    seen = points[:, 2] if not heights else np.array(heights)
    reach = 0.5 * (seen.max() - seen.min()) + _BEYOND if heights else 0.5 * float(np.ptp(seen))
    centre = 0.5 * (seen.max() + seen.min())
    axes.set(
        xlim=(-1.3 * reach, 1.3 * reach),
        ylim=(centre - reach, centre + reach),
        aspect="equal",
        xlabel="left          x (mm)          right",
        ylabel="z (mm), upward",
        title="middle plane",
    )
    axes.legend(loc="upper center", ncols=len(names))


def _paint_above(axes: Axes, corners: Floats, wall: float) -> None:
    """The narrowest opening at each place along the glottis, front at the top."""
    y, left, right = narrowest(corners)
    axes.add_patch(mpl.patches.Circle((0, float(y.mean())), wall, facecolor=tissue, edgecolor="none"))
    axes.fill_betweenx(y, left, right, color=air)
    widest = int(np.argmax(right - left))
    axes.set(
        xlim=(-1.05 * wall, 1.05 * wall),
        ylim=(y.mean() - 1.05 * wall, y.mean() + 1.05 * wall),
        aspect="equal",
        xlabel="left          x (mm)          right",
        ylabel="back          y (mm)          front",
        title=f"from above: {np.ptp(corners[..., 1]):.1f} mm long, {right[widest] - left[widest]:.2f} mm wide",
    )


def plane_cut(corners: Floats, y: float) -> list[Floats]:
    """The polygons, each (3 or 4, 2) of x and z, in which tetrahedra (m, 4, 3) meet a plane of constant y."""
    beyond = corners[..., 1] > y
    polygons = []
    for tetrahedron, above in zip(corners, beyond, strict=True):
        if above.all() or not above.any():
            continue
        cut = [
            a + (y - a[1]) / (b[1] - a[1]) * (b - a) for a in tetrahedron[above] for b in tetrahedron[~above]
        ]
        found = np.array(cut)[:, [0, 2]]
        around = found - found.mean(axis=0)
        polygons.append(found[np.argsort(np.arctan2(around[:, 1], around[:, 0]))])
    return polygons


def narrowest(corners: Floats) -> tuple[Floats, Floats, Floats]:
    """Places y and the narrowest opening there, from x left to x right, between the triangles (f, 3, 3)."""
    y = np.linspace(corners[..., 1].min(), corners[..., 1].max(), _HEIGHTS + 2)[1:-1]
    facing = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 0]
    places, left, right = [], [], []
    for at in y:
        sides = [_crossings(corners[facing * sign > 0], at) for sign in (1, -1)]
        if all(len(side) for side in sides):
            places.append(at)
            left.append(sides[0].max())
            right.append(sides[1].min())
    if not places:
        raise InvalidInput('the surface "airway" must have two folds that face each other along x.')
    return np.array(places), np.array(left), np.array(right)


def _crossings(corners: Floats, y: float) -> Floats:
    """x at which edges of triangles cross a plane of constant y."""
    a, b = corners, np.roll(corners, -1, axis=1)
    crossing = (a[..., 1] - y) * (b[..., 1] - y) < 0
    a, b = a[crossing], b[crossing]
    return np.asarray(a[:, 0] + (y - a[:, 1]) / (b[:, 1] - a[:, 1]) * (b[:, 0] - a[:, 0]))
