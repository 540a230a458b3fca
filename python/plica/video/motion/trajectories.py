"""Paths of material points through a recording, from the flow of each frame to the next."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from plica.measures.cycles import Cycles
from plica.video.errors import VideoError

__all__ = ["Paths", "follow", "spacing"]

Floats = npt.NDArray[np.float64]

spacing = 12
"""px between the points that an analysis follows."""


@dataclass(frozen=True)
class Paths:
    """Paths of p points over the frames.

    Attributes
    ----------
    places : (frames, p, 2) px
        x and y; NaN from where a point leaves the frame.
    """

    places: Floats

    def closing_error(self, cycles: Cycles, time: Floats) -> Floats:
        """(p) px, median over the cycles of the distance between a point's places one period apart.

        A point that comes back closes its path; what is left is drift of the flow, or motion that is not
        periodic. Places between frames are interpolated linearly. NaN without cycles.
        """
        if not cycles.count:
            return np.full(self.places.shape[1], np.nan)
        steps = np.clip(np.searchsorted(time, cycles.starts, side="right") - 1, 0, time.size - 2)
        share = (cycles.starts - time[steps]) / (time[steps + 1] - time[steps])
        share = share[:, None, None]
        at = (1 - share) * self.places[steps] + share * self.places[steps + 1]
        gaps = np.linalg.norm(np.diff(at, axis=0), axis=-1)
        found = np.full(gaps.shape[1], np.nan)
        whole = np.isfinite(gaps).any(axis=0)  # a point that leaves at once has no cycle
        found[whole] = np.nanmedian(gaps[:, whole], axis=0)
        return found


def follow(flows: Iterable[npt.NDArray[np.floating]], points: Floats) -> Paths:
    """Carry points along: x(t + 1) = x(t) + u(x(t), t), the flow interpolated bilinearly.

    Parameters
    ----------
    flows : (h, w, 2) px each
        From each frame to the next.
    points : (p, 2) px
        x and y in the first frame.
    """
    from scipy import ndimage

    places = [np.asarray(points, dtype=float).copy()]
    if places[0].ndim != 2 or places[0].shape[1] != 2:
        raise VideoError(f"Trajectories: points have shape {places[0].shape}; must be (points, 2).")
    for flow in flows:
        here = places[-1]
        inside = np.isfinite(here[:, 0])
        move = np.full(here.shape, np.nan)
        for c in (0, 1):
            move[inside, c] = ndimage.map_coordinates(
                flow[..., c], [here[inside, 1], here[inside, 0]], order=1, mode="nearest"
            )
        there = here + move
        there[~np.all((there >= 0) & (there <= [flow.shape[1] - 1, flow.shape[0] - 1]), axis=1)] = np.nan
        places.append(there)
    return Paths(np.stack(places))
