"""The tables of an analysis: its measures; a row a frame, a row a cycle, a row a place along the folds.

Each is made here once, and written as CSV, as a sheet of a workbook (`plica.video.workbook`) and as a struct
for MATLAB (`plica.video.matlab`).
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from plica._engine import build_info
from plica.measures.file import write_measures
from plica.measures.glottal import cycle_quotients
from plica.measures.sides import amplitudes, crest_lags
from plica.storage.json_file import write_json
from plica.storage.table import heading, write_table
from plica.video.analysis import Analysis
from plica.video.light import light_of
from plica.video.measures.waveforms import counted, edge_error

__all__ = ["Column", "about", "cycles_table", "folds_table", "tables_of", "write_tables"]

Columns = dict[str, npt.NDArray[np.float64]]


class Column(NamedTuple):
    """A column of a table; the unit is "" or "1" of words and pure numbers."""

    name: str
    unit: str
    values: npt.NDArray[Any]

    @property
    def heading(self) -> str:
        """The name with its unit."""
        return heading(self.name, self.unit)


def write_tables(found: Analysis) -> None:
    """measures.csv, cycles.csv, folds.csv and waveforms.csv, a row a frame; where there are signals beside
    the picture signals.csv, a row a sample; measures.json and light.json.

    All have the light: the CSV files in a column, and measures.csv also why, and the recording's name. The
    others have label and day, where these are known. Without cycles cycles.csv and folds.csv have no row.
    """
    light, tables = light_of(found), tables_of(found)
    if "signals" not in tables:
        (found.directory / "signals.csv").unlink(missing_ok=True)  # of signals that were taken away
    for name, table in tables.items():
        columns = {column.heading: column.values for column in table}
        said = {"light": light.shown}
        if name == "measures":
            said |= {"light_reasons": light.said, "recording": found.label}
        rows = table[0].values.size
        columns |= {one: np.full(rows, text, object) for one, text in said.items()}
        comments = {} if name == "measures" else found.described
        write_table(found.directory / f"{name}.csv", columns, comments)
    reasons = list(light.reasons)
    recording: dict[str, object] = {**found.described, "light": light.shown, "light_reasons": reasons}
    write_measures(found.measures, found.directory / "measures.json", recording)
    content = {"light": light.shown, "reasons": reasons, "recording": about(found)}
    write_json(content, found.directory / "light.json")


def tables_of(found: Analysis) -> dict[str, Sequence[Column]]:
    """Measures, cycles, folds and waveforms, and signals where there are some."""
    tables: dict[str, Sequence[Column]] = {
        "measures": _measures(found),
        "cycles": _cycles(found),
        "folds": _folds(found),
        "waveforms": _waveforms(found),
    }
    return tables | ({"signals": _signals(found)} if found.signals.parts else {})


def about(found: Analysis) -> dict[str, str | int | float | None]:
    """What was analysed: file, label, frames, scale and part; None for what is not known."""
    settings, first = found.settings, found.settings.first or 0
    x, y, width, height = settings.region or (None, None, None, None)
    return {
        "file": found.source.name,
        "label": settings.label,
        "recorded": found.recorded or None,
        "frames": found.count,
        "first_frame": first,
        "last_frame": first + found.count - 1,
        "region_x_px": x,
        "region_y_px": y,
        "region_width_px": width,
        "region_height_px": height,
        "rotation_deg": settings.rotation,
        "frames_per_second": settings.fps,
        "mm_per_px": settings.mm_per_px,
        "unit_of_time": found.scale.time,
        "unit_of_length": found.scale.length,
        "left_is": found.side("left"),
        "right_is": found.side("right"),
        "masks_drawn_by_hand": len(found.drawn),
        **{name: Path(text).name for name, text in settings.signals.items()},
        "plica_version": build_info()["version"],
    }


def cycles_table(found: Analysis) -> Columns:
    """Each cycle of the glottal area, by the heading of its column: when it begins and ends, what its area
    and its edges do, and whether measures are taken over it (1 or 0). By the outline halfway to the tissue,
    with the slits that blur hides."""
    return _by_heading(_cycles(found))


def folds_table(found: Analysis) -> Columns:
    """Both folds along the midline, by the heading of the column: amplitude of each fold's edge, its phase
    behind the glottal area, and for which share of the time the glottis is open there; means over cycles.

    Places are shares of the midline's length from its upper end. A phase is not a number where a fold moves
    by less than edges are placed to.
    """
    return _by_heading(_folds(found))


def _by_heading(table: Sequence[Column]) -> Columns:
    return {column.heading: column.values for column in table}


def _measures(found: Analysis) -> list[Column]:
    """A row a measure, in the units of `Analysis.measures`; of one that is not known the note has why."""
    items = list(found.measures.values())
    ends = [item.interval or (None, None) for item in items]

    def words(values: Sequence[str]) -> npt.NDArray[np.object_]:
        return np.array(values, dtype=object)

    def numbers(values: Sequence[float | None]) -> npt.NDArray[np.float64]:
        return np.array([np.nan if value is None else value for value in values], dtype=float)

    return [
        Column("name", "", words([item.name for item in items])),
        Column("label", "", words([item.quantity.label for item in items])),
        Column("symbol", "", words([item.quantity.symbol for item in items])),
        Column("value", "", numbers([item.value for item in items])),
        Column("unit", "", words([item.unit for item in items])),
        Column("low", "", numbers([low for low, _ in ends])),
        Column("high", "", numbers([high for _, high in ends])),
        Column("spread", "", numbers([item.spread for item in items])),
        Column("cycles", "", np.array([item.cycles for item in items], dtype=int)),
        Column("note", "", words([item.note for item in items])),
        Column("cautions", "", words(["; ".join(item.cautions) for item in items])),
    ]


def _waveforms(found: Analysis) -> list[Column]:
    units, columns = found.units, []
    for name, values in found.waveforms.items():
        if values.ndim == 1:
            columns.append(Column(name, units[name], values))
            continue
        columns += [Column(f"{name}_{k}", units[name], part) for k, part in enumerate(values.T, start=1)]
    return columns


def _signals(found: Analysis) -> list[Column]:
    """A row a sample, of the sound and the electroglottogram; each with a time of its own where their samples
    are at other times, the shorter one then ending in cells without value."""
    parts = found.signals.parts
    one, *others = parts.values()
    shared = all(
        (part.rate, part.begin, part.values.size) == (one.rate, one.begin, one.values.size) for part in others
    )
    rows = max(part.values.size for part in parts.values())

    def column(name: str, unit: str, values: npt.NDArray[np.float64]) -> Column:
        return Column(name, unit, np.append(values, np.full(rows - values.size, np.nan)))

    columns = [column("time", "s", one.time)] if shared else []
    for name, part in parts.items():
        columns += [] if shared else [column(f"{name}_time", "s", part.time)]
        columns.append(column(name, "1", part.values))
    return columns


def _cycles(found: Analysis) -> list[Column]:
    cycles, time, scale = found.cycles, found.time, found.scale
    area = counted(found.area).filled()
    size = found.pixel
    total, left, right = size**2 * area.total, size * area.left_edge, size * area.right_edge
    parts = cycles.samples(time)
    lags = crest_lags(time, left, right, cycles)
    if found.measures["left_right_phase"].value is None:  # a fold is still
        lags = np.full(lags.shape, np.nan)
    columns: dict[tuple[str, str], npt.NDArray[Any]] = {
        ("start", "s"): cycles.starts[:-1],
        ("end", "s"): cycles.starts[1:],
        ("frequency", "Hz"): 1 / cycles.periods,
        ("open_quotient", "1"): np.array([one.open for one in cycle_quotients(time, total, cycles)]),
        ("glottal_area_max", "m^2"): np.array([total[part].max() for part in parts]),
        ("glottal_area_min", "m^2"): np.array([total[part].min() for part in parts]),
        ("amplitude_left", "m"): amplitudes(time, left, cycles),
        ("amplitude_right", "m"): amplitudes(time, right, cycles),
        ("left_right_phase", "rad"): lags,
        ("used", "1"): np.array([float(k not in cycles.left_out) for k in range(cycles.count)]),
    }
    if not cycles.count:
        columns = {name: np.zeros(0) for name in columns}
    return [Column(name, scale.unit(unit), values) for (name, unit), values in columns.items()]


def _folds(found: Analysis) -> list[Column]:
    cycles, time = found.cycles, found.time
    edges = found.vibrogram
    count = edges.shape[1]
    rows = np.full((count, 5), np.nan)
    area = found.area.filled().total
    inside = (
        [k for part in cycles.samples(time) for k in range(part.start, part.stop)] if cycles.count else []
    )
    for place in range(count if cycles.count else 0):
        left, right = edges[:, place]
        if not (np.isfinite(left).all() and np.isfinite(right).all()):
            known = np.flatnonzero(np.isfinite(left + right))
            left, right = (np.interp(np.arange(left.size), known, edge[known]) for edge in (left, right))
        for side, edge in enumerate((left, right)):
            way = float(np.nanmean(cycles.used(amplitudes(time, edge, cycles))))
            rows[place, side] = way
            if way >= edge_error:
                apart = left + right > 1e-9
                lags = cycles.used(crest_lags(time, area, edge, cycles, apart))
                lags = lags[np.isfinite(lags)]
                if lags.size:
                    rows[place, 2 + side] = np.angle(np.mean(np.exp(1j * lags)))
        rows[place, 4] = np.mean((left + right)[inside] > 1e-9)
    rows = rows if cycles.count else rows[:0]
    length = found.scale.unit("m")
    return [
        Column("place", "1", (np.arange(len(rows)) + 0.5) / count),
        Column("amplitude_left", length, found.pixel * rows[:, 0]),
        Column("amplitude_right", length, found.pixel * rows[:, 1]),
        Column("phase_left", "rad", rows[:, 2]),
        Column("phase_right", "rad", rows[:, 3]),
        Column("open_share", "1", rows[:, 4]),
    ]
