"""The trapezoidal rule written out, for matrices of any maker and any way to solve."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["trapezoidal"]

Array = NDArray[np.float64]


def trapezoidal(
    mass: Any,
    stiffness: Any,
    solver: Callable[[Any], Callable[[Array], Array]],
    start: Array,
    step: float,
    steps: int,
) -> tuple[Array, Array]:
    """Displacement and velocity after so many steps of free motion from `start` (n,) at rest.

    `solver` makes of a matrix what solves with it: of M for the first acceleration and of M + h^2 / 4 K.
    """
    u, v = start.copy(), np.zeros_like(start)
    a = solver(mass)(-(stiffness @ u))
    solve = solver((mass + 0.25 * step**2 * stiffness).tocsc())
    for _ in range(steps):
        ahead = u + step * v + 0.25 * step**2 * a
        new = solve(-(stiffness @ ahead))
        u = ahead + 0.25 * step**2 * new
        v = v + 0.5 * step * (a + new)
        a = new
    return u, v
