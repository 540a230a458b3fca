"""Whether light from one side makes left and right of a voice look uneven.

A lamp to one side leaves the fold beside it in shade, whose steep medial surface then counts as glottis where
the outline is drawn halfway from the dark of the glottis to the tissue. Its darkest part has little of that
shade, but loses slits to the lens' blur. So left and right are those of the outline halfway, unless they come
out otherwise by the darkest part, or the band between the outlines is wider than a lens makes it: then they
are those of the darkest part, which is said, and by how much both differ. What one of the outlines does not
tell cannot be compared, which is said too. A lamp is named only where it has left its mark, tissue that is
brighter on one side of the midline. The limits were chosen on films of two runs and judged on those of
two others (docs/verification/video.md, "One lamp").

Half of the difference may be left in the darkest part, in any phase of the cycle: shade shows where the
medial surface is seen from above, so mostly as the folds close (:mod:`plica.video.measures.error_model`).
"""

from __future__ import annotations

from collections.abc import Collection, Iterable
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from plica.measures.catalogue import names
from plica.measures.measure import Measure

__all__ = ["by_light", "cautioned", "is_lateral", "is_shaded", "is_wide"]

Floats = npt.NDArray[np.float64]

_WIDE = 0.5  # of the area: films without shade have a narrower band, with shade a wider one
_UNEVEN = 0.03  # amplitude asymmetry
_LATE = 0.045  # rad
_UNLIKE = 0.08  # of the mean: tissue left and right of the midline is less unlike without a lamp to one side
_MOVED = "with the outline drawn halfway to the tissue"
_BY_DARKEST = "by the darkest part, as the outline is not sharp"
_COMPARED = names(side="ratio") | names(side="difference")


def by_light(
    halfway: list[Measure],
    inner: list[Measure],
    beside: Iterable[Measure],
    *,
    wide: bool,
    brightness: Floats | None = None,
) -> tuple[list[Measure], bool]:
    """Those of the outline halfway, or of the darkest part of the glottis where shade moves it; and which.

    Parameters
    ----------
    halfway, inner : Measures of both sides
    beside : Measures of both sides
        By the darkest part while the outline is open: where folds touch is no shade.
    wide : bool
        Whether the area's band tells of shade.
    brightness : (2) grey levels, optional
        Of the tissue left and right of the midline.
    """
    one, other = ({item.name: item.value for item in items} for items in (beside, halfway))
    uneven = _apart(one["amplitude_asymmetry"], other["amplitude_asymmetry"])
    turn = _apart(one["left_right_phase"], other["left_right_phase"])
    late = None if turn is None else abs(float(np.angle(np.exp(1j * turn))))
    off = []
    if uneven is not None:
        off.append(f"the amplitude asymmetry would be {uneven:+.2g} off")
    if late is not None:
        off.append(f"the phase would be {np.degrees(late):.2g} degrees off")
    moved = (uneven is not None and abs(uneven) > _UNEVEN) or (late is not None and late > _LATE)
    darkest = wide or moved
    found = inner if darkest else halfway
    if wide:
        found = cautioned(found, _BY_DARKEST)
    if moved:
        lamp = "; film with the light from straight above" if is_lateral(brightness) else ""
        found = cautioned(
            found,
            f"{'light from one side: ' if lamp else ''}{_MOVED} {' and '.join(off)}; half of that may be "
            f"left in these (the interval of the phase has it). So much asymmetry may be the outline's{lamp}",
            _COMPARED,
        )
    unknown = [name for name, apart in (("amplitude asymmetry", uneven), ("phase", late)) if apart is None]
    if unknown:
        found = cautioned(
            found,
            f"the {' and the '.join(unknown)} by the outline halfway to the tissue cannot be compared with "
            "that by the darkest part, as not both are known: what light makes of it is open",
            _COMPARED,
        )
    return found, darkest


def is_lateral(brightness: Floats | None) -> bool:
    """Whether tissue is so much brighter on one side of the midline; not where that is not known."""
    if brightness is None or not np.isfinite(brightness).all():
        return False
    return bool(np.ptp(brightness) > _UNLIKE * brightness.mean())


def is_shaded(measures: Iterable[Measure]) -> bool:
    """Whether one of them has the caution that its outline is not that of the darkest part."""
    return any(_MOVED in said for item in measures for said in item.cautions)


def is_wide(total: Floats, band: tuple[Floats, Floats], by_blur: Floats | None = None) -> bool:
    """Whether the band of the glottal area, (frames) each, tells of shade beside the folds: by how much it is
    wider than blur makes it, where that is known."""
    mean = float(np.nanmean(total)) if np.isfinite(total).any() else 0.0
    width = band[1] - band[0] if by_blur is None else band[1] - band[0] - by_blur
    return mean > 0 and float(np.nanmean(width)) > _WIDE * mean


def _apart(value: float | None, other: float | None) -> float | None:
    """How far the other is off; None where one of them is not known."""
    return None if value is None or other is None else other - value


def cautioned(found: list[Measure], said: str, of: Collection[str] = ()) -> list[Measure]:
    """With this caution on each that has a value, `of` these names or, without any, of all."""
    return [
        replace(item, cautions=(*item.cautions, said))
        if item.value is not None and (not of or item.name in of)
        else item
        for item in found
    ]
