"""What a frame shows: tissue, glottis, highlights; and which pixels of a pair are used for motion.

A highlight is a mirror image of the lamp: it moves with the light and not with the tissue. It is a spot, in
which no disc of three pixels' radius has room; what is larger and as bright is tissue that is overexposed,
whose outline moves with it. The outline of the glottis is the strongest mark of motion that there is, so that
only its inside, dark and without texture, is left out (docs/verification/recorded_flow.md, "Without a
truth").
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from plica.video.files.recording import Grey

__all__ = ["Seen", "bright", "informing"]

Mask = npt.NDArray[np.bool_]

bright = 250.0
"""Grey from which a pixel is a highlight or overexposed."""
_SPOT = 3  # px, radius of the disc that has no room in a highlight
_MARGIN = 2  # px, reach of the derivatives


@dataclass(frozen=True)
class Seen:
    """A frame and its glottis; `lost` where it shows another thing than the recording."""

    frame: Grey
    glottis: Mask
    lost: bool = False

    @cached_property
    def highlights(self) -> Mask:
        """(h, w) and two pixels about them."""
        from scipy import ndimage

        y, x = np.ogrid[-_SPOT : _SPOT + 1, -_SPOT : _SPOT + 1]
        high = self.frame >= bright
        large = ndimage.binary_opening(high, x * x + y * y <= _SPOT**2)
        spots = high & ~ndimage.binary_propagation(large, mask=high)
        return np.asarray(ndimage.binary_dilation(spots, iterations=_MARGIN))

    @cached_property
    def tissue(self) -> Mask:
        """(h, w) neither glottis, nor two pixels about it, nor highlights."""
        from scipy import ndimage

        return np.asarray(~ndimage.binary_dilation(self.glottis, iterations=_MARGIN) & ~self.highlights)

    @cached_property
    def hollow(self) -> Mask:
        """(h, w) glottis, but for two pixels within its outline."""
        from scipy import ndimage

        return np.asarray(ndimage.binary_erosion(self.glottis, iterations=_MARGIN))


def informing(first: Seen, second: Seen) -> Mask:
    """(h, w) what is told to the data term: not the hollow of both, nor the highlights of either."""
    return ~((first.hollow & second.hollow) | first.highlights | second.highlights)
