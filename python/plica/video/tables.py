"""The waveforms of an analysis as a table."""

from __future__ import annotations

from plica.measures.file import write_measures
from plica.storage.table import heading, write_table
from plica.video.analysis import Analysis

__all__ = ["write_tables"]


def write_tables(found: Analysis) -> None:
    """waveforms.csv, a row a frame, and measures.json; both with label and day, where these are known."""
    units, columns = found.units, {}
    for name, values in found.waveforms.items():
        if values.ndim == 1:
            columns[heading(name, units[name])] = values
            continue
        for k, part in enumerate(values.T, start=1):
            columns[heading(f"{name}_{k}", units[name])] = part
    write_table(found.directory / "waveforms.csv", columns, found.described)
    write_measures(found.measures, found.directory / "measures.json", found.described)
