"""The mid-coronal plane over time: kymogram, trajectories, pressure."""

from __future__ import annotations

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

from plica.report.drawing import Drawing, air, blue, draw, grey, over_time, red, rim, tissue
from plica.report.run.reading import Reading


def kymogram(reading: Reading) -> Drawing:
    """Both fold edges at the mid-plane as seen from above, tissue and airway filled."""
    part = reading.last_cycles(6)
    time = 1e3 * reading.time[part]
    points = reading.coronal
    right = 1e3 * points[0][part, :, 0].min(axis=1)
    left = 1e3 * points[1][part, :, 0].max(axis=1)
    middle = 0.5 * (right + left)
    right, left = np.maximum(right, middle), np.minimum(left, middle)
    reach = 1.35 * float(max(np.abs(right).max(), np.abs(left).max(), 1e-3))

    def paint(figure: Figure) -> None:
        axes = figure.subplots()
        axes.fill_between(time, left, right, color=air, lw=0)
        axes.fill_between(time, right, reach, color=tissue, lw=0)
        axes.fill_between(time, -reach, left, color=tissue, lw=0)
        axes.plot(time, right, color=rim, lw=0.6)
        axes.plot(time, left, color=rim, lw=0.6)
        axes.set_ylim(-reach, reach)
        over_time((axes, "x (mm), left < 0 < right"))

    caption = (
        "As in videokymography: the mid-coronal line from above, each edge its most medial point. "
        "Dark: airway."
    )
    alt = "Kymogram: left and right fold edge over time, tissue in colour, the open glottis dark."
    return draw("Kymogram of the mid-plane", caption, alt, (9.2, 2.9), paint)


def trajectories(reading: Reading) -> Drawing:
    """Paths of the coronal points over the last two cycles."""
    part = reading.last_cycles(2)
    low, high = reading.height_range()
    height = np.asarray(reading.run.section_height, dtype=float)
    shown = (height >= low - 1e-9) & (height <= high + 1e-9)
    reach = 0.6e3 * (high - low)
    right, left = (1e3 * np.concatenate((points[:1], points[part]))[:, shown] for points in reading.coronal)
    sides = ((left, blue), (right, red))

    def paint(figure: Figure) -> None:
        axes = figure.subplots()
        for points, colour in sides:
            start, paths = points[0], np.swapaxes(points[1:], 0, 1)
            axes.add_collection(LineCollection(list(paths), colors=colour, linewidths=1.1))
            axes.plot(start[:, 0], start[:, 1], "o--", color=grey, ms=3, lw=0.7)
        axes.set_aspect("equal")
        axes.set_ylim(1e3 * low - 0.1, 1e3 * high + 0.1)
        axes.set_xlim(-reach, reach)
        axes.set_xlabel("from the midline (mm), left < 0 < right")
        axes.set_ylabel("z (mm)")

    caption = (
        "Paths of the interface in the mid-coronal plane, last two cycles. Blue: left fold, red: right fold. "
        "Grey: first step."
    )
    alt = "Closed paths of points of both folds in the coronal plane."
    return draw("Trajectories in the coronal plane", caption, alt, (5.2, 4.6), paint)


def pressure_map(reading: Reading) -> Drawing:
    """Air pressure on the folds over height and time, with the height of separation."""
    part = reading.last_cycles(3)
    low, high = reading.height_range()
    height = np.asarray(reading.run.section_height, dtype=float)
    time = 1e3 * reading.time[part]
    pressure = 1e-3 * reading.wave("section_pressure")[part]
    stride = max(time.size // 600, 1)

    def paint(figure: Figure) -> None:
        axes = figure.subplots()
        levels = np.linspace(low, high, 180)
        picture = np.array([np.interp(levels, height, values) for values in pressure[::stride]]).T
        extent = (float(time[0]), float(time[-1]), 1e3 * low, 1e3 * high)
        image = axes.imshow(picture, origin="lower", extent=extent, aspect="auto", cmap="viridis")
        if reading.has("separation"):
            index = np.asarray(reading.waveforms["separation"])[part]
            valid = (index >= 0) & (index < height.size)
            edge = np.where(valid, 1e3 * height[np.clip(index, 0, height.size - 1)], np.nan)
            axes.plot(time, edge, color="white", lw=1, drawstyle="steps-mid")
        axes.set_ylim(1e3 * low, 1e3 * high)
        axes.set_xlim(time[0], time[-1])
        over_time((axes, "z (mm)"))
        figure.colorbar(image, ax=axes, label="pressure (kPa)", pad=0.01)

    caption = (
        "Pressure of the air on the folds. White: where the jet separates; above it the pressure is zero."
    )
    alt = "Map of air pressure over height and time with the separation height as a white line."
    return draw("Pressure in the glottis", caption, alt, (9.2, 2.9), paint)
