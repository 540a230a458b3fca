"""One cycle in eight views, coronal and superior."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import PolyCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from plica.measures.record import Array, Floats
from plica.report.drawing import Drawing, air, draw, grey, rim, tissue
from plica.report.run.reading import Reading

phases = 8
contact = "#c8102e"


def phase_instants(reading: Reading) -> Floats:
    """Eight equidistant instants (s) of the last cycle, or of the last twentieth of a run without cycles."""
    if reading.cycles.count:
        start, end = (float(t) for t in reading.cycles.starts[-2:])
    else:
        start, end = float(reading.time[-max(reading.time.size // 20, 2)]), float(reading.time[-1])
    return start + (end - start) * np.arange(phases) / phases


def nearest_frames(reading: Reading, instants: Floats) -> list[int]:
    """The frame nearest to each instant; as in stroboscopy, frames of that phase from any steady cycle."""
    frames = np.asarray(reading.run.fields.get("time", np.empty(0)), dtype=float)
    frames = frames[np.isfinite(frames)]
    if not frames.size:
        return []
    if not reading.cycles.count:
        return [int(np.argmin(np.abs(frames - instant))) for instant in instants]
    starts, periods = reading.cycles.starts, reading.cycles.periods
    usable = np.flatnonzero((frames >= starts[0]) & (frames < starts[-1]))
    if not usable.size:
        return []
    cycle = np.searchsorted(starts, frames[usable], side="right") - 1
    phase = (frames[usable] - starts[cycle]) / periods[cycle]
    chosen = []
    for wanted in np.arange(phases) / phases:
        distance = np.abs((phase - wanted + 0.5) % 1.0 - 0.5)
        best = np.flatnonzero(distance <= distance.min() + 0.01)
        chosen.append(int(usable[best[-1]]))  # the latest of the nearest
    return chosen


def medial_edge(points: Floats, faces: Array, y: Floats, side: float) -> Floats:
    """Most medial x (m) of a surface at each y; NaN beyond its ends.

    Parameters
    ----------
    points : (n, 3) m
    faces : (f, 3) node numbers
    y : (g) m
    side : float
        1 for the right fold (smallest x), -1 for the left one (largest x).
    """
    edges = np.concatenate((faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]))
    edges = np.unique(np.sort(edges, axis=1), axis=0)
    a, b = points[edges[:, 0]], points[edges[:, 1]]
    span = np.where(np.abs(b[:, 1] - a[:, 1]) > 0, b[:, 1] - a[:, 1], np.nan)
    part = (y[:, None] - a[:, 1]) / span
    x = side * (a[:, 0] + part * (b[:, 0] - a[:, 0]))
    x = np.where((part >= 0) & (part <= 1), x, np.inf)
    least = x.min(axis=1)
    return side * np.where(np.isfinite(least), least, np.nan)


def pressure_scale(pressure: Floats) -> Normalize:
    """Colours of pressures (Pa) in kPa: from the deepest suction, 0 without any, to the largest pressure."""
    low, high = min(float(np.nanmin(pressure)), 0.0), max(float(np.nanmax(pressure)), 1.0)
    return Normalize(1e-3 * low, 1e-3 * high)


def coronal_cycle(reading: Reading) -> Drawing:
    """Eight coronal sections through one cycle, the airway coloured by its pressure."""
    instants = phase_instants(reading)
    steps = np.clip(np.searchsorted(reading.time, instants), 0, reading.time.size - 1)
    scale = pressure_scale(reading.wave("section_pressure"))

    def paint(figure: Figure) -> None:
        row = figure.subplots(1, phases)
        for i, axes in enumerate(row):
            _coronal(axes, reading, int(steps[i]), scale)
            _name_sides(axes)
            _frame(axes, first=i == 0, name="z (mm)")
            axes.set_title(f"{_phase(reading, i)}{1e3 * reading.time[steps[i]]:.2f} ms")
        bar = figure.colorbar(ScalarMappable(scale, "viridis"), ax=row, pad=0.01, aspect=12, shrink=0.8)
        bar.set_label("air pressure (kPa)")

    caption = (
        "Mid-coronal section at eight instants, the patient's left fold (L) at the left, the right (R) at "
        "the right; the airway is coloured by the pressure of the air."
    )
    alt = "Eight coronal sections of both folds through one cycle, with the air pressure between them."
    return draw("Coronal section", caption, alt, (11.0, 2.3), paint)


def superior_cycle(reading: Reading) -> Drawing | None:
    """Eight views from above through one cycle; None if the run has no frames or no named surfaces."""
    if not {"airway_left", "airway_right"} <= reading.run.mesh.surfaces.keys():
        return None
    frames = nearest_frames(reading, phase_instants(reading))
    if not frames:
        return None
    times = np.asarray(reading.run.fields["time"], dtype=float)[frames]
    outlines = [Outline.of(reading, frame) for frame in frames]
    reach = max(1.5 * max(outline.widest for outline in outlines), 0.1 * outlines[0].length)

    def paint(figure: Figure) -> None:
        for i, axes in enumerate(figure.subplots(1, phases)):
            _superior(axes, outlines[i], reach)
            _name_sides(axes)
            _name_ends(axes)
            _frame(axes, first=i == 0, name="y (mm)" if reading.midline()[1] > 0 else "-y (mm)")
            axes.set_title(f"{_phase(reading, i)}{1e3 * times[i]:.2f} ms")

    caption = (
        "The glottis seen from above: front (anterior) at the top, back (posterior) at the bottom, the "
        "patient's left fold (L) at the left, the right (R) at the right. Red where the folds touch. Each "
        "view is the stored frame nearest in phase, as in stroboscopy not always of the same cycle."
    )
    alt = (
        "Eight outlines of the glottis from above through one cycle, front above, the left fold to the left; "
        "contact marked in red."
    )
    height = min(1.0 + 1.25 * 0.5 * outlines[0].length / reach, 4.5)
    return draw("From above", caption, alt, (11.0, height), paint)


@dataclass(frozen=True)
class Outline:
    """The glottis from above in one frame, in mm: sideways from the midline, right > 0."""

    y: Floats
    left: Floats
    right: Floats
    touching: Floats

    @classmethod
    def of(cls, reading: Reading, frame: int) -> Outline:
        """From the displaced surfaces; where the edges cross, both are at their middle."""
        mesh, fields = reading.run.mesh, reading.run.fields
        rest = np.asarray(mesh.points, dtype=float)
        points = rest + np.asarray(fields["displacement"][frame], dtype=float)
        midline, toward_right = reading.midline()
        points[:, 0] -= midline
        points[:, :2] *= toward_right  # seen from above the right fold is drawn to the right
        faces = {side: np.asarray(mesh.surfaces[f"airway_{side}"])[:, :3] for side in ("left", "right")}
        ends = rest[np.unique(faces["right"]), 1] * toward_right
        y = np.linspace(float(ends.min()), float(ends.max()), 121)
        right, left = medial_edge(points, faces["right"], y, 1.0), medial_edge(points, faces["left"], y, -1.0)
        middle = 0.5 * (right + left)
        touching = np.empty((0, 3))
        if "contact_pressure" in fields:
            nodes = np.unique(np.concatenate(tuple(faces.values())))
            touching = points[nodes[np.asarray(fields["contact_pressure"][frame])[nodes] > 0]]
        return cls(1e3 * y, 1e3 * np.minimum(left, middle), 1e3 * np.maximum(right, middle), 1e3 * touching)

    @property
    def widest(self) -> float:
        """Largest distance of an edge from the midline."""
        return float(np.nanmax(np.abs(np.concatenate((self.left, self.right)))))

    @property
    def length(self) -> float:
        """Anteroposterior extent."""
        return float(np.ptp(self.y))


def _phase(reading: Reading, i: int) -> str:
    return f"{i}/{phases} T\n" if reading.cycles.count else ""


def _coronal(axes: Axes, reading: Reading, step: int, scale: Normalize) -> None:
    low, high = (1e3 * z for z in reading.height_range())
    shown = _shown(reading, step)
    right, left = (1e3 * points[step, shown] for points in reading.coronal)
    pressure = 1e-3 * reading.wave("section_pressure")[step, shown]
    reach = 0.42 * (high - low)
    quads = np.stack((left[:-1], right[:-1], right[1:], left[1:]), axis=1)
    bands = PolyCollection(
        list(quads), array=0.5 * (pressure[:-1] + pressure[1:]), cmap="viridis", norm=scale, lw=0.4, ec="face"
    )
    axes.add_collection(bands)
    far = 2 * float(max(np.abs(right).max(), np.abs(left).max(), reach))
    for points, edge in ((right, far), (left, -far)):
        outline = np.concatenate((points, [[edge, points[-1, 1]], [edge, points[0, 1]]]))
        axes.fill(outline[:, 0], outline[:, 1], color=tissue, lw=0)
        axes.plot(points[:, 0], points[:, 1], color=rim, lw=0.7)
    axes.set_xlim(-reach, reach)
    axes.set_ylim(low, high)


def _shown(reading: Reading, step: int) -> slice:
    """The coronal points of which one fold is within the heights shown, and one on either side of them."""
    low, high = reading.height_range()
    heights = [points[step, :, 1] for points in reading.coronal]
    within = np.flatnonzero(np.any([(z >= low) & (z <= high) for z in heights], axis=0))
    return slice(max(within[0] - 1, 0), within[-1] + 2) if within.size else slice(0, 2)


def _superior(axes: Axes, outline: Outline, reach: float) -> None:
    axes.set_facecolor(tissue)
    axes.fill_betweenx(outline.y, outline.left, outline.right, color=air, lw=0)
    axes.plot(outline.right, outline.y, color=rim, lw=0.6)
    axes.plot(outline.left, outline.y, color=rim, lw=0.6)
    axes.plot(outline.touching[:, 0], outline.touching[:, 1], "s", color=contact, ms=2.4, mew=0)
    axes.set_xlim(-reach, reach)
    axes.set_ylim(outline.y[0], outline.y[-1])


def _name_sides(axes: Axes) -> None:
    """Names the left and the right fold, on the tissue beside the glottis."""
    for x, name, side in ((0.03, "L", "left"), (0.97, "R", "right")):
        axes.text(x, 0.5, name, transform=axes.transAxes, ha=side, va="center", color=rim, fontsize=8)


def _name_ends(axes: Axes) -> None:
    """Names what is in front and at the back of the larynx, seen from above."""
    for y, name, side in ((0.985, "front", "top"), (0.015, "back", "bottom")):
        axes.text(0.03, y, name, transform=axes.transAxes, ha="left", va=side, color=rim, fontsize=7)


def _frame(axes: Axes, *, first: bool, name: str) -> None:
    axes.set_aspect("equal")
    for spine in axes.spines.values():
        spine.set_visible(True)
        spine.set_color(grey)
    if first:
        axes.set_ylabel(name)
    else:
        axes.set_yticklabels([])
