"""A record: signals over equidistant times."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]
Floats = NDArray[np.floating[Any]]


def time_step(time: Floats) -> float:
    """The constant step (s) of a record; its first time if it has only one."""
    return float(time[-1] - time[0]) / (time.size - 1) if time.size > 1 else float(time[0])
