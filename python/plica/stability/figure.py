"""Growth and frequency of small oscillations over the subglottal pressure, as a picture."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from plica.report.drawing import blue, draw, green, grey, purple, red
from plica.stability.offset import Offset
from plica.stability.onset import Onset

__all__ = ["growth_picture"]

_COLOURS = (blue, red, green, purple, grey, "#c2a03a")


def growth_picture(found: Onset, lowered: Offset | None = None) -> str:
    """Self-contained SVG; with the falls of an offset below."""
    first = found.first
    alt = "Growth and frequency of small oscillations over the subglottal pressure"
    if first is not None:
        alt += f"; onset at {first.pressure:.4g} Pa, {first.frequency:.4g} Hz"
    falls = lowered is not None and lowered.falls
    if lowered is not None and lowered.pressure is not None:
        alt += f"; offset at {lowered.pressure:.4g} Pa"
    size = (6.4, 7.0 if falls else 5.0)
    return draw("Growth", "", alt, size, lambda figure: _paint(figure, found, lowered)).svg + "\n"


def _paint(figure: Figure, found: Onset, lowered: Offset | None) -> None:
    if lowered is not None and lowered.falls:
        upper, lower, last = figure.subplots(3, 1, sharex=True)
        _paint_falls(last, lowered)
    else:
        upper, lower = figure.subplots(2, 1, sharex=True)
        last = lower
    kPa = 1e-3 * found.pressure
    for k, pair in enumerate(found.pairs.T):
        upper.plot(kPa, pair.real, color=_COLOURS[k % len(_COLOURS)])
        lower.plot(kPa, pair.imag / (2 * np.pi), color=_COLOURS[k % len(_COLOURS)])
    upper.axhline(0, color=grey, linewidth=0.7)
    largest = float(found.least_stable.real.max(initial=0.0))
    lowest = float(np.nanmin(found.pairs.real, initial=0.0))
    upper.set_ylim(max(lowest, -6 * max(largest, 50.0)), 1.15 * max(largest, 10.0))
    for one in found.crossings:
        upper.plot(1e-3 * one.pressure, 0, "o", color=red, markersize=5)
        lower.plot(1e-3 * one.pressure, one.frequency, "o", color=red, markersize=5)
        text = f" {one.pressure:.4g} Pa, {one.frequency:.4g} Hz"
        upper.annotate(text, (1e-3 * one.pressure, 0), xytext=(2, 5), textcoords="offset points")
    upper.set_ylabel("growth (1/s)")
    lower.set_ylabel("frequency (Hz)")
    last.set_xlabel("subglottal pressure (kPa)")
    last.margins(x=0)


def _paint_falls(axes: Axes, lowered: Offset) -> None:
    for fall, colour in zip(lowered.falls, (grey, blue), strict=True):
        label = f"falls by {fall.rate:.3g} Pa/s"
        axes.semilogy(1e-3 * fall.pressures, 1e6 * fall.amplitudes, color=colour, label=label)
    if lowered.pressure is not None:
        axes.axvline(1e-3 * lowered.pressure, color=red, linewidth=1.0)
        text = f" offset, {lowered.pressure:.4g} Pa"
        axes.annotate(text, (1e-3 * lowered.pressure, 0.02), xycoords=("data", "axes fraction"))
    axes.set_ylabel("amplitude of area (mm$^2$)")
    axes.legend(loc="lower right")
