"""Arrays as text in a page: quantised, differences from phase to phase, compressed, base64."""

from __future__ import annotations

import base64
import zlib
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plica.measures.record import Floats

__all__ = ["packed", "packed_levels", "packed_motion"]

_LEVELS_OF_MOTION = 32767  # 16 bits, with sign
_LEVELS_OF_COLOUR = 255


def packed(values: NDArray[Any]) -> str:
    """The bytes of an array, little-endian."""
    little = np.ascontiguousarray(values, dtype=values.dtype.newbyteorder("<"))
    return base64.b64encode(zlib.compress(little.tobytes(), 9)).decode()


def packed_motion(values: Floats) -> tuple[str, float]:
    """Displacements (p, ...) in 16 bits each, and what one level is worth, in their unit.

    Differences from the phase before (modulo 2^16; of the first phase from zero); first the low bytes of all,
    then the high ones, which are nearly all alike.
    """
    level = float(np.abs(values).max(initial=0.0)) / _LEVELS_OF_MOTION or 1.0
    steps = _differences(np.round(values / level).astype(np.int16).view(np.uint16))
    halves = np.stack((steps & 0xFF, steps >> 8)).astype(np.uint8)
    return packed(halves), level


def packed_levels(values: Floats) -> tuple[str, float]:
    """Numbers (p, n) >= 0 in 8 bits each, as `packed_motion`, and the largest, which is level 255."""
    largest = float(values.max(initial=0.0))
    levels = np.round(values * (_LEVELS_OF_COLOUR / largest if largest else 0.0)).astype(np.uint8)
    return packed(_differences(levels)), largest


def _differences(levels: NDArray[Any]) -> NDArray[Any]:
    """Unsigned, so that they wrap round."""
    found = levels.copy()
    found[1:] -= levels[:-1]
    return found
