"""A case as a picture: error against time, both logarithmic, methods named, the front marked."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from benchmarks.harness.case_record import CaseRecord, Row
from benchmarks.harness.pareto import front
from plica.report.drawing import Drawing, blue, draw, green, grey, purple, red

__all__ = ["paint", "picture"]

_LOOKS = [(marker, colour) for marker in "osD^vPX*" for colour in (blue, red, green, purple, grey)]
_LEAST = 1e-17  # zero is plotted here
_WIDE = 3  # panels side by side


def picture(record: CaseRecord) -> Drawing | None:
    """The rows of the fewest threads, a panel a problem; None where none has both a time and an error."""
    fewest = min((row.threads for row in record.rows), default=1)
    error = next(iter(record.errors))
    kept = [row for row in record.rows if row.threads == fewest and _drawn(row, error)]
    if not kept:
        return None
    shown = record.model_copy(update={"rows": kept})
    panels = len(shown.by_problem())
    lines = len({_line_of(row, record.problem) for row in kept})
    size = (3.2 + 2.4 * min(panels, _WIDE), max(3.4 * -(-panels // _WIDE), 0.8 + 0.19 * lines))
    return draw(
        record.case,
        f"{fewest} thread{'s' * (fewest > 1)}. Rings: the front, which no other row beats in both.",
        f"{record.case}: {error} against time",
        size,
        lambda figure: paint(figure, shown),
    )


def paint(figure: Figure, record: CaseRecord) -> None:
    """Draw all rows of a record that has one with a time and an error at least."""
    error = next(iter(record.errors))
    names = list(dict.fromkeys(_line_of(row, record.problem) for row in record.rows))
    looks = dict(zip(names, _LOOKS * (1 + len(names) // len(_LOOKS)), strict=False))
    problems = record.by_problem()
    across = min(len(problems), _WIDE)
    grid = figure.subplots(-(-len(problems) // across), across, squeeze=False)
    for axes in grid.flat[len(problems) :]:
        axes.set_axis_off()
    for axes, (problem, rows) in zip(grid.flat, problems.items(), strict=False):
        title = ", ".join(f"{name} {value}" for name, value in zip(record.problem, problem, strict=True))
        _panel(axes, rows, error, looks, record.problem)
        axes.set_title(title)
    handles: dict[str, Artist] = {}
    for axes in grid.flat:
        handles |= {label: line for line, label in zip(*axes.get_legend_handles_labels(), strict=True)}
    shown = [name for name in (*names, "front") if name in handles]
    figure.legend([handles[name] for name in shown], shown, loc="outside right upper", fontsize=7.5)


def _panel(
    axes: Axes, rows: Sequence[Row], error: str, looks: dict[str, tuple[str, str]], problem: Sequence[str]
) -> None:
    lines: dict[str, list[Row]] = {}
    for row in sorted(rows, key=lambda row: row.median or 0.0):
        lines.setdefault(_line_of(row, problem), []).append(row)
    for name, theirs in lines.items():
        marker, colour = looks[name]
        _plot(axes, theirs, error, marker=marker, color=colour, ms=4.5, lw=1.0, label=name)
    _plot(axes, front(rows, error), error, ls="none", marker="o", ms=11, mfc="none", mec=grey, label="front")
    axes.set(xscale="log", yscale="log", xlabel="time (s)", ylabel=f"error: {error}")
    axes.margins(0.08)
    for axis in (axes.xaxis, axes.yaxis):
        _ticks(axis)
    axes.grid(which="major", alpha=0.25)


def _ticks(axis: Axis) -> None:
    """Decades; where there are fewer than two, what lies between them too."""
    low, high = axis.get_view_interval()
    between = (1.0,) if high > 100 * low else (1.0, 3.0) if high > 8 * low else (1.0, 2.0, 5.0)
    axis.set_major_locator(LogLocator(subs=between))
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.set_minor_formatter(NullFormatter())


def _line_of(row: Row, problem: Sequence[str]) -> str:
    """The method and the settings that are words."""
    words = [
        str(value) for name, value in row.level.items() if isinstance(value, str) and name not in problem
    ]
    return ", ".join([row.method, *words])


def _drawn(row: Row, error: str) -> bool:
    return row.median is not None and row.errors.get(error) is not None


def _plot(axes: Axes, rows: Sequence[Row], error: str, **looks: Any) -> None:
    times = [row.median or 0.0 for row in rows]
    axes.plot(times, [max(abs(row.errors[error] or 0.0), _LEAST) for row in rows], **looks)
