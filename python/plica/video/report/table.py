"""A recording as a row of the table of many: its light and why, what not to write down, and every measure."""

from __future__ import annotations

from plica.storage.table import heading
from plica.video.analysis import Analysis
from plica.video.light import light_of
from plica.video.report.summary import not_to_write_down

__all__ = ["row_of"]


def row_of(found: Analysis) -> dict[str, object]:
    """What one recording has, by the heading of its column.

    A measure has the unit that people read it in, and two columns more for the ends of its interval, in that
    unit; one that is not known is left out.
    """
    light = light_of(found)
    row: dict[str, object] = {
        **found.described,
        "frames": found.count,
        "light": light.shown,
        "light_reasons": light.said.strip(),
        "not_to_write_down": ", ".join(not_to_write_down(found)),
    }
    for item in found.measures.values():
        if item.value is None:
            continue
        factor, unit = item.quantity.people(found.scale)
        row[heading(item.name, unit)] = factor * item.value
        if item.interval is not None:
            low, high = item.interval
            row[heading(f"{item.name} low", unit)] = factor * low
            row[heading(f"{item.name} high", unit)] = factor * high
    return row
