"""Measures as people read them on a terminal."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

__all__ = ["MAIN_MEASURES", "measures_table"]

MAIN_MEASURES = (
    "fundamental_frequency",
    "open_quotient",
    "speed_quotient",
    "peak_flow",
    "mean_flow",
    "glottal_area_max",
    "amplitude_left",
    "amplitude_right",
    "peak_contact_pressure",
    "contact_impulse",
    "contact_duration",
    "contact_length_fraction",
    "ledger_error",
)
_DISPLAYED = {
    "m": (1e3, "mm"),
    "m^2": (1e6, "mm^2"),
    "m^3/s": (1e6, "cm^3/s"),
    "s": (1e3, "ms"),
    "Pa": (1e-3, "kPa"),
}


def measures_table(measures: Mapping[str, Mapping[str, Any]], *, short: bool = False) -> str:
    """The measures with their units, in the units that the field reads; `short`: the main ones."""
    names = [name for name in MAIN_MEASURES if name in measures] if short else list(measures)
    lines = []
    for name in names or list(measures):
        entry = measures[name]
        if entry["value"] is None:
            if not short:
                lines.append(f"{name:<32} -            {entry.get('note', '')}")
            continue
        factor, unit = _DISPLAYED.get(entry["unit"], (1.0, entry["unit"]))
        unit = "" if unit == "1" else unit
        spread = f"+- {entry['spread'] * factor:.2g}" if entry["spread"] is not None else ""
        cycles = f"({entry['cycles']} cycles)" if entry["cycles"] else ""
        lines.append(f"{name:<32} {entry['value'] * factor:<12.6g} {unit:<8} {spread:<11} {cycles}".rstrip())
    return "\n".join(lines)
