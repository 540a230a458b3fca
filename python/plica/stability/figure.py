"""Growth and frequency of small oscillations over the subglottal pressure, as a picture."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from plica.report.drawing import blue, draw, green, grey, purple, red
from plica.stability.onset import Onset

__all__ = ["growth_picture"]

_COLOURS = (blue, red, green, purple, grey, "#c2a03a")


def growth_picture(found: Onset) -> str:
    """Self-contained SVG."""
    first = found.first
    alt = "Growth and frequency of small oscillations over the subglottal pressure"
    if first is not None:
        alt += f"; onset at {first.pressure:.4g} Pa, {first.frequency:.4g} Hz"
    return draw("Growth", "", alt, (6.4, 5.0), lambda figure: _paint(figure, found)).svg + "\n"


def _paint(figure: Figure, found: Onset) -> None:
    upper, lower = figure.subplots(2, 1, sharex=True)
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
    lower.set_xlabel("subglottal pressure (kPa)")
    lower.margins(x=0)
