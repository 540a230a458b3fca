"""The units that a record is in, and those in which people read it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

__all__ = ["SI", "Scale", "shown_unit"]

# Unit in which people read a quantity: how many of it are one SI unit.
_FACTORS = {
    "mm": 1e3,
    "um": 1e6,
    "mm^2": 1e6,
    "mm^3": 1e9,
    "ml/s": 1e6,
    "ms": 1e3,
    "us": 1e6,
    "kPa": 1e-3,
    "mN": 1e3,
    "uN": 1e6,
    "uN s": 1e6,
    "uJ": 1e6,
    "deg": 180 / math.pi,
}
# SI unit: the one that people read, where the quantity does not say another.
_USUAL = {
    "m": "mm",
    "m^2": "mm^2",
    "m^3": "mm^3",
    "m^3/s": "ml/s",
    "s": "ms",
    "Pa": "kPa",
    "N": "mN",
    "N s": "uN s",
    "J": "uJ",
    "rad": "deg",
}


@dataclass(frozen=True)
class Scale:
    """What lengths and times of a record are in: pixels and frames where their size is not known."""

    length: Literal["m", "px"] = "m"
    time: Literal["s", "frames"] = "s"

    def unit(self, si: str) -> str:
        """The unit, in this record, of what is in `si` where the scale is known."""
        lengths = {} if self.length == "m" else {"m": "px", "m^2": "px^2"}
        times = {} if self.time == "s" else {"s": "frames", "Hz": "1/frame", "1/s": "1/frame"}
        if si == "m/s":
            return f"{self.length}/{'s' if self.time == 's' else 'frame'}"
        return (lengths | times).get(si, si)


SI = Scale()


def shown_unit(unit: str, chosen: str = "") -> tuple[float, str]:
    """Factor and unit in which people read what is in `unit`; px, frames, Hz and numbers stay as they are."""
    shown = chosen or _USUAL.get(unit, unit)
    return _FACTORS.get(shown, 1.0), shown
