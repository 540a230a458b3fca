"""The tables of an analysis: a row a frame, a row a cycle, a row a place along the folds; its measures."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from plica.measures.file import write_measures
from plica.measures.glottal import cycle_quotients
from plica.measures.sides import amplitudes, crest_lags
from plica.storage.table import heading, write_table
from plica.video.analysis import Analysis
from plica.video.measures.waveforms import counted, edge_error

__all__ = ["cycles_table", "folds_table", "write_tables"]

Columns = dict[str, npt.NDArray[np.float64]]


def write_tables(found: Analysis) -> None:
    """waveforms.csv, a row a frame, cycles.csv, folds.csv and measures.json; all with label and day, where
    these are known. Without cycles there is no row in cycles.csv and folds.csv."""
    units, columns = found.units, {}
    for name, values in found.waveforms.items():
        if values.ndim == 1:
            columns[heading(name, units[name])] = values
            continue
        for k, part in enumerate(values.T, start=1):
            columns[heading(f"{name}_{k}", units[name])] = part
    write_table(found.directory / "waveforms.csv", columns, found.described)
    write_table(found.directory / "cycles.csv", cycles_table(found), found.described)
    write_table(found.directory / "folds.csv", folds_table(found), found.described)
    write_measures(found.measures, found.directory / "measures.json", found.described)


def cycles_table(found: Analysis) -> Columns:
    """Each cycle of the glottal area, by the heading of its column: when it begins and ends, what its area
    and its edges do, and whether measures are taken over it (1 or 0). By the outline halfway to the tissue,
    with the slits that blur hides."""
    cycles, time, scale = found.cycles, found.time, found.scale
    area = counted(found.area).filled()
    size = found.pixel
    total, left, right = size**2 * area.total, size * area.left_edge, size * area.right_edge
    parts = cycles.samples(time)
    columns = {
        ("start", "s"): cycles.starts[:-1],
        ("end", "s"): cycles.starts[1:],
        ("frequency", "Hz"): 1 / cycles.periods,
        ("open_quotient", "1"): np.array([one.open for one in cycle_quotients(time, total, cycles)]),
        ("glottal_area_max", "m^2"): np.array([total[part].max() for part in parts]),
        ("glottal_area_min", "m^2"): np.array([total[part].min() for part in parts]),
        ("amplitude_left", "m"): amplitudes(time, left, cycles),
        ("amplitude_right", "m"): amplitudes(time, right, cycles),
        ("left_right_phase", "rad"): crest_lags(time, left, right, cycles),
        ("used", "1"): np.array([float(k not in cycles.left_out) for k in range(cycles.count)]),
    }
    if not cycles.count:
        columns = {name: np.zeros(0) for name in columns}
    return {heading(name, scale.unit(unit)): values for (name, unit), values in columns.items()}


def folds_table(found: Analysis) -> Columns:
    """Both folds along the midline, by the heading of the column: amplitude of each fold's edge, its phase
    behind the glottal area, and for which share of the time the glottis is open there; means over cycles.

    Places are shares of the midline's length from its upper end. A phase is not a number where a fold moves
    by less than edges are placed to.
    """
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
    unit = found.scale.unit
    columns = {
        "place": (np.arange(count) + 0.5) / count,
        heading("amplitude_left", unit("m")): found.pixel * rows[:, 0],
        heading("amplitude_right", unit("m")): found.pixel * rows[:, 1],
        "phase_left (rad)": rows[:, 2],
        "phase_right (rad)": rows[:, 3],
        "open_share": rows[:, 4],
    }
    return columns if cycles.count else {name: values[:0] for name, values in columns.items()}
