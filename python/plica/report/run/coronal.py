"""The mid-coronal plane over time: kymogram, trajectories, pressure."""

from __future__ import annotations

import numpy as np

from plica.report.plot import Drawing, Plot, air, blue, grey, over_time, red, rim, tissue, viridis
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

    plot = Plot("Kymogram of the mid-plane", (9.2, 2.9))
    (panel,) = plot.column(1)
    ends, there_and_back = time[[0, -1]], np.concatenate((time, time[::-1]))
    panel.area(np.repeat(ends, 2), reach * np.array([-1, 1, 1, -1]), tissue)
    panel.area(there_and_back, np.concatenate((left, right[::-1])), air)
    panel.line(time, right, rim, 0.6)
    panel.line(time, left, rim, 0.6)
    panel.y_range = -reach, reach
    over_time((panel, "x (mm), left < 0 < right"))

    caption = (
        "As in videokymography: the mid-coronal line from above, each edge its most medial point. "
        "Dark: airway."
    )
    alt = "Kymogram: left and right fold edge over time, tissue in colour, the open glottis dark."
    return plot.drawing(caption, alt)


def trajectories(reading: Reading) -> Drawing:
    """Paths of the coronal points over the last two cycles."""
    part = reading.last_cycles(2)
    low, high = reading.height_range()
    height = np.asarray(reading.run.section_height, dtype=float)
    shown = (height >= low - 1e-9) & (height <= high + 1e-9)
    reach = 0.6e3 * (high - low)
    right, left = reading.coronal
    sides = ((1e3 * left, blue), (1e3 * right, red))

    plot = Plot("Trajectories in the coronal plane", (5.2, 4.6))
    (panel,) = plot.column(1)
    panel.with_equal_scales((-reach, reach), (1e3 * low - 0.1, 1e3 * high + 0.1))
    for points, colour in sides:
        for i in np.flatnonzero(shown):
            panel.line(points[part, i, 0], points[part, i, 1], colour, 1.1)
        start = points[0, shown]
        panel.line(start[:, 0], start[:, 1], grey, 0.7, dash="3 1.5")
        panel.squares(start[:, 0], start[:, 1], grey, 2.5)
    panel.x_label, panel.y_label = "from the midline (mm), left < 0 < right", "z (mm)"

    caption = (
        "Paths of the interface in the mid-coronal plane, last two cycles. Blue: left fold, red: right fold. "
        "Grey: first step."
    )
    alt = "Closed paths of points of both folds in the coronal plane."
    return plot.drawing(caption, alt)


def pressure_map(reading: Reading) -> Drawing:
    """Air pressure on the folds over height and time, with the height of separation."""
    part = reading.last_cycles(3)
    low, high = reading.height_range()
    height = np.asarray(reading.run.section_height, dtype=float)
    time = 1e3 * reading.time[part]
    pressure = 1e-3 * reading.wave("section_pressure")[part]
    stride = max(time.size // 600, 1)

    plot = Plot("Pressure in the glottis", (9.2, 2.9))
    (panel,) = plot.column(1, right=66.0)
    levels = np.linspace(low, high, 180)
    picture = np.array([np.interp(levels, height, values) for values in pressure[::stride]]).T
    largest = max(float(picture.max()), 1e-3)
    panel.picture(viridis(picture / largest), (float(time[0]), float(time[-1])), (1e3 * low, 1e3 * high))
    if reading.has("separation"):
        index = np.asarray(reading.waveforms["separation"])[part]
        valid = (index >= 0) & (index < height.size)
        edge = np.where(valid, 1e3 * height[np.clip(index, 0, height.size - 1)], np.nan)
        panel.steps(time, edge, "white")
    panel.x_range, panel.y_range = (float(time[0]), float(time[-1])), (1e3 * low, 1e3 * high)
    over_time((panel, "z (mm)"))
    plot.colour_bar(panel, largest, "pressure (kPa)")

    caption = (
        "Pressure of the air on the folds. White: where the jet separates; above it the pressure is zero."
    )
    alt = "Map of air pressure over height and time with the separation height as a white line."
    return plot.drawing(caption, alt)
