"""Measures with the slits that blur hides from the outline: their values, and what that leaves open.

A measure is that of the outline with what darkness adds to it (:mod:`.hidden_slits`). How dark the line
is in which the folds meet, and how bright the tissue that has left it, is known to a part of the addition
only; and a crease between folds that have closed darkens the line as a slit does. So the interval has an
error drawn evenly from all of what was added down to half of it up.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from plica.measures.cycles import Cycles
from plica.measures.interval import coverage
from plica.measures.measure import Measure
from plica.measures.scale import SI, Scale
from plica.video.glottis.hidden_slits import closure

__all__ = ["open_besides", "with_hidden_slits", "with_open_slits"]

Floats = npt.NDArray[np.float64]

_SEED = 20213
_ADDED = (-1.0, 0.5)  # of what was added, about the measure with it; chosen on films, judged on others
_NOT_ADDED = (-0.5, 1.5)  # of the same, about the measure by the outline
_NOTED = 0.01  # of the value: what slits add is in the note
_UNDER = float(
    np.arccos(1 - 2 * closure) / np.pi
)  # of a cycle, that a sine is below that share of its height


def with_hidden_slits(
    counted: Sequence[Measure], outlined: Sequence[Measure], *, shaded: bool = False, scale: Scale = SI
) -> list[Measure]:
    """The measures with hidden slits counted, each with an interval that has what they add, and a note.

    Where the line between the folds is `shaded`, the measures by the outline, with the same intervals.

    Parameters
    ----------
    counted, outlined : as many Measures each
        With hidden slits, and by the outline alone.
    scale : Scale
        The units of their record, for the note.
    """
    return [_counted(item, bare, shaded, scale) for item, bare in zip(counted, outlined, strict=True)]


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
    return (
        f"the folds seem closed for {100 * closed:.2g} % of the time, too little to tell closure from a slit "
        "that blur hides all the time: the interval has both"
    )


def with_open_slits(found: Sequence[Measure], opened: Sequence[Measure], caution: str) -> list[Measure]:
    """With intervals that have what slits which are hidden all the time make of each measure; a caution where
    that is over a hundredth.

    Parameters
    ----------
    found, opened : as many Measures each
        Without, and with the widest such slits.
    caution : str
        The caution.
    """
    widened = []
    for item, other in zip(found, opened, strict=True):
        if item.value is not None and other.value is not None and item.value != other.value:
            off = other.value - item.value
            if abs(off) > _NOTED * abs(item.value):
                item = replace(item, cautions=(*item.cautions, caution))
            item = _drawn(item, off, (0.0, 1.0))
        widened.append(item)
    return widened


def _counted(item: Measure, bare: Measure, shaded: bool, scale: Scale) -> Measure:
    if item.value is None or bare.value is None or item.value == bare.value:
        return bare if shaded else item
    added = item.value - bare.value
    if item.quantity.angle:
        added = float(np.angle(np.exp(1j * added)))
    if shaded:
        return _drawn(bare, added, _NOT_ADDED)
    if abs(added) > _NOTED * abs(item.value):
        factor, unit = item.quantity.people(scale)
        without = f"{factor * bare.value:.3g} {'' if unit == '1' else unit}".rstrip()
        by_outline = f"with slits that blur hides from the outline, by their darkness; without them {without}"
        item = replace(item, note="; ".join(filter(None, (item.note, by_outline))))
    return _drawn(item, added, _ADDED)


def _drawn(item: Measure, size: float, ends: tuple[float, float]) -> Measure:
    """With an error in its replicates of which 95 % lie between these ends, in `size`."""
    if item.replicates is None:
        return item
    random = np.random.default_rng([_SEED, *item.name.encode()])
    middle, half = (ends[0] + ends[1]) / 2, (ends[1] - ends[0]) / 2 / coverage
    error = size * (middle + half * random.uniform(-1, 1, item.replicates.values.size))
    return replace(item, replicates=item.replicates.mapped(lambda values: values + error))
