"""What an error of the midline makes of the phase between the folds.

Where the midline is off by e, one edge seems farther from it by e and the other nearer, as long as the
glottis is open there: folds that do not part together exchange some of their motion, and the phase between
them comes out nearer to 0 or farther from it. Folds that move alike lose nothing.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from plica.measures.circular import principal
from plica.measures.cycles import Cycles
from plica.measures.measure import Measure, per_cycle_angle
from plica.measures.sides import lags
from plica.video.glottis.glottal_area import GlottalArea

__all__ = ["with_midline_error"]

Floats = npt.NDArray[np.float64]

_OFF = 1 / 3  # px, to which the midline is found (docs/verification/video.md, "Noise and blur")
_SEED = 20214


def with_midline_error(item: Measure, area: GlottalArea, cycles: Cycles, time: npt.NDArray[Any]) -> Measure:
    """The left-right phase of these edges with an interval that has midlines a third of a pixel to either
    side."""
    if item.value is None or item.replicates is None:
        return item
    opened = np.clip(area.left_edge + area.right_edge, 0.0, 1.0)
    turns = [0.0]
    for off in (-_OFF, _OFF):
        edges = area.left_edge - off * opened, area.right_edge + off * opened
        moved = per_cycle_angle(item.name, cycles, lags(time, *edges, cycles)).value
        turns += [] if moved is None else [principal(moved - item.value)]
    drawn = np.random.default_rng(_SEED).uniform(min(turns), max(turns), item.replicates.values.size)
    return replace(item, replicates=item.replicates.mapped(lambda values: values + drawn))
