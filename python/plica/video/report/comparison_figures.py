"""The pictures of two analyses next to each other."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from plica.measures.scale import SI, shown_unit
from plica.report.drawing import Drawing, blue, draw, grey, red
from plica.video.analysis import Analysis
from plica.video.report.comparison import Comparison
from plica.video.report.pictures import cycle_poses, kymograms, mean_cycle, paint_pose, row_height

__all__ = ["sections"]

_POSES = 8  # pictures of a cycle
_SHOWN = 5  # cycles of a kymogram and of a phonovibrogram
_COLOURS = (blue, red)


def sections(both: Comparison) -> list[tuple[str, list[Drawing]]]:
    """Headings, each with its figures; of what needs cycles, nothing where one of the two has none."""
    if not all(found.cycles.count for _, found in both.both):
        return []
    drawings = [_mean_cycles(both), _kymograms(both), _cycles(both), _vibrograms(both)]
    return [("Side by side", drawings)]


def _size(both: Comparison, found: Analysis) -> tuple[float, str]:
    """What a pixel is shown as: mm where that is known of both, else a share of the glottal length."""
    if all(one.settings.mm_per_px for _, one in both.both):
        factor, unit = shown_unit(SI.unit("m"))
        return factor * found.pixel, unit
    return 1.0 / found.midline.length, "of the glottal length"


def _clock(both: Comparison, found: Analysis) -> tuple[float, str]:
    """What the unit of `Analysis.time` is shown as: ms where the frame rate is known of both, else cycles."""
    if all(one.settings.fps for _, one in both.both):
        factor, unit = shown_unit(SI.unit("s"))
        return factor, f"time ({unit})"
    return found.cycles.frequency, "cycles"


def _window(both: Comparison) -> float:
    """How long kymograms and phonovibrograms are, in the unit of `_clock`: alike in both."""
    cycles = [min(_SHOWN, found.cycles.count) for _, found in both.both]
    return min(
        count * _clock(both, found)[0] / found.cycles.frequency
        for count, (_, found) in zip(cycles, both.both, strict=True)
    )


def _mean_cycles(both: Comparison) -> Drawing:
    scaled = all(found.settings.mm_per_px for _, found in both.both)

    def paint(figure: Figure) -> None:
        panels = figure.subplots(1, 2 if scaled else 1, squeeze=False)[0]
        for (side, found), colour in zip(both.both, _COLOURS, strict=True):
            wave = mean_cycle(found)
            factor, _ = shown_unit("m^2")
            scales = [(1 / wave.mean.max(), "share of the largest"), (factor * found.pixel**2, "mm²")]
            for axes, (size, label) in zip(panels, scales, strict=False):
                low, high = size * (wave.mean - wave.spread), size * (wave.mean + wave.spread)
                axes.fill_between(wave.phase, low, high, color=colour, alpha=0.2, lw=0)
                axes.plot(wave.phase, size * wave.mean, color=colour, label=side)
                axes.set_ylabel(f"glottal area ({label})")
        for axes in panels:
            axes.set_xlabel("share of the cycle")
            axes.margins(x=0)
            axes.set_ylim(bottom=0)
        panels[0].legend(loc="upper right")

    caption = (
        "Glottal area over a cycle, from mark to mark: mean of all cycles, band of their standard deviation. "
        + (
            "Left in shares of the largest mean, right in mm²."
            if scaled
            else "In shares of the largest mean."
        )
    )
    return draw("mean cycle", caption, "Glottal area over a cycle, before and after", (9, 3.0), paint)


def _kymograms(both: Comparison) -> Drawing:
    chosen, window = [], _window(both)
    for _, found in both.both:
        lines = kymograms(found)
        chosen.append(min(lines, key=lambda line: abs(line.place - 0.5)))
    half = max(line.half * _size(both, found)[0] for line, (_, found) in zip(chosen, both.both, strict=True))

    def paint(figure: Figure) -> None:
        panels = figure.subplots(2, 1, sharex=True, sharey=True)
        for axes, line, (side, found) in zip(panels, chosen, both.both, strict=True):
            (size, unit), (factor, name) = _size(both, found), _clock(both, found)
            time = factor * (found.time - found.cycles.starts[0])
            line.paint(axes, time, size, unit, mirrored=both.mirrored(found))
            axes.set_xlim(0, window)
            axes.set_ylim(half, -half)
            axes.set_title(side, loc="left")
        panels[-1].set_xlabel(name)

    def place(line: float, found: Analysis) -> str:
        along = 1 - line if both.upturned(found) else line
        end = "anterior" if both.ends_known else "upper"
        return f"at {along:g} of the midline from its {end} end"

    places = [place(line.place, found) for line, (_, found) in zip(chosen, both.both, strict=True)]
    where = places[0] if places[0] == places[1] else f"before {places[0]}, after {places[1]}"
    up = "the patient's left" if both.sides_known else "the image's left"
    caption = (
        f"Kymograms {where}, from the first mark on; {up} is up. Orange: the folds' edges, from the masks."
    )
    return draw("kymograms", caption, "Kymograms, before and after", (9, 4.4), paint)


def _cycles(both: Comparison) -> Drawing:
    instants = np.arange(_POSES) / _POSES
    poses = [cycle_poses(found, instants) for _, found in both.both]

    def paint(figure: Figure) -> None:
        columns = max(map(len, poses))
        rows = figure.subplots(2, columns, squeeze=False)
        for panels, row, (side, found) in zip(rows, poses, both.both, strict=True):
            period = 1 / found.cycles.frequency
            for axes in panels[len(row) :]:
                axes.set_axis_off()
            for axes, pose in zip(panels, row, strict=False):
                paint_pose(axes, pose)
                axes.set_title(f"{pose.passed / period:.2f}", fontsize=7.5)
            panels[0].set_ylabel(side)

    caption = (
        "A cycle in pictures, the middle one of each recording, from its mark on; above each picture the "
        "share of the cycle. Orange: outline of the glottis. As in the image, neither turned nor to one "
        "scale."
    )
    height = sum(row_height(row, 8.7) for row in poses)
    return draw("cycles", caption, "Pictures of a cycle, before and after", (9, height), paint)


def _vibrograms(both: Comparison) -> Drawing:
    window, shown = _window(both), []
    for _, found in both.both:
        size, unit = _size(both, found)
        ways = size * found.vibrogram
        ways = ways[::-1] if both.mirrored(found) else ways
        ways = ways[:, ::-1] if both.upturned(found) else ways
        shown.append(np.concatenate([ways[0, ::-1], ways[1]]))  # both first ends in the middle
    largest = max(float(np.nanmax(picture)) for picture in shown)

    def paint(figure: Figure) -> None:
        panels = figure.subplots(1, 2, sharey=True)
        for axes, picture, (side, found) in zip(panels, shown, both.both, strict=True):
            factor, name = _clock(both, found)
            time = factor * (found.time - found.cycles.starts[0])
            extent = (float(time[0]), float(time[-1]), 1, -1)
            image = axes.imshow(picture, cmap="inferno", aspect="auto", extent=extent, vmin=0, vmax=largest)
            axes.axhline(0, color=grey, lw=0.6)
            axes.set_xlim(0, window)
            axes.set_title(side, loc="left")
            axes.set_xlabel(name)
        left, right = ("patient's left", "patient's right") if both.sides_known else ("image's left", "right")
        panels[0].set_yticks([-0.5, 0.5], [left, right], rotation=90, va="center", fontsize=7)
        figure.colorbar(image, ax=panels, label=f"edge from the midline ({unit})")

    end = "anterior" if both.ends_known else "upper"
    caption = (
        "Phonovibrograms: distance of the folds' edges from the midline, along it and over time, on one "
        f"scale of colours; both folds with the midline's {end} end in the middle."
    )
    return draw("vibrograms", caption, "Phonovibrograms, before and after", (9, 3.2), paint)
