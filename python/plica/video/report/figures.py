"""The figures of a recording's report."""

from __future__ import annotations

from typing import Any

import matplotlib as mpl
import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from plica.measures.scale import shown_unit
from plica.measures.thresholds import closed_share
from plica.measures.waveforms import RECORDED
from plica.report.drawing import Drawing, blue, draw, green, grey, label_ends, line, purple, red
from plica.report.wording import axis
from plica.video.analysis import Analysis
from plica.video.measures.waveforms import wide_share
from plica.video.motion.trajectories import spacing
from plica.video.report.pictures import cycle_poses, kymograms, paint_pose, row_height
from plica.video.report.signal_figures import signal_drawings
from plica.video.report.wave_figures import folds_box, over_tissue, wave_drawings

__all__ = ["lead", "sections"]

_SHADES = {"closed": "#40434a", "opening": "#8fb8dc", "open": "#3b82c4", "closing": "#e0a98f"}
_MOST_PATHS = 4000
_PANELS = 10  # pictures of a cycle
_TRAVELS, _CHANCE = 0.8, 0.5  # of modes: one motion that travels from there on; below, not in both halves


def lead(found: Analysis) -> list[Drawing]:
    """The figures that stand with the summary."""
    return [_kymograms(found), _area(found)]


def sections(found: Analysis) -> list[tuple[str, list[Drawing]]]:
    """Headings, each with its further figures; of the flow where it was found."""
    glottis = [("Waveforms", [*_cycle(found), _vibrogram(found), _spectrum(found)])]
    if drawings := signal_drawings(found):
        glottis.append(("Sound and electroglottogram", drawings))
    if not found.complete:
        return glottis
    drawings = [_modes(found), _coefficients(found)]
    if found.paths.places.shape[1]:
        drawings.append(_paths(found))
    motion = ("Motion of the tissue", [*drawings, *wave_drawings(found)])
    return [*glottis, motion, ("Trust", [_trust(found), _confidence(found)])]


def _end(found: Analysis, name: str) -> str:
    """ "upper" or "lower" end, and which it is where that is known."""
    anterior = found.settings.anterior
    if anterior is None:
        return f"{name} end"
    return f"{name} end ({'anterior' if name == anterior else 'posterior'})"


def _axis(found: Analysis, label: str, name: str) -> tuple[float, str]:
    """Factor and label of an axis on which people read that waveform."""
    return axis(label, RECORDED[name], found.scale)


def _time(found: Analysis) -> tuple[npt.NDArray[np.float64], str]:
    factor, name = _axis(found, "time", "time")
    return factor * found.time, name


def _length(found: Analysis) -> tuple[float, str]:
    """What people read a pixel as, and in which unit."""
    factor, unit = shown_unit(found.scale.unit("m"))
    return factor * found.pixel, unit


def _area(found: Analysis) -> Drawing:
    time, name = _time(found)
    waves = found.waveforms
    factor, label = _axis(found, "glottal area", "area_total")
    known = [(f"area_{name}", found.side(name), colour) for name, colour in (("left", blue), ("right", red))]

    def paint(figure: Figure) -> None:
        axes, strip = figure.subplots(2, 1, sharex=True, height_ratios=(12, 1))
        band = factor * waves["area_least"], factor * waves["area_largest"]
        axes.fill_between(time, *band, color=grey, alpha=0.35, lw=0)
        line(axes, time, factor * waves["area_total"], color=grey)
        for key, _, colour in known:
            line(axes, time, factor * waves[key], color=colour)
        axes.set_ylabel(label)
        axes.margins(x=0)
        label_ends(axes, [("total", grey), *((side, colour) for _, side, colour in known)])
        _phases(strip, found, time)
        strip.set_xlabel(name)

    caption = (
        "Glottal area, left and right of the midline. Band: the total, had the outline been drawn at "
        "0.15 or at 0.7 of the way from the dark of the glottis to the tissue instead of a half. Below, the "
        f"phases: closed (dark; up to {100 * closed_share:g} % of the cycle's largest area), opening (light "
        f"blue), open (blue; from {100 * wide_share:g} %), closing (light red)."
    )
    return draw("area", caption, "Glottal area over time", (9, 3.3), paint)


def _phases(axes: Axes, found: Analysis, time: npt.NDArray[np.float64]) -> None:
    step = time[1] - time[0]
    for name, colour in _SHADES.items():
        spans = [(time[k] - 0.5 * step, step) for k, phase in enumerate(found.phase) if phase == name]
        axes.broken_barh(spans, (0, 1), color=colour, lw=0)
    axes.set_yticks([])
    axes.set_ylim(0, 1)


def _kymograms(found: Analysis) -> Drawing:
    lines = kymograms(found)
    size, unit = _length(found)
    time, name = _time(found)

    def paint(figure: Figure) -> None:
        panels = figure.subplots(len(lines), 1, sharex=True, squeeze=False)[:, 0]
        for axes, line_ in zip(panels, lines, strict=True):
            line_.paint(axes, time, size, unit)
            axes.set_ylabel(f"{line_.place:g}\nacross ({unit})")
        axes.set_xlabel(name)
        axes.set_xlim(time[0], time[-1])

    caption = (
        f"Kymograms: lines across the midline at shares of its length from its {_end(found, 'upper')} to its "
        f"{_end(found, 'lower')}, frame by frame; the image's left is up. Orange: the folds' edges, from the "
        "masks."
    )
    return draw("kymograms", caption, "Kymograms", (9, 0.6 + 1.7 * len(lines)), paint)


def _cycle(found: Analysis) -> list[Drawing]:
    """One cycle in pictures, the middle one; none without cycles."""
    cycles = found.cycles
    if not cycles.count:
        return []
    poses = cycle_poses(found, np.linspace(0, 1, _PANELS, endpoint=False))
    factor, unit = _axis(found, "", "time")

    def paint(figure: Figure) -> None:
        for axes, pose in zip(figure.subplots(1, len(poses), squeeze=False)[0], poses, strict=True):
            paint_pose(axes, pose)
            axes.set_title(f"{factor * pose.passed:.3g}", fontsize=7.5)

    caption = (
        f"Cycle {cycles.count // 2 + 1} of {cycles.count}, from its mark on; above each picture the time "
        f"since then{unit}. Orange: outline of the glottis."
    )
    return [draw("cycle", caption, "Pictures of one cycle", (9, row_height(poses, 9)), paint)]


def _vibrogram(found: Analysis) -> Drawing:
    left, right = found.vibrogram
    size, unit = _length(found)
    time, name = _time(found)
    anterior = found.settings.anterior

    def paint(figure: Figure) -> None:
        axes = figure.subplots()
        both = size * np.concatenate([left[::-1], right])  # the upper ends meet in the middle
        largest = max(float(np.nanmax(both)), 1e-12)
        shown = axes.imshow(
            both,
            cmap="inferno",
            aspect="auto",
            extent=(float(time[0]), float(time[-1]), 1, -1),
            vmin=0,
            vmax=largest,
        )
        axes.axhline(0, color=grey, lw=0.6)
        axes.set_yticks(
            [-0.5, 0.5],
            [found.side(name).replace(" (", "\n(") for name in ("left", "right")],
            rotation=90,
            va="center",
            fontsize=7,
        )
        axes.set_xlabel(name)
        figure.colorbar(shown, ax=axes, label=f"edge from the midline ({unit})")

    end = "anterior" if anterior == "upper" else "posterior" if anterior == "lower" else "upper"
    caption = (
        "Phonovibrogram: distance of the folds' edges from the midline, along it and over time; the image's "
        f"left fold above, its right one below, both with the midline's {end} end in the middle."
    )
    return draw("vibrogram", caption, "Phonovibrogram", (9, 3.0), paint)


def _spectrum(found: Analysis) -> Drawing:
    total = found.area.filled().total
    window = np.hanning(total.size)
    power = np.abs(np.fft.rfft((total - total.mean()) * window)) ** 2
    step = found.time[1] - found.time[0]
    frequency = np.fft.rfftfreq(total.size, step)
    level = 10 * np.log10(np.maximum(power[1:], 1e-12 * max(power.max(), 1e-300)) / max(power.max(), 1e-300))
    unit = found.scale.unit("Hz")

    def paint(figure: Figure) -> None:
        axes = figure.subplots()
        line(axes, frequency[1:], level, color=blue)
        if found.cycles.count:
            axes.axvline(found.cycles.frequency, color=red, lw=0.8)
        axes.set_xlabel(f"frequency ({unit})")
        axes.set_ylabel("power (dB)")
        axes.set_ylim(-90, 3)
        axes.margins(x=0)

    caption = (
        "Spectrum of the glottal area (Hann window, dB below its largest line); red: the cycles' frequency. "
        "Lines between its multiples are those of a diplophonic voice, a raised floor is "
        "irregularity and noise."
    )
    return draw("spectrum", caption, "Spectrum of the glottal area", (9, 2.4), paint)


def coloured(pattern: npt.NDArray[np.floating]) -> npt.NDArray[np.floating]:
    """(h, w, 3) of (h, w, 2): colour for the direction, brightness for the size."""
    from matplotlib.colors import hsv_to_rgb

    size = np.hypot(pattern[..., 0], pattern[..., 1])
    angle = np.arctan2(pattern[..., 1], pattern[..., 0]) / (2 * np.pi) % 1.0
    strength = np.clip(size / max(float(np.percentile(size, 99.5)), 1e-12), 0, 1)
    return np.asarray(hsv_to_rgb(np.stack([angle, np.ones_like(angle), strength], axis=-1)))


def _modes(found: Analysis) -> Drawing:
    patterns, share, used = found.modes.patterns[:3], found.modes.share, found.modes.mask
    symmetry, box = found["modes/symmetry"], folds_box(found)
    tissue = over_tissue(found).mean(axis=-1, keepdims=True) / 255

    def paint(figure: Figure) -> None:
        panels = figure.subplots(1, len(patterns) + 1, width_ratios=[1] * len(patterns) + [0.22])
        for k, (axes, pattern) in enumerate(zip(panels, patterns, strict=False)):
            picture = coloured(pattern)
            strength = picture.max(axis=-1, keepdims=True)
            laid = 0.8 * picture + (1 - 0.8 * strength) * tissue
            axes.imshow(np.clip(np.where(used[..., None], laid, 0.6 * tissue), 0, 1)[box])
            axes.set_title(
                f"mode {k + 1}: {100 * share[k]:.1f} %, symmetry {symmetry[k]:+.2f},\n"
                f"in both halves {_share(found.modes.repeated[k])}"
            )
        y, x = np.mgrid[-1:1:61j, -1:1:61j]
        wheel = coloured(np.stack([x, y], axis=-1))
        panels[-1].imshow(np.where((np.hypot(x, y) <= 1)[..., None], wheel, 1.0))
        panels[-1].set_title("direction", fontsize=8)
        for axes in panels:
            axes.set_axis_off()

    caption = (
        "Principal modes of the tissue's motion, laid over the frame of least area: colour is the direction, "
        "its strength the size; what is darkened does not count. Share of the variance; likeness to the "
        "mirror image in the midline: +1 symmetric, -1 in opposite phase; how far the mode of the first half "
        f"of the frames is one of the second: 1 of a motion, near 0 of errors. {_of_modes(found)}"
    )
    return draw("modes", caption, "Principal modes of the motion", (9, 3.6), paint)


def _share(value: float) -> str:
    return f"{value:.2f}" if np.isfinite(value) else "not known"


def _of_modes(found: Analysis) -> str:
    """Which modes are one that travels, and which are not in both halves of the frames."""
    modes, said = found.modes, []
    travels = [k for k in range(min(len(modes.share) - 1, 3)) if modes.travelling[k] > _TRAVELS]
    for k in travels:
        if k - 1 not in travels:
            both = 100 * float(modes.share[k] + modes.share[k + 1])
            said.append(
                f"Modes {k + 1} and {k + 2} are one motion that travels, with {both:.1f} %; alone they mean "
                "nothing."
            )
    errors = [str(k + 1) for k in range(min(len(modes.share), 3)) if modes.repeated[k] < _CHANCE]
    if errors:
        which, are = ("Mode", "is") if len(errors) == 1 else ("Modes", "are")
        said.append(f"{which} {', '.join(errors)} {are} not in both halves: take no meaning from that.")
    return " ".join(said)


def _coefficients(found: Analysis) -> Drawing:
    values, error = found.waveforms["mode_coefficients"], found.waveforms["mode_round_trip"]
    time, name = _time(found)

    def paint(figure: Figure) -> None:
        axes = figure.subplots()
        chosen = list(zip(range(min(3, values.shape[1])), (blue, red, green), strict=False))
        for k, colour in chosen:
            low, high = values[:, k] - error[:, k], values[:, k] + error[:, k]
            axes.fill_between(time, low, high, color=colour, alpha=0.25, lw=0)
            line(axes, time, values[:, k], color=colour)
        axes.set_xlabel(name)
        axes.set_ylabel("coefficient (px)")
        axes.margins(x=0)
        label_ends(axes, [(f"mode {k + 1}", colour) for k, colour in chosen])

    caption = (
        "Coefficients of the modes over time, px summed in squares over all pixels that count; positive: "
        "the folds part. Band: what going to the next frame and back misses in this mode, over the root of"
        " two and in the mean over nine pairs; a lower bound of the error, as what both ways have in "
        "common cancels."
    )
    return draw("coefficients", caption, "Mode coefficients over time", (9, 2.6), paint)


def _paths(found: Analysis) -> Drawing:
    places, closing = found.paths.places, found["paths/closing"]
    cycles = found.cycles
    size, unit = _length(found)
    begin, end = (0, found.count) if not cycles.count else np.searchsorted(found.time, cycles.starts[:2])
    end = min(int(end) + 1, found.count)
    frame = found.frames().pictures({int(begin)})[int(begin)]
    way = places[begin:end] - places[begin]
    largest = float(np.nanpercentile(np.linalg.norm(way, axis=-1).max(axis=0), 99))
    times = max(1, int(0.8 * spacing / max(largest, 1e-9)))
    drawn = places[begin] + times * way

    def paint(figure: Figure) -> None:
        from matplotlib.collections import LineCollection

        axes = figure.subplots()
        axes.imshow(frame, alpha=0.75)
        chosen = np.flatnonzero(np.isfinite(drawn).all(axis=(0, 2)))[:_MOST_PATHS]
        drawings = list(drawn[:, chosen].swapaxes(0, 1))
        colours = mpl.colormaps["plasma"].with_extremes(bad=grey)
        lines = LineCollection(drawings, cmap=colours, linewidths=1.0)
        known = np.isfinite(closing[chosen])
        lines.set_array(np.ma.masked_invalid(size * closing[chosen]))
        if known.any():
            lines.set_clim(0, max(float(np.percentile(size * closing[chosen][known], 95)), 1e-9))
            figure.colorbar(lines, ax=axes, label=f"closing error ({unit})")
        axes.add_collection(lines)
        rows, columns = folds_box(found)
        axes.set_xlim(columns.start - 0.5, columns.stop - 0.5)
        axes.set_ylim(rows.stop - 0.5, rows.start - 0.5)
        axes.set_axis_off()

    told = closing[np.isfinite(closing)]
    missed = (
        f"; half of the points miss by less than {size * float(np.median(told)):.2g} {unit}"
        if told.size
        else ""
    )
    span = "a cycle" if cycles.count else "the recording"
    scale = f"{times} times as large" if times > 1 else "as they are"
    caption = (
        f"Paths of points of the tissue over {span}, drawn {scale}. Colour: how far a point"
        f" is from where it was a period before, the median over the cycles{missed}."
    )
    return draw("paths", caption, "Paths of points over a cycle", (9, 5.6), paint)


def _trust(found: Analysis) -> Drawing:
    waves = found.waveforms
    time, name = _time(found)

    def paint(figure: Figure) -> None:
        upper, lower, lowest = figure.subplots(3, 1, sharex=True)
        line(upper, time, waves["residual"], color=purple)
        line(upper, time, waves["warp_error"], color=grey)
        line(lower, time, waves["mismatch"], color=green)
        upper.set_ylabel("grey levels")
        upper.set_ylim(bottom=0)
        lower.set_ylabel("mismatch (px)")
        lower.set_ylim(bottom=0)
        line(lowest, time, 100 * waves["brightness"], color=blue)
        lowest.set_ylabel("light (%)")
        lowest.set_xlabel(name)
        upper.margins(x=0)
        label_ends(upper, [("residual", purple), ("warp error", grey)])

    caption = (
        "Residual: root mean square of what is left of the brightness difference after the motion, on "
        "tissue. Warp error: the measure of Granados (2016), over the whole frame; it rewards smooth flow "
        "and is given for comparison. Mismatch: on the folds, median distance from the start after going "
        "to the next frame and back, a lower bound of the error. Light: by how much it makes the next frame "
        "brighter; the flow takes that out."
    )
    return draw("trust", caption, "Residual, warp error, mismatch and light over time", (9, 4.4), paint)


def _confidence(found: Analysis) -> Drawing:
    values: Any = found["trust/confidence"]

    def paint(figure: Figure) -> None:
        axes = figure.subplots()
        shown = axes.imshow(values, cmap="viridis", vmin=0, vmax=1)
        figure.colorbar(shown, ax=axes, label="confidence")
        axes.set_axis_off()

    caption = (
        "Confidence: in how many of the pairs of frames a pixel shows tissue, and going to the "
        "next and back misses it by less than half a pixel."
    )
    return draw("confidence", caption, "Confidence of each pixel", (9, 4.6), paint)
