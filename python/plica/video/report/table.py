"""Many recordings in one table: a row each, with its light and every measure that any of them has."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from plica.storage.table import heading, write_rows
from plica.video.analysis import Analysis
from plica.video.report.verdict import light_of

__all__ = ["row_of", "write_recordings"]


def row_of(found: Analysis) -> dict[str, object]:
    """What one recording has, by the heading of its column.

    A measure has the unit that people read it in, and two columns more for the ends of its interval; one that
    is not known is left out.
    """
    light = light_of(found)
    row: dict[str, object] = {
        **found.described,
        "frames": found.count,
        "light": light.shown,
        "reasons": light.said.strip(),
    }
    for item in found.measures.values():
        if item.value is None:
            continue
        factor, unit = item.quantity.people(found.scale)
        row[heading(item.name, unit)] = factor * item.value
        if item.interval is not None:
            low, high = item.interval
            row[f"{item.name} low"], row[f"{item.name} high"] = factor * low, factor * high
    return row


def write_recordings(path: Path, found: Mapping[str, Analysis | str]) -> None:
    """Write a CSV file with a row for each recording by its name, or why it has none (a text).

    Replaced atomically, so that what was written before is never lost.
    """
    rows = [
        {"recording": name, **({"error": one} if isinstance(one, str) else row_of(one))}
        for name, one in found.items()
    ]
    write_rows(path, rows)
