"""The waveforms of an analysis as a table."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np

from plica.measures.file import write_measures
from plica.storage.files import replaced
from plica.video.analysis import Analysis

__all__ = ["write_tables"]


def write_tables(found: Analysis) -> None:
    """waveforms.csv, a row a frame, and measures.json."""
    units, columns = found.units, {}
    for name, values in found.waveforms.items():
        unit = f" ({units[name]})" if units[name] else ""
        if values.ndim == 1:
            columns[f"{name}{unit}"] = values
            continue
        for k, part in enumerate(values.T, start=1):
            columns[f"{name}_{k}{unit}"] = part

    def write(path: Path) -> None:
        with path.open("w", newline="", encoding="utf-8") as out:
            rows = csv.writer(out)
            rows.writerow(columns)
            rows.writerows(zip(*(_cells(values) for values in columns.values()), strict=True))

    replaced(found.directory / "waveforms.csv", write)
    write_measures(found.measures, found.directory / "measures.json")


def _cells(values: np.ndarray) -> list[object]:
    """Nothing where a number is not one."""
    return ["" if isinstance(value, float) and value != value else value for value in values.tolist()]
