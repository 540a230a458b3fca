"""Folds that move as a formula says, to be filmed: a larynx's mesh with displacements that no engine made."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

import plica

Floats = NDArray[np.float64]
Move = Callable[[Floats, float], Floats]
"""Displacement (n, 3) m of points (n, 3) at rest at a time, s."""

PIXEL = 0.06e-3  # m


@dataclass(frozen=True)
class FilmedFolds:
    """What `plica.film` needs of a run."""

    mesh: Any
    fields: dict[str, Any] = field(default_factory=dict)


@cache
def folds(order: int = 2) -> Any:
    """The mesh of the coarse larynx."""
    return plica.build_mesh(plica.Larynx(larynx="coarse", order=order))


def moved(move: Move, times: Any, mesh: Any = None) -> FilmedFolds:
    """Folds at these stored instants (s)."""
    mesh = mesh or folds()
    rest = np.asarray(mesh.points)
    displacement = np.array([move(rest, t) for t in times])
    return FilmedFolds(mesh, {"time": np.asarray(times, dtype=float), "displacement": displacement})


def shifted(x: float = 0.0, y: float = 0.0, z: float = 0.0) -> Move:
    """All of it, by so much (m) a millisecond."""
    return lambda rest, t: np.broadcast_to(1e3 * t * np.array([x, y, z]), rest.shape).copy()


def voiced(frequency: float = 200.0, amplitude: float = 0.35e-3, lag: float = 0.8) -> Move:
    """Both folds swing apart, the upper edge late by `lag` (rad); the wall stands still."""

    def move(rest: Floats, t: float) -> Floats:
        x, y, z = rest.T
        along = np.clip(1 - (y / 7e-3) ** 2, 0.0, None)
        depth = np.clip((np.abs(x) - 0.25e-3) / 5e-3, 0.0, 1.0)
        height = np.exp(-(((z + 1.5e-3) / 3e-3) ** 2))
        late = lag * np.clip((z + 3.1e-3) / 2.7e-3, 0.0, 1.2)
        share = along * (1 - depth) ** 2 * height
        swing = np.sin(2 * np.pi * frequency * t - late)
        found = np.zeros_like(rest)
        found[:, 0] = np.sign(x) * amplitude * share * (0.6 + swing)
        found[:, 2] = 0.5 * amplitude * share * np.cos(2 * np.pi * frequency * t - late)
        return found

    return move
