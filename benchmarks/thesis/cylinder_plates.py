"""Paper A, Figs. 6 and 7: two elastic cylinders."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from benchmarks.thesis import cylinders
from benchmarks.thesis.cylinders import MIDDLES, Impact
from benchmarks.thesis.plate import Plate
from benchmarks.thesis.reading import Shelf
from plica.report.drawing import blue, green, grey, red

AVERAGED = 0.3e-3  # s; the flat faces bounce at first


def impacts(shelf: Shelf) -> list[Impact]:
    return [cylinders.stored(across, step, shelf.runs) for across, step in cylinders.LEVELS]


def smoothed(impact: Impact, force: np.ndarray) -> np.ndarray:
    """Mean over AVERAGED about each step."""
    count = max(round(AVERAGED / impact.step), 1)
    return np.convolve(force, np.ones(count) / count, "same")


def shapes(shelf: Shelf) -> Plate:
    shown = impacts(shelf)[-1]
    lines = [outline(points) for points in shown.outlines]

    def paint(figure: Figure) -> None:
        for axes, time, both in zip(figure.subplots(1, 2), MIDDLES, lines, strict=True):
            for points in both:
                axes.fill(points[:, 0], points[:, 1], fc="0.9", ec="0.2", lw=0.8)
            axes.set(title=f"{1e3 * time:.1f} ms", xlabel="x (m)", ylabel="y (m)")
            axes.set_aspect("equal")

    return Plate(
        "fig06",
        "Figure 6: two colliding cylinders",
        "Geometry and shapes at 1.1 and 3 ms.",
        "Density, radius, length and position are not given ([what was chosen](verification/cylinders.md)): "
        f"end to end along x, length {cylinders.LENGTH:g} m.",
        ["time (ms)", "cylinder", "x (m)", "y (m)"],
        [
            [1e3 * time, k, *point]
            for time, both in zip(MIDDLES, lines, strict=True)
            for k, points in enumerate(both)
            for point in points
        ],
        (6.4, 2.4),
        paint,
    )


def outline(points: np.ndarray) -> list[np.ndarray]:
    """Surface points at z = 0 of both cylinders, each in the order of the angle about its middle."""
    found = []
    half = len(points) // 2
    for part in (points[:half], points[half:]):
        centre = part.mean(axis=0)
        found.append(part[np.argsort(np.arctan2(part[:, 1] - centre[1], part[:, 0] - centre[0]))])
    return found


def forces(shelf: Shelf) -> Plate:
    found = impacts(shelf)
    bar = np.pi * cylinders.RADIUS**2 * cylinders.bar_pressure()

    def paint(figure: Figure) -> None:
        both, levels = figure.subplots(1, 2, sharey=True)
        last = found[-1]
        both.plot(1e3 * last.time, 1e-6 * smoothed(last, last.left), color=blue, label="on the left one")
        both.plot(
            1e3 * last.time, 1e-6 * smoothed(last, last.right), ":", color=red, label="on the right one"
        )
        for impact, colour in zip(found, (green, red, blue), strict=True):
            label = f"{impact.across} across, {1e6 * impact.step:g} µs"
            levels.plot(
                1e3 * impact.time, 1e-6 * smoothed(impact, impact.right), color=colour, lw=0.8, label=label
            )
        for axes in (both, levels):
            axes.axhline(1e-6 * bar, color=grey, lw=0.6)
            axes.set_xlabel("time (ms)")
            axes.legend(loc="upper right", fontsize=7)
        both.set_ylabel("force, mean of 0.3 ms (MN)")

    last = found[-1]
    apart = float(np.abs(last.left - last.right).max() / last.right.max())
    durations = ", ".join(f"{1e3 * impact.duration:.2f}" for impact in found)
    impulses = ", ".join(f"{impact.impulse / cylinders.momentum():.3f}" for impact in found)
    least, largest = extremes(last)
    text = (
        f"Both forces are equal to {apart:.0e} of the largest. On the three meshes of the "
        f"picture the contact lasts {durations} ms (bars: "
        f"{1e3 * cylinders.bar_duration():.2f} ms), and the impulse is {impulses} of twice the momentum. "
        f"The force is least at {least:.1f} ms and then largest at {largest:.1f} ms; the thesis has its "
        "extremes at 1.1 and 3 ms."
    )
    return Plate(
        "fig07",
        "Figure 7: total contact force on each cylinder",
        "Equal forces on both (action and reaction), within 2.8 to 6 % of ANSYS at the extremes.",
        text,
        [
            "across",
            "step (us)",
            "time (ms)",
            "force on the left (MN)",
            "force on the right (MN)",
            "mean of 0.3 ms (MN)",
        ],
        [
            [impact.across, 1e6 * impact.step, 1e3 * t, 1e-6 * a, 1e-6 * b, 1e-6 * c]
            for impact in found
            for t, a, b, c in zip(
                impact.time, impact.left, impact.right, smoothed(impact, impact.right), strict=True
            )
        ],
        (7.4, 2.6),
        paint,
    )


def extremes(impact: Impact) -> tuple[float, float]:
    """ms of the least force after the first bounces, in the first half, and of the largest in the second."""
    force, touching = smoothed(impact, impact.right), impact.time[impact.right > 0]
    start, middle = touching[0] + 2 * AVERAGED, 0.5 * (touching[0] + touching[-1])
    early = np.where((impact.time > start) & (impact.time <= middle), force, np.inf)
    late = np.where(impact.time > middle, force, 0.0)
    return 1e3 * float(impact.time[np.argmin(early)]), 1e3 * float(impact.time[np.argmax(late)])
