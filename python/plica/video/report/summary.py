"""What of a recording to write down and what not, and why: the first page of its report."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from plica.measures.measure import Measure
from plica.report.wording import Row
from plica.video.analysis import Analysis
from plica.video.measures.waveforms import edge_error

__all__ = ["Recorded", "not_to_write_down", "summary"]

_WIDEST = {
    "fundamental_frequency": (0.05, "value"),
    "open_quotient": (0.1, "1"),
    "glottal_gap_index": (0.05, "1"),
    "glottal_area_max_relative": (0.2, "value"),
    "amplitude_left": (0.25, "value"),
    "amplitude_right": (0.25, "value"),
    "amplitude_ratio": (0.3, "value"),
    "left_right_phase": (np.radians(15.0), "rad"),
    "jitter": (0.01, "1"),
    "shimmer": (0.05, "1"),
}
"""Half widths of the 95 % interval up to which a value is written down, and of what."""
_EVERYWHERE = f"edges are placed to {edge_error:g} px"
"""How the caution begins that all recordings have."""


@dataclass(frozen=True)
class Recorded:
    """A measure as the summary has it; the reason is why it is not to be written down, empty where it is."""

    row: Row
    reason: str


def summary(found: Analysis, rows: dict[str, Row]) -> tuple[list[Recorded], list[Recorded]]:
    """What to write down, and what not, of the measures that people ask for first.

    Parameters
    ----------
    found : Analysis
    rows : dict of name to Row
        Of the measures, as the report has them.
    """
    judged = [Recorded(rows[name], _reason(found.measures[name])) for name in _WIDEST if name in rows]
    return [one for one in judged if not one.reason], [one for one in judged if one.reason]


def not_to_write_down(found: Analysis) -> list[str]:
    """Names of the measures that people ask for first of which the summary says not to write them down."""
    return [name for name in _WIDEST if name in found.measures and _reason(found.measures[name])]


def _reason(item: Measure) -> str:
    if item.value is None or not np.isfinite(item.value):
        return item.note or "not known"
    if item.interval is None:
        return item.cautions[0] if item.cautions else "no interval is known"
    low, high = item.interval
    most, of = _WIDEST[item.name]
    wide = (high - low) / 2 > most * (abs(item.value) if of == "value" else 1.0)
    said = [text for text in item.cautions if not text.startswith(_EVERYWHERE)]
    if wide and not said:
        return "its interval is wide"
    return f"{said[0]}{' (and more: see below)' if len(said) > 1 else ''}" if said else ""
