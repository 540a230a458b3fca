"""The figures of the sound and the electroglottogram beside the glottal area, on one time axis."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from plica.measures.electroglottogram import contact_of
from plica.measures.scale import shown_unit
from plica.measures.waveforms import RECORDED
from plica.report.drawing import Drawing, blue, draw, green, grey, line, purple, red
from plica.report.wording import axis
from plica.video.analysis import Analysis
from plica.video.files.signal_file import Signal
from plica.video.measures.signal_measures import closing_instants
from plica.video.measures.waveforms import counted

__all__ = ["signal_drawings"]

Floats = npt.NDArray[np.float64]
Span = tuple[float, float]

_SHOWN = 5  # cycles of the figure in detail
_SHOWN_AS = shown_unit("s")[0]  # of a second on the axes
_NAMES = {"audio": "sound", "egg": "EGG"}
_COLOURS = {"audio": blue, "egg": green}
_HIGH = 1.15  # inches a panel


@dataclass(frozen=True)
class _Panel:
    """A line over time (s), and how it is labelled."""

    label: str
    time: Floats
    values: Floats
    colour: str

    def paint(self, axes: Axes, span: Span) -> None:
        """What of it lies within a span (s), a sample more at either end."""
        low, high = (int(k) for k in np.searchsorted(self.time, span))
        part = slice(max(low - 1, 0), high + 1)
        line(axes, _SHOWN_AS * self.time[part], self.values[part], color=self.colour, lw=1.0)
        axes.set_ylabel(self.label)


def signal_drawings(found: Analysis) -> list[Drawing]:
    """A few cycles with the slope of the electroglottogram, and the whole recording; none without signals."""
    parts = found.signals.parts
    if not parts:
        return []
    whole = (0.0, found.count / (found.settings.fps or 1.0))
    panels = [
        _of_area(found),
        *(_Panel(_NAMES[name], part.time, part.values, _COLOURS[name]) for name, part in parts.items()),
    ]
    detail, marks, slope = panels, np.zeros(0), ""
    if "egg" in parts:
        detail, marks = (
            [*panels, _of_slope(parts["egg"])],
            closing_instants(found.time, _total(found), found.cycles),
        )
        slope = (
            " dEGG: slope of the electroglottogram, whose highest peak is where the folds meet, its lowest "
            "where they part; up is more contact. Red: instants at which the area closes, of the cycles."
        )
    called = " and ".join({"audio": "sound", "egg": "electroglottogram"}[name] for name in parts)
    caption = (
        f"Glottal area beside {called}, on the time of the frames. {'; '.join(found.signals.said)}. Nothing "
        "is moved: sound reaches a microphone (0.17 m + its distance from the mouth) / 350 m/s after it left "
        f"the glottis, about 1 ms.{slope}"
    )
    title = f"Glottal area beside {called}"
    few = partial(_paint, panels=detail, span=_few_cycles(found, whole), marks=marks)
    all_of_it = partial(_paint, panels=panels, span=whole, marks=np.zeros(0))
    return [
        draw("signals", caption, f"{title}, a few cycles", _size(detail), few),
        draw(
            "signals_whole", f"The same over the whole recording: {called}.", title, _size(panels), all_of_it
        ),
    ]


def _paint(figure: Figure, panels: list[_Panel], span: Span, marks: Floats) -> None:
    rows = figure.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0]
    for axes, panel in zip(rows, panels, strict=True):
        panel.paint(axes, span)
        for instant in marks[(marks >= span[0]) & (marks <= span[1])]:
            axes.axvline(_SHOWN_AS * instant, color=red, lw=0.7)
    rows[-1].set_xlim(_SHOWN_AS * span[0], _SHOWN_AS * span[1])
    rows[-1].set_xlabel(axis("time", RECORDED["time"])[1])
    figure.align_ylabels(list(rows))


def _size(panels: list[_Panel]) -> tuple[float, float]:
    return 9, 0.6 + _HIGH * len(panels)


def _total(found: Analysis) -> Floats:
    return counted(found.area).filled().total


def _few_cycles(found: Analysis, whole: Span) -> Span:
    """A span (s) of a few cycles in the middle of those that signals cover; the whole without cycles."""
    begin = max(part.begin for part in found.signals.parts.values())
    end = min(part.end for part in found.signals.parts.values())
    starts = found.cycles.starts
    inside = starts[(starts >= begin) & (starts <= end)]
    if inside.size < 2:
        return whole
    first = max((inside.size - 1 - _SHOWN) // 2, 0)
    return float(inside[first]), float(inside[min(first + _SHOWN, inside.size - 1)])


def _of_area(found: Analysis) -> _Panel:
    factor, label = axis("area", RECORDED["area_total"], found.scale)
    return _Panel(label, found.time, factor * found.pixel**2 * _total(found), grey)


def _of_slope(part: Signal) -> _Panel:
    return _Panel(
        "dEGG (1/s)", part.time, np.asarray(contact_of(part.time, part.values).slope, float), purple
    )
