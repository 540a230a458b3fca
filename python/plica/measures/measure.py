"""One measured quantity with its unit, its spread between cycles and the number of cycles."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from plica.measures.circular import circular_mean
from plica.measures.cycles import Cycles
from plica.measures.record import Floats


@dataclass(frozen=True)
class Measure:
    """A quantity in SI units.

    Attributes
    ----------
    value : float or None
        Mean over the cycles where there are cycles, of angles the circular one; None where it has no
        meaning (the note says why).
    unit : str
        SI, "1" for a pure number.
    spread : float or None
        Standard deviation between cycles (n - 1); None where nothing was averaged.
    cycles : int
        Number of cycles (or collisions) averaged; 0 for a quantity of the whole run.
    note : str
        How it is defined, where that is a choice, or why there is no value.
    """

    value: float | None
    unit: str
    spread: float | None = None
    cycles: int = 0
    note: str = ""

    def as_json(self) -> dict[str, Any]:
        """The entry of measures.json."""
        entry: dict[str, Any] = {
            "value": self.value,
            "unit": self.unit,
            "spread": self.spread,
            "cycles": self.cycles,
        }
        if self.note:
            entry["note"] = self.note
        return entry


def whole(value: float, unit: str, note: str = "") -> Measure:
    """A quantity of the whole run; without a value if it is not finite."""
    return Measure(float(value) if np.isfinite(value) else None, unit, note=note)


def absent(unit: str, reason: str) -> Measure:
    """A quantity that this run does not determine, with the reason."""
    return Measure(None, unit, note=reason)


def average(values: Floats, unit: str, note: str = "") -> Measure:
    """Mean and standard deviation of one value per cycle; those that are not finite are left out."""
    finite = np.asarray(values, dtype=float)
    finite = finite[np.isfinite(finite)]
    if not finite.size:
        return absent(unit, note or "undefined in every cycle")
    spread = float(finite.std(ddof=1)) if finite.size > 1 else None
    return Measure(float(finite.mean()), unit, spread, int(finite.size), note)


def per_cycle(cycles: Cycles, values: Floats, unit: str, note: str = "") -> Measure:
    """Average over cycles, or no value and the reason why there are no cycles."""
    return average(values, unit, note) if cycles.count else absent(unit, cycles.note)


def average_angle(values: Floats, unit: str = "rad", note: str = "") -> Measure:
    """Mean direction of one angle (rad) per cycle, in (-pi, pi], and the spread about it.

    Angles that are not finite are left out; without a value where they point in all directions
    (:func:`plica.measures.circular.circular_mean`).
    """
    finite = np.asarray(values, dtype=float)
    finite = finite[np.isfinite(finite)]
    mean, spread = circular_mean(finite)
    if not np.isfinite(mean):
        reason = "the cycles' angles have no mean direction" if finite.size else "undefined in every cycle"
        return absent(unit, "; ".join(text for text in (note, reason) if text))
    return Measure(mean, unit, spread if finite.size > 1 else None, int(finite.size), note)


def per_cycle_angle(cycles: Cycles, values: Floats, unit: str = "rad", note: str = "") -> Measure:
    """Mean direction over cycles, or no value and the reason why there are no cycles."""
    return average_angle(values, unit, note) if cycles.count else absent(unit, cycles.note)


def cycle_frequency(cycles: Cycles, unit: str, note: str = "") -> Measure:
    """Number of cycles over their time, c / (t_c - t_0); its spread is the standard deviation of 1 / T."""
    if not cycles.count:
        return absent(unit, cycles.note)
    spread = float(np.std(1.0 / cycles.periods, ddof=1)) if cycles.count > 1 else None
    return Measure(cycles.frequency, unit, spread, cycles.count, note)
