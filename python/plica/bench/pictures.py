"""A case as a picture: error against time, both logarithmic, methods named, the front marked."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import cycle
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from plica.bench.front import front
from plica.bench.record import Record, Row
from plica.report.drawing import Drawing, blue, draw, green, grey, purple, red

__all__ = ["picture"]

_MARKERS = "osD^vPX"
_LEAST = 1e-17  # what is 0 is drawn here


def picture(record: Record) -> Drawing | None:
    """The rows of the fewest threads; None where none has both a time and an error."""
    error = next(iter(record.errors))
    fewest = min((row.threads for row in record.rows), default=1)
    rows = [
        row
        for row in record.rows
        if row.threads == fewest and row.median and row.errors.get(error) is not None
    ]
    if not rows:
        return None
    lines = _lines(rows)
    best = front(rows, error)
    names = ", ".join(dict.fromkeys(row.method for row in best))
    threads = f"{fewest} thread{'s' * (fewest > 1)}"
    return draw(
        record.case,
        f"{threads}. Rings: the front, which no other row beats in both.",
        f"{record.case}: {error} against time; on the front: {names}",
        (7.5, max(3.6, 0.8 + 0.19 * len(lines))),
        lambda figure: _paint(figure, lines, best, error),
    )


def _lines(rows: Sequence[Row]) -> dict[str, list[Row]]:
    """Rows by method and the settings that are words, each in the order of its times."""
    lines: dict[str, list[Row]] = {}
    for row in rows:
        words = [value for value in row.level.values() if isinstance(value, str)]
        lines.setdefault(", ".join([row.method, *words]), []).append(row)
    return {name: sorted(theirs, key=lambda row: row.median or 0.0) for name, theirs in lines.items()}


def _paint(figure: Figure, lines: dict[str, list[Row]], best: Sequence[Row], error: str) -> None:
    axes = figure.subplots()
    looks = cycle((marker, colour) for marker in _MARKERS for colour in (blue, red, green, purple, grey))
    for (name, rows), (marker, colour) in zip(lines.items(), looks, strict=False):
        _plot(axes, rows, error, marker=marker, color=colour, ms=4.5, lw=1.0, label=name)
    _plot(axes, best, error, ls="none", marker="o", ms=11, mfc="none", mec=grey, label="front")
    axes.set(xscale="log", yscale="log", xlabel="time (s)", ylabel=f"error: {error}")
    axes.grid(which="major", alpha=0.25)
    axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), fontsize=7.5)


def _plot(axes: Axes, rows: Sequence[Row], error: str, **looks: Any) -> None:
    times = [row.median or 0.0 for row in rows]
    axes.plot(times, [max(abs(row.errors[error] or 0.0), _LEAST) for row in rows], **looks)
