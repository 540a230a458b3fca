"""The waveforms beneath the surface."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from plica.measures.record import Array, Floats
from plica.measures.run.cautions import smallest_pressure_change
from plica.measures.run.glottal import open_area
from plica.measures.run.run_data import RunData, reached
from plica.measures.scale import shown_unit
from plica.measures.waveforms import STORED
from plica.report.wording import typeset
from plica.viewer.phases import Phases

__all__ = ["waves"]

_DRIVING = "subglottal pressure"  # shown where it moves
_CURVES = (
    ("flow", "flow"),
    ("subglottal_pressure", _DRIVING),
    ("supraglottal_pressure", "pressure above the glottis"),
    ("largest_contact_pressure", "largest contact pressure"),
    ("strain_999", "strain, 0.1 % of the volume has more"),
)
_DIGITS = 5


def waves(run: RunData, phases: Phases) -> dict[str, Any]:
    """Time (ms) and curves with units of people, at the steps from the first to the last phase."""
    time, waveforms = reached(run.whole)
    slack = 1e-9
    part = slice(
        int(np.searchsorted(time, phases.time[0] - slack)),
        int(np.searchsorted(time, phases.time[-1] + slack)),
    )
    curves = [
        {"name": label, "unit": unit, "values": _rounded(values[part])}
        for label, unit, values in _curves(waveforms)
        if label != _DRIVING or np.ptp(values[part]) > smallest_pressure_change * values[part].max()
    ]
    return {"time": [round(1e3 * float(t), 6) for t in time[part]], "curves": curves}


def _curves(waveforms: dict[str, Array]) -> Iterator[tuple[str, str, Floats]]:
    if "minimum_area" in waveforms:
        factor, unit = shown_unit(STORED["minimum_area"].unit)
        yield "glottal area", typeset(unit), factor * open_area(waveforms)
    for name, label in _CURVES:
        if name in waveforms:
            factor, unit = shown_unit(STORED[name].unit, STORED[name].shown)
            if unit == "1":
                factor, unit = 100.0, "%"
            yield label, typeset(unit), factor * np.asarray(waveforms[name], dtype=float)


def _rounded(values: Floats) -> list[float | None]:
    """Of numbers that are none, None: JSON has no such numbers."""
    return [float(f"{value:.{_DIGITS}g}") if np.isfinite(value) else None for value in values]
