"""Whether light from one side makes left and right of a voice look uneven.

A lamp to one side leaves the fold beside it in shade, whose steep medial surface then counts as glottis where
the outline is drawn halfway from the dark of the glottis to the tissue. The darkest part of the glottis has
little of that shade: left and right are measured by it. Where they come out otherwise by the outline at a
half, the light is uneven, and what is left of it in the darkest part, some third of the difference, is said.
The limits were chosen on films of two runs, and judged on those of two others (docs/verification/video.md,
"One lamp").
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from plica.measures.measure import Measure

__all__ = ["is_shaded", "shaded"]

_UNEVEN = 0.03  # amplitude asymmetry
_LATE = 0.035  # rad
_SAID = "light from one side"
_COMPARED = ("amplitude_ratio", "amplitude_asymmetry", "left_right_phase", "area_asymmetry")


def shaded(found: Iterable[Measure], halfway: Iterable[Measure]) -> list[Measure]:
    """With a caution on what compares left and right, where the outline halfway tells otherwise.

    Parameters
    ----------
    found, halfway : Measures of both sides
        By the darkest part of the glottis; by the outline at a half.
    """
    items = list(found)
    values = {item.name: item.value for item in items}
    other = {item.name: item.value for item in halfway}
    uneven = _apart(values["amplitude_asymmetry"], other["amplitude_asymmetry"])
    late = abs(np.angle(np.exp(1j * _apart(values["left_right_phase"], other["left_right_phase"]))))
    if not (abs(uneven) > _UNEVEN or late > _LATE):
        return items
    said = (
        f"{_SAID}: with the outline drawn halfway to the tissue the amplitude asymmetry would be "
        f"{uneven:+.2g} off and the phase by {np.degrees(late):.2g} degrees; a third of that may be left in "
        "these. Take an asymmetry of this size for the lamp's, or film with the light from straight above"
    )
    return [
        replace(item, cautions=(*item.cautions, said))
        if item.name in _COMPARED and item.value is not None
        else item
        for item in items
    ]


def is_shaded(measures: Iterable[Measure]) -> bool:
    """Whether one of them has that caution."""
    return any(said.startswith(_SAID) for item in measures for said in item.cautions)


def _apart(value: float | None, other: float | None) -> float:
    """How far the other is off; 0 where one of them is not known."""
    return 0.0 if value is None or other is None else other - value
