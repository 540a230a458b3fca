"""What is said of measures with the slits that blur hides from the outline.

A measure is that of the outline with what darkness adds to it (:mod:`.hidden_slits`), which a note tells; how
well that is known is in its interval (:mod:`.error_model`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from plica.measures.circular import principal
from plica.measures.cycles import Cycles
from plica.measures.measure import Measure
from plica.measures.scale import SI, Scale
from plica.video.glottis.hidden_slits import closure

__all__ = ["differs", "noted", "open_besides"]

Floats = npt.NDArray[np.float64]

_NOTED = 0.01  # of the value: what slits add is in the note
_UNDER = float(
    np.arccos(1 - 2 * closure) / np.pi
)  # of a cycle, that a sine is below that share of its height


def open_besides(total: Floats, most: Floats, cycles: Cycles, time: npt.NDArray[Any]) -> str:
    """That folds which seem closed may leave a slit which is hidden all the time.

    Empty where they stay closed for long, as only contact does.

    Parameters
    ----------
    total : (frames)
        Area, with the hidden slits that come and go.
    most : (frames)
        What may be open besides; in its unit.
    cycles : Cycles
    time : (frames)
    """
    part = cycles.extent(time)
    if not cycles.count or not most[part].any():
        return ""
    closed = float(np.mean(total[part] < closure * total[part].max()))
    if closed >= 2 * _UNDER:
        return ""
    if closed == 0:
        return (
            "the folds are never seen to close, and blur may hide a part of the gap all the time: the "
            "interval has it"
        )
    return (
        f"the folds seem closed for {100 * closed:.2g} % of the time, too little to tell closure from a slit "
        "that blur hides all the time: the interval has both"
    )


def noted(counted: Sequence[Measure], outlined: Sequence[Measure], scale: Scale = SI) -> list[Measure]:
    """The measures with hidden slits counted, each with a note where they add over a hundredth.

    Parameters
    ----------
    counted, outlined : as many Measures each
        With hidden slits, and by the outline alone.
    scale : Scale
        The units of their record.
    """
    return [_noted(item, bare, scale) for item, bare in zip(counted, outlined, strict=True)]


def _noted(item: Measure, bare: Measure, scale: Scale) -> Measure:
    if not differs(item, bare):
        return item
    factor, unit = item.quantity.people(scale)
    without = f"{factor * (bare.value or 0.0):.3g} {'' if unit == '1' else unit}".rstrip()
    by_outline = f"with slits that blur hides from the outline, by their darkness; without them {without}"
    return replace(item, note="; ".join(filter(None, (item.note, by_outline))))


def differs(item: Measure, other: Measure) -> bool:
    """Whether both have a value and the other is over a hundredth off; angles modulo 2 pi."""
    if item.value is None or other.value is None:
        return False
    off = item.value - other.value
    return abs(principal(off) if item.quantity.angle else off) > _NOTED * abs(item.value)
