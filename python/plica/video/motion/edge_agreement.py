"""Consistency check of the flow: how far the folds' edges move by the masks of the glottis."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from plica.video.glottis.glottal_area import GlottalArea, middle
from plica.video.glottis.midline import Midline, pixels

__all__ = ["EdgeAgreement", "edge_agreement"]

Mask = npt.NDArray[np.bool_]

_NEAR = 8  # px from the edge
_FEWEST = 6  # ways


@dataclass(frozen=True)
class EdgeAgreement:
    """The flow of the tissue beside the folds' edges, across the midline, against the way of these edges.

    Attributes
    ----------
    slope : float
        Flow over way, by least squares through the origin; not a number with fewer than six ways. Tissue
        moves less than the edge the farther away it is, so that the true flow has a slope somewhat below 1;
        far below, the flow does not follow the folds.
    correlation : float
    count : int
        Ways: of an edge from one frame to the next, the glottis being open there in both.
    """

    slope: float
    correlation: float
    count: int


def edge_agreement(
    flows: Iterable[npt.NDArray[np.floating]], glottis: Iterable[Mask], area: GlottalArea, midline: Midline
) -> EdgeAgreement:
    """Compare the flows (h, w, 2) with the edges in the middle tenth of the midline, within 8 px of them."""
    from scipy import ndimage

    band: Mask | None = None
    opened = area.opened
    ways, moved = [], []
    for k, (flow, (before, _)) in enumerate(zip(flows, pairwise(glottis), strict=True)):
        if band is None:
            place = midline.place(pixels(before.shape))
            band, right = middle(place, midline), place[..., 1] > 0
        near = ndimage.binary_dilation(before, iterations=_NEAR) & ~before & band
        for edge, half, sign in ((area.left_edge, ~right, -1.0), (area.right_edge, right, 1.0)):
            beside = near & half
            if opened[k] and opened[k + 1] and beside.any():
                ways.append(sign * (edge[k + 1] - edge[k]))
                moved.append(float((flow[beside] @ midline.across).mean()))
    x, y = np.array(ways), np.array(moved)
    if x.size < _FEWEST or not (x.std() > 0 and y.std() > 0):
        return EdgeAgreement(float("nan"), float("nan"), x.size)
    return EdgeAgreement(float(x @ y / (x @ x)), float(np.corrcoef(x, y)[0, 1]), x.size)
