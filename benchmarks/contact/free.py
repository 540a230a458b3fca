"""What free bodies keep through collisions (R10), for every way to enforce contact.

`box`     a body that rattles in a frame, over as many steps as asked for (box.py)
`blocks`  two blocks without any support that turn and meet askew, once
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from benchmarks.contact.box import Box
from plica.errors import InvalidInput, SolveFailed
from plica.verify.bodies.blocks import blocks, kept, penalised
from plica.verify.bodies.body import mass_columns
from plica.verify.bodies.combinations import Combination

__all__ = ["COLUMNS", "PROBLEMS", "box", "rows"]

COLUMNS = (
    "steps",
    "collisions",
    "momentum",
    "angular, free",
    "angular, balance",
    "angular, change",
    "force sum",
    "gain",
    "energy balance",
    "penetration",
    "s",
    "ms/step",
)
PROBLEMS = ("box", "blocks")
CHUNK = 50
"""Steps between two looks at the momentum."""

Array = NDArray[np.float64]
Row = dict[str, object]


def box(combination: Combination, steps: int, tolerance: float) -> dict[str, float | int]:
    """The box over so many steps. Momentum is over the body's at the start."""
    scene = Box()
    simulation = scene.simulation(*penalised(combination), tolerance)
    weights = mass_columns(simulation)
    waves: dict[str, list[Array]] = {}
    momentum, done = 0.0, 0
    start = time.process_time()
    while done < steps:
        part = simulation.advance(min(CHUNK, steps - done))
        done += len(part["time"])
        for name, values in part.items():
            waves.setdefault(name, []).append(values)
        momentum = max(momentum, abs(float(weights @ np.ravel(simulation.velocity))))
    seconds = time.process_time() - start
    result = {name: np.concatenate(values) for name, values in waves.items()}
    return {
        "steps": steps,
        "momentum": momentum / scene.momentum,
        **kept(simulation, result),
        "s": seconds,
        "ms/step": 1e3 * seconds / steps,
    }


def rows(names: Sequence[str], asked: Sequence[Combination], steps: int, tolerance: float) -> Iterator[Row]:
    """A row for each run as it is done; one that fails has its message under "failure"."""
    for name in names:
        for combination in asked:
            row: Row = {"problem": name} | vars(combination)
            try:
                found = (
                    box(combination, steps, tolerance) if name == "box" else blocks(combination, tolerance)
                )
            except (InvalidInput, SolveFailed) as failure:
                yield row | {"failure": str(failure).splitlines()[0]}
            else:
                yield row | found
