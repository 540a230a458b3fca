"""An analysis as a file of MATLAB: structs of its light, measures, tables and settings."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from plica.measures.measure import Measure
from plica.storage.files import replaced
from plica.video.analysis import Analysis
from plica.video.light import light_of
from plica.video.tables import Column, about, tables_of

__all__ = ["write_matlab"]


def write_matlab(found: Analysis) -> Path:
    """Write recording.mat beside the results, in the format of MATLAB 5 with the names of up to 63 characters
    that MATLAB reads since 7.6 (R2008a).

    ``light`` has colour, reasons (a cell each) and the recording; ``measures`` a struct for each measure:
    value, unit, interval, spread, cycles, label, symbol, note, cautions; ``cycles``, ``folds`` and
    ``waveforms`` a column for each name (a matrix for the modes), and their ``units``, as ``signals`` where
    there are some beside the picture; ``settings`` what it was analysed with. A number that is not known is
    NaN, a setting that was not given [].

    Raises
    ------
    StorageFailed
        Where the file cannot be written.
    """
    from scipy.io import savemat

    light = light_of(found)
    tables = tables_of(found)
    del tables["measures"]
    recorded = [Column(name, found.units[name], values) for name, values in found.waveforms.items()]
    content: dict[str, Any] = {
        "light": {
            "colour": light.shown,
            "reasons": _cells(light.reasons),
            "recording": {name: _value(value) for name, value in about(found).items()},
        },
        "measures": {name: _measure(item) for name, item in found.measures.items()},
        **{name: _struct(table) for name, table in (tables | {"waveforms": recorded}).items()},
        "settings": {name: _value(value) for name, value in asdict(found.settings).items()},
    }
    path = found.directory / "recording.mat"

    def fill(draft: Path) -> None:
        with draft.open("wb") as file:
            savemat(file, content, long_field_names=True, do_compression=True, oned_as="column")

    replaced(path, fill)
    return path


def _measure(item: Measure) -> dict[str, Any]:
    return {
        "value": _number(item.value),
        "unit": item.unit,
        "interval": np.array([item.interval or (np.nan, np.nan)]),
        "spread": _number(item.spread),
        "cycles": float(item.cycles),
        "label": item.quantity.label,
        "symbol": item.quantity.symbol,
        "note": item.note,
        "cautions": _cells(item.cautions),
    }


def _number(value: float | None) -> float:
    return np.nan if value is None else value


def _struct(table: Sequence[Column]) -> dict[str, Any]:
    """Columns by name, and their units; one of words is of cells."""
    columns = {column.name: column.values for column in table}
    words = {name: values.dtype.kind in "UO" for name, values in columns.items()}
    return {
        **{name: _cells(values) if words[name] else values for name, values in columns.items()},
        "units": {column.name: column.unit for column in table},
    }


def _cells(texts: Iterable[str]) -> npt.NDArray[np.object_]:
    """A column of cells; without texts an empty one."""
    found = [str(text) for text in texts]
    cells = np.empty((len(found), 1 if found else 0), dtype=object)
    for k, text in enumerate(found):
        cells[k, 0] = text
    return cells


def _value(value: object) -> Any:
    """A setting: [] without a value, a row of several numbers, numbers as double, yes or no as logical."""
    if value is None:
        return np.zeros((0, 0))
    if isinstance(value, tuple):
        return np.array([value], dtype=float)
    if isinstance(value, int) and not isinstance(value, bool):
        return float(value)
    return value
