"""A picture of a larynx before it moves: its middle plane with the layers, and the glottis from above."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure

from plica import _engine
from plica.errors import InvalidInput
from plica.measures.contour import coronal_contours, rest_contour
from plica.measures.mesh_data import toward_right
from plica.measures.record import Array, Floats
from plica.report.drawing import air, style, tissue
from plica.storage.files import replaced

__all__ = ["draw_glottis"]

_SUFFIXES = (".svg", ".png", ".pdf")
_LAYERS = ("#e3b7a0", "#f0d28c", "#d2603a", "#8d66bf", "#3f9b6c", "#3b82c4")
_LESION = "#5b1a3a"
_INK = ("text.color", "axes.edgecolor", "axes.labelcolor", "xtick.color", "ytick.color")
_PAPER: dict[str, Any] = {
    **dict.fromkeys(_INK, "black"),
    "figure.facecolor": "white",
    "savefig.facecolor": "white",
    "svg.hashsalt": "glottis",
}
_WIDER = 3.0  # mm: as far as the glottis is wider than where it is narrowest by no more, it is drawn,
_BEYOND = 1.5  # mm, and so much beyond
_PLACES = 400  # from back to front
_ACROSS, _ALONG = ("left", "x (mm)", "right"), ("back", "y (mm)", "front")


def draw_glottis(mesh: _engine.TetMesh, path: Path, lesions: Sequence[Array] = ()) -> None:
    """Draw the middle plane and the view from above to an SVG, PNG or PDF file.

    Parameters
    ----------
    mesh : TetMesh
    path : Path
    lesions : sequence of (any)
        The cells of each lesion. They are marked, and the plane is that of the middle of the first.

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
    points, faces = 1e3 * np.asarray(mesh.points, dtype=float), np.asarray(airway)  # mm
    if not len(rest_contour(points, faces)):
        raise InvalidInput(f'{path}: the surface "airway" must have two folds that face each other along x.')
    settings: Any = {**style, **_PAPER}
    with mpl.rc_context(settings):
        figure = Figure(figsize=(9.5, 4.2), layout="constrained")
        coronal, above = figure.subplots(1, 2)
        _paint_coronal(coronal, mesh, points, faces, lesions)
        _paint_above(above, mesh, points, faces, lesions)
        options: dict[str, Any] = {"format": path.suffix.lower()[1:]}
        if options["format"] == "svg":
            options["metadata"] = {"Date": None}
        replaced(path, lambda draft: figure.savefig(draft, **options))


def _axis(mesh: _engine.TetMesh, names: tuple[str, str, str]) -> str:
    """Both ends of an axis and its unit; the unit alone of a mesh without a left and a right fold."""
    direction = toward_right(mesh.points, mesh.cells, mesh.cell_side)
    return (" " * 10).join(names[::direction]) if direction else names[1]


def _paint_coronal(
    axes: Axes, mesh: _engine.TetMesh, points: Floats, faces: Array, lesions: Sequence[Array] = ()
) -> None:
    """Layers in the middle plane, or in that of a lesion."""
    z, smaller, larger = rest_contour(points, faces).T
    width = larger - smaller
    near = z[width <= width.min() + _WIDER]
    reach, height = 0.5 * float(np.ptp(near)) + _BEYOND, 0.5 * float(near.min() + near.max())
    middle = float(0.5 * (smaller + larger)[width.argmin()])
    y = points[np.unique(faces), 1]
    layer, cells = np.asarray(mesh.cell_layer), np.asarray(mesh.cells)[:, :4]
    plane = 0.5 * float(y.min() + y.max())
    title = "middle plane"
    if lesions:
        extent = points[cells[lesions[0]], 1]
        plane = 0.5 * float(extent.min() + extent.max())
        title = f"y = {plane:.2g} mm, through the lesion"
    for number, name in enumerate(mesh.layer_names):
        polygons = plane_cut(points[cells[layer == number]], plane)
        colour = _LAYERS[number % len(_LAYERS)]
        axes.add_collection(PolyCollection(polygons, facecolor=colour, edgecolor=colour, linewidth=0.3))
        axes.plot([], [], color=colour, linewidth=6, label=name)
    for own in lesions:
        axes.add_collection(PolyCollection(plane_cut(points[cells[own]], plane), color=_LESION))
    if lesions:
        axes.plot([], [], color=_LESION, linewidth=6, label="lesion")
    axes.set(
        xlim=(middle - 1.3 * reach, middle + 1.3 * reach),
        ylim=(height - reach, height + reach),
        aspect="equal",
        xlabel=_axis(mesh, _ACROSS),
        ylabel="z (mm), upward",
        title=title,
    )
    axes.legend(loc="upper center", ncols=len(mesh.layer_names) + bool(lesions))


def _paint_above(
    axes: Axes, mesh: _engine.TetMesh, points: Floats, faces: Array, lesions: Sequence[Array] = ()
) -> None:
    """The narrowest opening at each place along the glottis."""
    from scipy.spatial import ConvexHull

    y, left, right = narrowest(points, faces)
    outline = points[ConvexHull(points[:, :2]).vertices, :2]
    axes.fill(*outline.T, color=tissue)
    for own in lesions:
        seen = points[np.unique(np.asarray(mesh.cells)[own, :4]), :2]
        axes.fill(*seen[ConvexHull(seen).vertices].T, color=_LESION)
    axes.fill_betweenx(y, left, right, color=air)
    widest = int(np.argmax(right - left))
    length = float(np.ptp(points[np.unique(faces), 1]))
    axes.set(
        aspect="equal",
        xlabel=_axis(mesh, _ACROSS),
        ylabel=_axis(mesh, _ALONG),
        title=f"from above: {length:.1f} mm long, {right[widest] - left[widest]:.2f} mm wide",
    )


def plane_cut(corners: Floats, y: float) -> list[Floats]:
    """The polygons, each (3 or 4, 2) of x and z, in which tetrahedra (m, 4, 3) meet a plane of constant y."""
    beyond = corners[..., 1] > y
    polygons = []
    crossing = beyond.any(axis=1) & ~beyond.all(axis=1)
    for tetrahedron, above in zip(corners[crossing], beyond[crossing], strict=True):
        cut = [
            a + (y - a[1]) / (b[1] - a[1]) * (b - a) for a in tetrahedron[above] for b in tetrahedron[~above]
        ]
        found = np.array(cut)[:, [0, 2]]
        around = found - found.mean(axis=0)
        polygons.append(found[np.argsort(np.arctan2(around[:, 1], around[:, 0]))])
    return polygons


def narrowest(points: Floats, faces: Array) -> tuple[Floats, Floats, Floats]:
    """Places y between both ends of an airway and the narrowest opening there, from x left to x right, in the
    unit of the points."""
    ends = points[np.unique(faces), 1]
    found = []
    for y in np.linspace(ends.min(), ends.max(), _PLACES + 2)[1:-1]:
        larger, smaller = coronal_contours(points, faces, float(y))
        if len(larger) and len(smaller):
            found.append((y, smaller[:, 1].max(), larger[:, 1].min()))
    y, left, right = np.array(found).T
    return y, left, right
