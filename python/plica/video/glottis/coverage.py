"""How much of each pixel at the border of a glottis it covers.

An outline at a level of grey runs between pixels: along an image's row it is where brightness, linear from
pixel to pixel, crosses the level. A pixel is then covered as far as the outline reaches into it, so that
edges and areas are not rounded to pixels. Above and below, where slits end, pixels are whole.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

__all__ = ["coverage", "from_stored", "to_stored"]

Floats = npt.NDArray[np.floating]
Mask = npt.NDArray[np.bool_]

_STEPS = 200  # of a stored coverage: a pixel that is covered by half or more is one of the mask
_WHOLE = 0.495  # of a pixel beyond the half of the mask's last one, at most


def coverage(mask: Mask, below: Floats) -> npt.NDArray[np.float64]:
    """(h, w) in [0, 1], a half or more in the mask and less elsewhere.

    Parameters
    ----------
    mask : (h, w) bool
    below : (h, w)
        Brightness less the level of the outline: below 0 in the mask's last pixels, above beside them; where
        it is not, or is not finite, the outline runs halfway between two pixels.
    """
    found = mask.astype(float)
    change = np.zeros_like(found)
    for inner, outer in (
        ((slice(None), slice(1, None)), (slice(None), slice(None, -1))),
        ((slice(None), slice(None, -1)), (slice(None), slice(1, None))),
    ):
        ends = mask[inner] & ~mask[outer]
        inside, outside = below[inner][ends], below[outer][ends]
        crosses = (inside < 0) & (outside > 0) & np.isfinite(outside)
        reach = np.full(inside.size, 0.5)  # px, from the middle of the last pixel outwards
        reach[crosses] = -inside[crosses] / (outside[crosses] - inside[crosses])
        change[inner][ends] -= np.clip(0.5 - reach, 0.0, 0.5)
        change[outer][ends] += np.clip(reach - 0.5, 0.0, _WHOLE)
    found += change
    return np.asarray(np.where(mask, np.clip(found, 0.5, 1.0), np.clip(found, 0.0, _WHOLE)))


def to_stored(covered: Floats | Mask) -> npt.NDArray[np.uint8]:
    """As a file has it: in 1/200."""
    return np.round(_STEPS * np.asarray(covered, dtype=float)).astype(np.uint8)


def from_stored(values: npt.NDArray[np.uint8]) -> npt.NDArray[np.float64]:
    """The inverse of :func:`to_stored`."""
    return np.asarray(values, dtype=float) / _STEPS
