"""Figures as inline SVG without a plotting library: text and axes take the page's colour, lines are legible
on light and dark.

A `Plot` has panels, a `Panel` has marks in its own coordinates. Lengths on the page are in points, from the
top left; text is placed by its anchor, so that nothing depends on the width of a font.
"""

from __future__ import annotations

import base64
import struct
import zlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from html import escape
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from plica.measures.record import Floats
from plica.report.progress import count_figure
from plica.report.ticks import Ticks, linear_ticks, log_ticks

blue, red, green, purple, grey = "#3b82c4", "#d2603a", "#3f9b6c", "#8d66bf", "#8b8f96"
tissue, air, rim = "#d8998a", "#1d222b", "#4a2f2a"

_VIRIDIS = (
    "440154 471365 482475 463480 414487 3b528b 355f8d 2f6c8e 2a788e 25848e 21918c "
    "1e9c89 22a884 2fb47c 44bf70 5ec962 7ad151 9bd93c bddf26 dfe318 fde725"
)
_ANCHORS = np.array([list(bytes.fromhex(code)) for code in _VIRIDIS.split()], dtype=float)
_MOST = 1500  # intervals of a line
_LETTER = 0.56  # mean width of a letter over the size of its font


@dataclass(frozen=True)
class Drawing:
    """A figure of the page."""

    title: str
    caption: str
    alt: str
    svg: str


def viridis(share: Floats) -> NDArray[np.uint8]:
    """Colours (..., 3) of numbers in [0, 1], of the map viridis."""
    at = np.linspace(0.0, 1.0, len(_ANCHORS))
    mixed = [np.interp(share, at, channel) for channel in _ANCHORS.T]
    return np.asarray(np.rint(np.stack(mixed, axis=-1)), dtype=np.uint8)


def reduced(x: Floats, y: Floats) -> tuple[Floats, Floats]:
    """A line reduced to the minimum and maximum of at most 1500 intervals."""
    if x.size <= 2 * _MOST:
        return x, y
    edges = np.linspace(0, x.size, _MOST + 1).astype(int)
    kept = []
    for a, b in pairwise(edges):
        low, high = a + int(np.argmin(y[a:b])), a + int(np.argmax(y[a:b]))
        kept += sorted({low, high})
    return x[kept], y[kept]


@dataclass
class Panel:
    """A rectangle with axes: marks are drawn in the order of the calls, and cut off at its edges.

    Attributes
    ----------
    left, top, width, height : float
        pt.
    x_range, y_range : (low, high) or None
        What is shown; None: x of all lines, y of all lines and a twentieth more on each side.
    log : bool
        Whether y is shown by its logarithm.
    boxed : bool
        Axes on all sides instead of at the left and below.
    x_label, y_label, title : str
        The title in lines.
    x_named, y_named : bool
        Whether the ticks have numbers.
    legend : list of (label, colour)
        In a row above the panel.
    bands : list of (begin, end, colour, opacity)
        Ranges of x that are shaded, over all of the height.
    """

    left: float
    top: float
    width: float
    height: float
    x_range: tuple[float, float] | None = None
    y_range: tuple[float, float] | None = None
    log: bool = False
    boxed: bool = False
    x_label: str = ""
    y_label: str = ""
    title: str = ""
    x_named: bool = True
    y_named: bool = True
    legend: list[tuple[str, str]] = field(default_factory=list)
    bands: list[tuple[float, float, str, float]] = field(default_factory=list)
    _marks: list[Callable[[], str]] = field(default_factory=list)
    _lines: list[tuple[Floats, Floats]] = field(default_factory=list)

    def line(self, x: Floats, y: Floats, colour: str, width: float = 1.4, dash: str = "") -> None:
        """A line, broken where it is not finite."""
        x, y = reduced(np.asarray(x, dtype=float), np.asarray(y, dtype=float))
        dashed = f' stroke-dasharray="{dash}"' if dash else ""
        self._lines.append((x, y))
        self._marks.append(
            lambda: (
                f'<path d="{self._path(x, y)}" fill="none" stroke="{colour}" stroke-width="{width}"{dashed}/>'
            )
        )

    def steps(self, x: Floats, y: Floats, colour: str, width: float = 1.0) -> None:
        """A line that changes halfway between its points."""
        middle = 0.5 * (x[:-1] + x[1:])
        ends = np.concatenate((x[:1], np.repeat(middle, 2), x[-1:]))
        self.line(ends, np.repeat(y, 2), colour, width)

    def area(self, x: Floats, y: Floats, colour: str, seam: float = 0.0) -> None:
        """The polygon through these points; points that are not finite are left out. Neighbours with a seam
        (pt) leave no gap between them."""
        kept = np.isfinite(x) & np.isfinite(y)
        self._marks.append(
            lambda: (
                f'<path d="{self._path(x[kept], y[kept])}Z" fill="{colour}" '
                f'stroke="{colour}" stroke-width="{seam}"/>'
            )
        )

    def squares(self, x: Floats, y: Floats, colour: str, size: float) -> None:
        """A square of this size (pt) at each point."""

        def mark() -> str:
            corners = (
                f"M{a - size / 2:.2f},{b - size / 2:.2f}h{size}v{size}h-{size}Z"
                for a, b in self._on_page(x, y)
            )
            return f'<path d="{"".join(corners)}" fill="{colour}"/>'

        if x.size:
            self._marks.append(mark)

    def picture(
        self, colours: NDArray[np.uint8], x_range: tuple[float, float], y_range: tuple[float, float]
    ) -> None:
        """Pixels (rows upwards, columns, 3) over these ranges."""
        png = base64.b64encode(_png(colours[::-1])).decode()

        def mark() -> str:
            (left, bottom), (right, top) = self._on_page(np.array(x_range), np.array(y_range))
            place = f'x="{left:.2f}" y="{top:.2f}" width="{right - left:.2f}" height="{bottom - top:.2f}"'
            return f'<image {place} preserveAspectRatio="none" href="data:image/png;base64,{png}"/>'

        self._marks.append(mark)

    def name(self, across: float, up: float, text: str, anchor: str, size: float, colour: str) -> None:
        """A text at shares of the panel's width and height, vertically in the middle of its line."""
        x, y = self.left + across * self.width, self.top + (1.0 - up) * self.height + 0.35 * size
        place = f'x="{x:.2f}" y="{y:.2f}" text-anchor="{anchor}" font-size="{size}" fill="{colour}"'
        self._marks.append(lambda: f"<text {place}>{text}</text>")

    def with_equal_scales(self, x_range: tuple[float, float], y_range: tuple[float, float]) -> None:
        """Shrink the panel to these ranges at the same scale in both directions, about its centre."""
        across, up = x_range[1] - x_range[0], y_range[1] - y_range[0]
        scale = min(self.width / across, self.height / up)
        self.left, self.width = self.left + 0.5 * (self.width - scale * across), scale * across
        self.top, self.height = self.top + 0.5 * (self.height - scale * up), scale * up
        self.x_range, self.y_range = x_range, y_range

    def svg(self, name: str) -> str:
        """The panel; `name` is that of its clip path."""
        self._set_ranges()
        place = f'x="{self.left:.2f}" y="{self.top:.2f}" width="{self.width:.2f}" height="{self.height:.2f}"'
        shaded = "".join(map(self._band, *zip(*self.bands, strict=True))) if self.bands else ""
        return (
            f'<clipPath id="{name}"><rect {place}/></clipPath><g clip-path="url(#{name})">{shaded}'
            f"{''.join(mark() for mark in self._marks)}</g>{self._axes(place)}{self._legend()}"
        )

    def _set_ranges(self) -> None:
        if self.x_range is None:
            self.x_range = _range([x for x, _ in self._lines])
        if self.y_range is None:
            low, high = _range([np.log10(y) if self.log else y for _, y in self._lines])
            more = 0.05 * (high - low)
            low, high = low - more, high + more
            self.y_range = (10**low, 10**high) if self.log else (low, high)

    def _on_page(self, x: Floats, y: Floats) -> list[list[float]]:
        assert self.x_range is not None
        assert self.y_range is not None
        (x0, x1), (y0, y1) = self.x_range, self.y_range
        if self.log:
            y, y0, y1 = np.log10(y), float(np.log10(y0)), float(np.log10(y1))
        across, up = (x - x0) / (x1 - x0), (y - y0) / (y1 - y0)
        on_page = (self.left + across * self.width, self.top + (1.0 - up) * self.height)
        found: list[list[float]] = np.stack(on_page, axis=1).tolist()
        return found

    def _path(self, x: Floats, y: Floats) -> str:
        finite = np.isfinite(x) & np.isfinite(y)
        starts = np.diff(finite, prepend=False) & finite
        points = zip(self._on_page(x[finite], y[finite]), starts[finite].tolist(), strict=True)
        return "".join(f"{'M' if start else 'L'}{a:.2f},{b:.2f}" for (a, b), start in points)

    def _band(self, begin: float, end: float, colour: str, opacity: float) -> str:
        assert self.x_range is not None
        x0, x1 = self.x_range
        left, right = (self.left + (x - x0) / (x1 - x0) * self.width for x in (begin, end))
        place = f'x="{left:.2f}" y="{self.top:.2f}" width="{right - left:.2f}" height="{self.height:.2f}"'
        return f'<rect {place} fill="{colour}" fill-opacity="{opacity}"/>'

    def _axes(self, place: str) -> str:
        assert self.x_range is not None
        assert self.y_range is not None
        bottom, right = self.top + self.height, self.left + self.width
        across = linear_ticks(*self.x_range, self.width / (25 if self.boxed else 55))
        up = (
            log_ticks(*self.y_range, self.height / 25)
            if self.log
            else linear_ticks(*self.y_range, self.height / 25)
        )
        edges = f"M{self.left:.2f},{self.top:.2f}V{bottom:.2f}H{right:.2f}"
        for at in across.shares:
            edges += f"M{self.left + at * self.width:.2f},{bottom:.2f}v3.5"
        for at in up.shares:
            edges += f"M{self.left:.2f},{bottom - at * self.height:.2f}h-3.5"
        drawn = f'<path d="{edges}" fill="none" stroke="currentColor" stroke-width="0.7"/>'
        if self.boxed:
            drawn += f'<rect {place} fill="none" stroke="{grey}" stroke-width="0.7"/>'
        return drawn + self._tick_labels(across, up) + self._labels()

    def _tick_labels(self, across: Ticks, up: Ticks) -> str:
        bottom, found = self.top + self.height, ""
        if self.x_named:
            for at, text in zip(across.shares, across.labels, strict=True):
                x = self.left + at * self.width
                found += f'<text x="{x:.2f}" y="{bottom + 13:.2f}" text-anchor="middle">{text}</text>'
        if self.y_named:
            for at, text in zip(up.shares, up.labels, strict=True):
                y = bottom - at * self.height + 3.3
                found += f'<text x="{self.left - 6:.2f}" y="{y:.2f}" text-anchor="end">{text}</text>'
        return found

    def _labels(self) -> str:
        middle, found = self.left + 0.5 * self.width, ""
        if self.x_label:
            y = self.top + self.height + 27
            found += f'<text x="{middle:.2f}" y="{y:.2f}" text-anchor="middle">{escape(self.x_label)}</text>'
        if self.y_label:
            x, y = self.left - 46, self.top + 0.5 * self.height
            turned = f'transform="translate({x:.2f},{y:.2f}) rotate(-90)" text-anchor="middle"'
            found += f"<text {turned}>{escape(self.y_label)}</text>"
        for k, text in enumerate(reversed(self.title.split("\n") if self.title else [])):
            y = self.top - 5 - 11.5 * k
            found += f'<text x="{middle:.2f}" y="{y:.2f}" text-anchor="middle">{escape(text)}</text>'
        return found

    def _legend(self) -> str:
        x, y, found = self.left, self.top - 7, ""
        for label, colour in self.legend:
            found += f'<path d="M{x:.2f},{y:.2f}h13" stroke="{colour}" stroke-width="2"/>'
            found += f'<text x="{x + 18:.2f}" y="{y + 3.2:.2f}" font-size="9">{escape(label)}</text>'
            x += 18 + 9 * _LETTER * len(label) + 16
        return found


class Plot:
    """A figure of this size (inches), to which panels are added.

    Attributes
    ----------
    width, height : float
        pt.
    """

    def __init__(self, title: str, size: tuple[float, float]) -> None:
        self.title, (self.width, self.height) = title, (72 * size[0], 72 * size[1])
        self.panels: list[Panel] = []
        self._more = ""

    def column(self, count: int, *, right: float = 10.0) -> list[Panel]:
        """Panels below each other with one axis below, `right` (pt) from the right edge."""
        left, top, between, bottom = 58.0, 18.0, 24.0, 32.0
        height = (self.height - top - bottom - (count - 1) * between) / count
        made = [
            Panel(
                left, top + k * (height + between), self.width - left - right, height, x_named=k == count - 1
            )
            for k in range(count)
        ]
        self.panels += made
        return made

    def row(self, count: int, *, right: float = 10.0, top: float = 30.0) -> list[Panel]:
        """Panels beside each other with one axis at the left."""
        left, between, bottom = 58.0, 8.0, 20.0
        width = (self.width - left - right - (count - 1) * between) / count
        height = self.height - top - bottom
        made = [
            Panel(left + k * (width + between), top, width, height, boxed=True, y_named=k == 0)
            for k in range(count)
        ]
        self.panels += made
        return made

    def colour_bar(self, beside: Panel, largest: float, label: str) -> None:
        """The colours of `viridis` for 0 to `largest`, right of a panel."""
        left, top, width, height = beside.left + beside.width + 8, beside.top, 9.0, beside.height
        codes = [f"#{bytes(colour).hex()}" for colour in viridis(np.linspace(1.0, 0.0, 64))]
        for k, code in enumerate(codes):
            y = top + height * k / len(codes)
            self._more += (
                f'<rect x="{left:.2f}" y="{y:.2f}" width="{width}" height="{height / 63:.2f}" fill="{code}"/>'
            )
        ticks = linear_ticks(0.0, largest, height / 25)
        for at, text in zip(ticks.shares, ticks.labels, strict=True):
            self._more += (
                f'<text x="{left + width + 4:.2f}" y="{top + (1 - at) * height + 3.3:.2f}">{text}</text>'
            )
        turned = f"translate({left + width + 38:.2f},{top + 0.5 * height:.2f}) rotate(-90)"
        self._more += f'<text transform="{turned}" text-anchor="middle">{escape(label)}</text>'

    def drawing(self, caption: str, alt: str) -> Drawing:
        """The figure with its caption and its text for who does not see it."""
        name = f"p{zlib.crc32(self.title.encode()):08x}"
        panels = "".join(panel.svg(f"{name}-{k}") for k, panel in enumerate(self.panels))
        count_figure()
        return Drawing(
            self.title,
            caption,
            alt,
            f'<svg role="img" aria-label="{escape(alt)}" xmlns="http://www.w3.org/2000/svg" '
            f'viewBox="0 0 {self.width:g} {self.height:g}" font-family="sans-serif" font-size="9.5" '
            f'fill="currentColor">{panels}{self._more}</svg>',
        )


def over_time(*panels: tuple[Panel, str]) -> None:
    """Label each panel (panel, name), and the common time axis (ms) below the last one."""
    for panel, name in panels:
        panel.y_label = name
    panels[-1][0].x_label = "time (ms)"


def _range(values: Sequence[Floats]) -> tuple[float, float]:
    """Of all finite values; one wide about a single value, and (0, 1) of none."""
    finite = [part[np.isfinite(part)] for part in values]
    kept = np.concatenate(finite) if finite else np.empty(0)
    if not kept.size:
        return 0.0, 1.0
    low, high = float(kept.min()), float(kept.max())
    half = 0.5 * abs(low) or 0.5
    return (low, high) if high > low else (low - half, high + half)


def _png(colours: NDArray[np.uint8]) -> bytes:
    """Pixels (rows, columns, 3) as PNG."""
    rows, columns, _ = colours.shape
    lines = np.concatenate(
        (np.zeros((rows, 1), np.uint8), colours.reshape(rows, -1)), axis=1
    )  # without filter
    parts = (
        (b"IHDR", struct.pack(">2I5B", columns, rows, 8, 2, 0, 0, 0)),
        (b"IDAT", zlib.compress(lines.tobytes(), 6)),
        (b"IEND", b""),
    )
    found = b"\x89PNG\r\n\x1a\n"
    for kind, content in parts:
        found += (
            struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))
        )
    return found
