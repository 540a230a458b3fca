"""Figures as inline SVG: text and axes take the page's colour, lines are legible on light and dark."""

from __future__ import annotations

import io
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure

from plica.measures.record import Floats
from plica.report.progress import count_figure
from plica.report.svg import shortened

blue, red, green, purple, grey = "#3b82c4", "#d2603a", "#3f9b6c", "#8d66bf", "#8b8f96"
tissue, air, rim = "#d8998a", "#1d222b", "#4a2f2a"
ink = "#010203"  # stands for the page's text colour; replaced by currentColor

style: dict[str, Any] = {
    "svg.fonttype": "none",
    "font.family": "sans-serif",
    "font.size": 9.5,
    "text.color": ink,
    "axes.edgecolor": ink,
    "axes.labelcolor": ink,
    "axes.linewidth": 0.7,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.titlesize": 9.5,
    "xtick.color": ink,
    "ytick.color": ink,
    "xtick.major.width": 0.7,
    "ytick.major.width": 0.7,
    "lines.linewidth": 1.4,
    "legend.frameon": False,
    "legend.fontsize": 9,
    "figure.facecolor": "none",
    "axes.facecolor": "none",
    "savefig.facecolor": "none",
    "savefig.dpi": 130,
}


@dataclass(frozen=True)
class Drawing:
    """A figure of the page."""

    title: str
    caption: str
    alt: str
    svg: str


def draw(
    title: str,
    caption: str,
    alt: str,
    size: tuple[float, float],
    paint: Callable[[Figure], None],
) -> Drawing:
    """Draw a figure of this size (inches) and return it as self-contained SVG."""
    settings: Any = {**style, "svg.hashsalt": title}
    with mpl.rc_context(settings):
        figure = Figure(figsize=size, layout="constrained")
        FigureCanvasSVG(figure)
        paint(figure)
        _laid_out(figure)
        buffer = io.StringIO()
        figure.savefig(buffer, format="svg", metadata={"Date": None})
    count_figure()
    return Drawing(title, caption, alt, inline_svg(buffer.getvalue(), alt))


def _laid_out(figure: Figure) -> None:
    """Lay it out once; savefig would do so twice, and draw it once more for that."""
    engine = figure.get_layout_engine()
    if engine is not None:
        engine.execute(figure)
        figure.set_layout_engine(None)


def inline_svg(text: str, alt: str) -> str:
    """The <svg> element without prolog, metadata and unused ids, scalable, labelled for screen readers."""
    text = text[text.index("<svg") :]
    text = re.sub(r"<metadata>.*?</metadata>\s*", "", text, flags=re.DOTALL)
    text = re.sub(r'(<svg[^>]*?) width="[^"]*"', r"\1", text, count=1)
    text = re.sub(r'(<svg[^>]*?) height="[^"]*"', r"\1", text, count=1)
    text = re.sub(r'(<svg[^>]*?) version="[^"]*"', r"\1", text, count=1)
    text = text.replace(ink, "currentColor")
    used = set(re.findall(r"#([\w-]+)", text))
    text = re.sub(r' id="([^"]*)"', lambda found: found.group(0) if found.group(1) in used else "", text)
    name = alt.replace("&", "and").replace('"', "'").replace("<", "under ").replace(">", "over ")
    return shortened(text).replace("<svg", f'<svg role="img" aria-label="{name}"', 1)


def over_time(*panels: tuple[Axes, str]) -> None:
    """Label each panel (axes, name), and the common time axis (ms) below the last one."""
    for axes, name in panels:
        axes.set_ylabel(name)
        axes.margins(x=0)
    panels[-1][0].set_xlabel("time (ms)")


def line(axes: Axes, time: Floats, values: Floats, **options: Any) -> None:
    """A line reduced to the minimum and maximum of at most 1000 intervals: a pixel each, or less."""
    most = 1000
    if time.size > 2 * most:
        edges = np.linspace(0, time.size, most + 1).astype(int)
        kept = []
        for a, b in pairwise(edges):
            low, high = a + int(np.argmin(values[a:b])), a + int(np.argmax(values[a:b]))
            kept += sorted({low, high})
        time, values = time[kept], values[kept]
    axes.plot(time, values, **options)


def label_ends(axes: Axes, entries: Sequence[tuple[str, str]]) -> None:
    """A legend of (name, colour) in one row above the axes."""
    for i, (name, colour) in enumerate(entries):
        axes.plot([], [], color=colour, label=name, zorder=-i)
    axes.legend(
        loc="lower left", bbox_to_anchor=(0, 1.0), ncols=len(entries), borderaxespad=0.2, handlelength=1.4
    )
