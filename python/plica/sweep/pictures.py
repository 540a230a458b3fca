"""Pictures of a sweep: measures over what was varied, and sensitivity indices with their intervals."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from plica.measures.catalogue import CATALOGUE
from plica.measures.record import Floats
from plica.measures.scale import shown_unit
from plica.report.drawing import Drawing, blue, draw, green, grey, label_ends, purple, red
from plica.report.wording import typeset
from plica.sweep.results import Sweep
from plica.sweep.sensitivity import Indices

__all__ = ["indices_picture", "measures_picture"]

_COLOURS = (blue, red, green, purple, "#c2a03a", grey)
_COLUMNS = 5  # of panels at most, of as many keys
_WIDTH = 22  # characters of a label
_RASTERED = 200  # points from which they are drawn as a picture


def measures_picture(sweep: Sweep, measures: Sequence[str]) -> Drawing:
    """Measures (downwards) over each key (to the right); lines in a grid of one key or two."""
    ordered = sorted(sweep.keys, key=lambda key: key in sweep.words)  # numbers to the right before words
    keys = ordered[:_COLUMNS]
    lines = sweep.record["design"] == "grid" and len(ordered) <= 2
    columns = 1 if lines else len(keys)
    size = (6.4 if columns == 1 else min(2.3 * columns, 11.0), 1.9 * len(measures) + 0.6)

    def paint(figure: Figure) -> None:
        panels = figure.subplots(len(measures), columns, sharex="col", sharey="row", squeeze=False)
        for row, name in enumerate(measures):
            for key, axes in zip(keys, panels[row], strict=False):
                if lines:
                    _lines(axes, sweep, name, ordered)
                else:
                    _points(axes, sweep, name, key)
            panels[row][0].set_ylabel(_measure_label(sweep, name))
        for key, axes in zip(keys, panels[-1], strict=False):
            axes.set_xlabel(_key_label(sweep, key))
            if key in sweep.words:
                words = sweep.words[key]
                axes.set_xticks(range(len(words)), words, rotation=30 if len(words) > 3 else 0)
        if lines and len(ordered) == 2:
            names = _values_of(sweep, ordered[1])
            if len(names) <= len(_COLOURS):
                label_ends(panels[0][0], list(zip(names, _COLOURS, strict=False)))

    others = ordered[len(keys) :]
    caption = "Each point is a case" + (f"; not shown: over {', '.join(others)}" if others else "")
    if lines and len(ordered) == 2:
        caption += f"; each line is a value of {ordered[1]}"
    return draw("Measures", f"{caption}.", "Measures over what was varied", size, paint)


def _along(sweep: Sweep, key: str) -> Floats:
    """What every case has for a key, in common units; the position of a word."""
    return np.asarray(shown_unit(sweep.units[key])[0] * sweep.values[:, sweep.keys.index(key)])


def _values_of(sweep: Sweep, key: str) -> list[str]:
    """All values of a key as text."""
    if key in sweep.words:
        return list(sweep.words[key])
    unit = typeset(shown_unit(sweep.units[key])[1])
    return [f"{value:.4g} {unit}".strip() for value in dict.fromkeys(_along(sweep, key).tolist())]


def _lines(axes: Axes, sweep: Sweep, name: str, keys: Sequence[str]) -> None:
    """Over the first key, a line for each value of the second; of words points alone."""
    x, y = _along(sweep, keys[0]), sweep.shown(name)[0] * sweep[name]
    second = _along(sweep, keys[1]) if len(keys) > 1 else np.zeros(len(sweep))
    kind = "o" if keys[0] in sweep.words else "o-"
    for k, value in enumerate(dict.fromkeys(second.tolist())):
        chosen = second == value
        axes.plot(x[chosen], y[chosen], kind, color=_COLOURS[k % len(_COLOURS)], markersize=3.5)


def _points(axes: Axes, sweep: Sweep, name: str, key: str) -> None:
    axes.plot(
        _along(sweep, key),
        sweep.shown(name)[0] * sweep[name],
        ".",
        color=blue,
        markersize=3,
        rasterized=len(sweep) > _RASTERED,
    )


def indices_picture(found: Sequence[Indices]) -> Drawing:
    """Bars of each measure's indices by key, with 95 % intervals."""
    keys = list(dict.fromkeys(index.key for index in found[0].found))
    kinds = list(dict.fromkeys(index.kind for index in found[0].found))
    size = (7.4, (0.28 * len(keys) * len(kinds) + 0.65) * len(found) + 0.5)

    def paint(figure: Figure) -> None:
        panels = figure.subplots(len(found), 1, squeeze=False)[:, 0]
        for axes, one in zip(panels, found, strict=True):
            _bars(axes, one, keys, kinds)
        label_ends(panels[0], list(zip(kinds, _COLOURS, strict=False)))

    caption = "Lines: 95 % intervals, by bootstrap. "
    if "total" in kinds:
        caption += (
            "First order: share of the measure's variance that a key explains alone; total: with all its "
            "interactions with others. A total that is far above the first order says that keys act together."
        )
    else:
        caption += "Mean size of the change of the measure, per whole range of the key."
    return draw("Sensitivity", caption, "Sensitivity indices with their intervals", size, paint)


def _bars(axes: Axes, one: Indices, keys: Sequence[str], kinds: Sequence[str]) -> None:
    entry = CATALOGUE.get(one.measure)
    factor, unit = entry.people() if entry and entry.unit == one.unit != "1" else shown_unit(one.unit)
    height = 0.8 / len(kinds)
    for k, kind in enumerate(kinds):
        chosen = {index.key: index for index in one.found if index.kind == kind}
        place = np.arange(len(keys)) + (k - 0.5 * (len(kinds) - 1)) * height
        value: Floats = factor * np.array([chosen[key].value for key in keys])
        ends = factor * np.array([chosen[key].interval for key in keys]).T
        axes.barh(place, value, height, color=_COLOURS[k], alpha=0.75)
        axes.hlines(place, ends[0], ends[1], color=grey, linewidth=1.6)
    axes.axvline(0, color=grey, linewidth=0.7)
    axes.set_yticks(np.arange(len(keys)), keys)
    axes.invert_yaxis()
    label = one.measure if entry is None else entry.label
    axes.set_title(label if unit == "1" else f"{label} ({typeset(unit)})", loc="right")


def _measure_label(sweep: Sweep, name: str) -> str:
    unit = typeset(sweep.shown(name)[1])
    one = CATALOGUE.get(name)
    label = name if one is None else one.symbol or one.label
    return textwrap.fill(f"{label} ({unit})" if unit else label, _WIDTH)


def _key_label(sweep: Sweep, key: str) -> str:
    unit = typeset(shown_unit(sweep.units[key])[1])
    short = key if len(key) <= _WIDTH else ".".join(key.split(".")[-2:])
    return f"{short}\n({unit})" if unit else short
