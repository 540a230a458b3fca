"""Units of a record, and units in reports."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

__all__ = ["SI", "Scale", "shown_unit"]

# Unit in reports: factor from the SI unit.
_FACTORS = {
    "mm": 1e3,
    "um": 1e6,
    "mm^2": 1e6,
    "mm^3": 1e9,
    "ml/s": 1e6,
    "l/s^2": 1e3,
    "ms": 1e3,
    "us": 1e6,
    "kPa": 1e-3,
    "mN": 1e3,
    "uN": 1e6,
    "uN s": 1e6,
    "uJ": 1e6,
    "deg": 180 / math.pi,
}
# SI unit: usual unit in reports.
_USUAL = {
    "m": "mm",
    "m^2": "mm^2",
    "m^3": "mm^3",
    "m^3/s": "ml/s",
    "m^3/s^2": "l/s^2",
    "s": "ms",
    "Pa": "kPa",
    "N": "mN",
    "N s": "uN s",
    "J": "uJ",
    "rad": "deg",
}


@dataclass(frozen=True)
class Scale:
    """Units of lengths and times of a record: pixels and frames if their size is unknown."""

    length: Literal["m", "px"] = "m"
    time: Literal["s", "frames"] = "s"

    def unit(self, si: str) -> str:
        """The unit in this record of a quantity with the SI unit `si`."""
        lengths = {} if self.length == "m" else {"m": "px", "m^2": "px^2"}
        times = {} if self.time == "s" else {"s": "frames", "Hz": "1/frame", "1/s": "1/frame"}
        if si == "m/s":
            return f"{self.length}/{'s' if self.time == 's' else 'frame'}"
        return (lengths | times).get(si, si)


SI = Scale()


def shown_unit(unit: str, chosen: str = "") -> tuple[float, str]:
    """Factor to the unit in reports, and that unit; px, frames, Hz and pure numbers are unchanged."""
    shown = chosen or _USUAL.get(unit, unit)
    return _FACTORS.get(shown, 1.0), shown
