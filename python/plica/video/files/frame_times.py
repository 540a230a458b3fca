"""Times of frames, where a file states one for each."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from plica.video.errors import VideoError

__all__ = ["even_step"]

_SAME_STEP = 0.1  # of the median step, by which the frames' times may go otherwise


def even_step(name: str, times: npt.NDArray[np.float64]) -> float | None:
    """s between frames, of their times (n) in s; None where these do not tell.

    Raises
    ------
    VideoError
        Where the frames of the recording `name` are not equally spaced, to 10 %.
    """
    steps = np.diff(times)
    if not steps.any():
        return None
    usual = float(np.median(steps))
    gaps = np.flatnonzero(np.abs(steps - usual) > _SAME_STEP * abs(usual))
    if gaps.size:
        k = int(gaps[0])
        more = f" (and {gaps.size - 1} more such gaps)" if gaps.size > 1 else ""
        raise VideoError(
            f"Recording: {name}: from frame {k}, at {times[k] - times[0]:.6g} s, to frame {k + 1} "
            f"there are {steps[k]:.4g} s{more}; must be {usual:.4g} s as between the others, to 10 %. "
            f"Cut the recording at the gap: store the frames up to {k}, and those from {k + 1} on, in "
            "files of their own."
        )
    return usual if usual > 0 else None
