"""Whether light from one side makes left and right of a voice look uneven.

A lamp to one side leaves the fold beside it in shade, whose steep medial surface then counts as glottis where
the outline is drawn halfway from the dark of the glottis to the tissue. Its darkest part has little of that
shade, but loses slits to the lens' blur. So left and right are those of the outline halfway, unless they come
out otherwise by the darkest part, or the band between the outlines is wider than a lens makes it: then they
are those of the darkest part, and where both differ that is said. A third of the difference may be left. The
limits were chosen on films of two runs and judged on those of two others (docs/verification/video.md, "One
lamp").
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from plica.measures.measure import Measure

__all__ = ["by_light", "is_shaded", "is_wide"]

Floats = npt.NDArray[np.float64]

_WIDE = 0.5  # of the area: films without shade have a narrower band, with shade a wider one
_UNEVEN = 0.03  # amplitude asymmetry
_LATE = 0.045  # rad
_SAID = "light from one side"
_COMPARED = ("amplitude_ratio", "amplitude_asymmetry", "left_right_phase", "area_asymmetry")


def by_light(halfway: list[Measure], inner: list[Measure], *, wide: bool) -> list[Measure]:
    """Those of the outline halfway, or of the darkest part of the glottis where shade moves the outline.

    Parameters
    ----------
    halfway, inner : Measures of both sides
    wide : bool
        Whether the area's band tells of shade.
    """
    one, other = ({item.name: item.value for item in items} for items in (inner, halfway))
    uneven = _apart(one["amplitude_asymmetry"], other["amplitude_asymmetry"])
    late = abs(float(np.angle(np.exp(1j * _apart(one["left_right_phase"], other["left_right_phase"])))))
    if not (abs(uneven) > _UNEVEN or late > _LATE):
        return inner if wide else halfway
    said = (
        f"{_SAID}: with the outline drawn halfway to the tissue the amplitude asymmetry would be "
        f"{uneven:+.2g} off and the phase by {np.degrees(late):.2g} degrees; a third of that may be left in "
        "these. Take an asymmetry of this size for the lamp's, or film with the light from straight above"
    )
    return [
        replace(item, cautions=(*item.cautions, said))
        if item.name in _COMPARED and item.value is not None
        else item
        for item in inner
    ]


def is_shaded(measures: Iterable[Measure]) -> bool:
    """Whether one of them has that caution."""
    return any(said.startswith(_SAID) for item in measures for said in item.cautions)


def is_wide(total: Floats, band: tuple[Floats, Floats]) -> bool:
    """Whether the band of the glottal area, (frames) each, tells of shade beside the folds."""
    mean = float(np.nanmean(total)) if np.isfinite(total).any() else 0.0
    return mean > 0 and float(np.nanmean(band[1] - band[0])) > _WIDE * mean


def _apart(value: float | None, other: float | None) -> float:
    """How far the other is off; 0 where one of them is not known."""
    return 0.0 if value is None or other is None else other - value
