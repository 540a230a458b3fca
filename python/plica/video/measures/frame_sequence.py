"""Frames that are missing from a recording, or there twice, by how the folds move.

A voice repeats itself: after two frames that look like two of another cycle comes one that looks like the
one after those. With x_t the widths of the slit along the folds in frame t, s the frames of other cycles
whose (x_{s-1}, x_s) are nearest to (x_{t-1}, x_t), and x'_k the median of x_{s+k} over them, a frame is
*missing* after t where x_{t+1} and x_{t+2} are far nearer to x'_2 and x'_3 than to x'_1 and x'_2, and t + 1
is t *repeated* where they are far nearer to x_t and x'_1; both where the folds move by more than what is
otherwise left of the prediction, and where the x_{s+1} agree (they do not while the folds touch), and x_t
and x_{t+3} are as expected (they are not in a cycle that is all faster). Of the rest of the time nothing is
seen: there are as many more as it is longer.

Each lost frame makes its cycle shorter by a whole one, each that is there twice longer, which no voice
does: with periods T in frames, R = |mean of exp(2 pi i T)| is 1 then, and about 1 / sqrt(cycles) of a voice
whose periods scatter by half a frame or more.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt

__all__ = ["FrameSequence", "frame_sequence"]

Floats = npt.NDArray[np.float64]

_NEIGHBOURS = 5
_CLEARLY = 0.4  # of the other distance
_MOVES = 2.0  # times the median of what is left of the prediction
_AGREE = 3.0  # times the scatter of what follows elsewhere
_ALIKE, _CYCLES, _DIFFER = 0.8, 6, 0.3  # R, cycles, and standard deviation (frames), from which it is told
_LEAST = 0.4  # px, root mean square over the widths: less motion shows nothing
_SHARE = 0.02  # of the frames; of fewer nothing is said
_SHOWN = 6  # frames that are named


@dataclass(frozen=True)
class FrameSequence:
    """What is wrong with the sequence of the frames.

    Attributes
    ----------
    missing : (k) int
        Frames after which one is missing.
    repeated : (k) int
        Frames that show the one before them.
    whole_frames : float
        By how much periods differ (standard deviation, frames), where they do by whole frames; else 0.
    count : int
        Of frames.
    """

    missing: npt.NDArray[np.int_]
    repeated: npt.NDArray[np.int_]
    whole_frames: float
    count: int

    def doubts(self) -> list[str]:
        """A sentence for each, if there are enough of them."""
        found = []
        least = max(5.0, _SHARE * self.count)
        for frames, said, made in (
            (self.missing, "missing: the folds jump two frames ahead after", "higher"),
            (self.repeated, "there twice: the folds stand still in", "lower"),
        ):
            if frames.size < least:
                continue
            shown = ", ".join(map(str, frames[:_SHOWN].tolist())) + (", ..." if frames.size > _SHOWN else "")
            share = 100 * frames.size / self.count
            found.append(
                f"{frames.size} or more of {self.count} frames are {said} {shown}. So the frequency is at "
                f"least {share:.2g} % {made} than it was, and jitter, shimmer and quotients are not those of "
                "the voice. Take the recording from the camera once more, with all frames"
            )
        if self.whole_frames and not found:
            found.append(
                f"the cycles differ by whole frames (standard deviation {self.whole_frames:.2g} frames), as "
                "no voice's do: frames are missing, or there twice, so that frequency, jitter, shimmer and "
                "quotients are not those of the voice. Take it from the camera again, with all frames"
            )
        return found


def frame_sequence(width: Floats, periods: npt.NDArray[np.floating]) -> FrameSequence:
    """What is wrong with the frames.

    Parameters
    ----------
    width : (places, frames) px
        Of the slit; not a number where it is not known.
    periods : (cycles)
        Frames; with fewer than three nothing is found.
    """
    count = width.shape[1]
    period, whole = float(np.median(periods)) if periods.size else float("nan"), _whole_frames(periods)
    nothing = FrameSequence(np.zeros(0, dtype=int), np.zeros(0, dtype=int), whole, count)
    if not np.isfinite(period) or count < 3 * period:
        return nothing
    x = width.T
    known = np.asarray(np.isfinite(x).all(axis=1))
    x = np.where(known[:, None], x, 0.0)
    t = np.arange(1, count - 3)
    t = t[np.all([known[t + k] for k in range(-1, 4)], axis=0)]
    if t.size <= 2 * _NEIGHBOURS:
        return nothing
    pairs = np.concatenate([x[t - 1], x[t]], axis=1)
    square = np.sum(pairs**2, axis=1)
    expected = np.empty((4, t.size, x.shape[1]))
    expected[0], scatter = x[t], np.empty(t.size)
    for k, frame in enumerate(t):
        apart = square - 2 * pairs @ pairs[k]
        apart[np.abs(t - frame) < period / 2] = np.inf
        nearest = t[np.argsort(apart)[:_NEIGHBOURS]]
        expected[1:, k] = [np.median(x[nearest + later], axis=0) for later in (1, 2, 3)]
        scatter[k] = np.sqrt(np.mean(np.square(x[nearest + 1] - expected[1, k])))
    off = [
        _size(x[t + 1] - one, x[t + 2] - two) for one, two in pairwise(expected)
    ]  # twice, as it is, missing
    steps = np.diff(expected, axis=0)
    moves = [_size(one, other) for one, other in pairwise(steps)]
    limit = max(_LEAST, _MOVES * float(np.median(off[1])))
    unlike = (off[1] > limit / 2) & (off[1] > _AGREE * scatter) & _alone(t, x[t + 1] - expected[1])
    missing = t[(moves[1] > limit) & unlike & (off[2] < _CLEARLY * off[1])]
    repeated = t[(moves[0] > limit) & unlike & (off[0] < _CLEARLY * off[1])] + 1
    return FrameSequence(missing, repeated, whole, count)


def _alone(t: npt.NDArray[np.int_], left: Floats) -> npt.NDArray[np.bool_]:
    """(k) whether what is left of the prediction (k, n) in these frames t is large there alone, and not in
    the frame before and the second one after it, as it is in a cycle that is all faster."""
    size = np.sqrt(np.mean(np.square(left), axis=1))
    of_frame = dict(zip(t.tolist(), size.tolist(), strict=True))
    beside = [max(of_frame.get(frame - 1, 0.0), of_frame.get(frame + 2, 0.0)) for frame in t.tolist()]
    return np.asarray(np.array(beside) < _CLEARLY * size)


def _whole_frames(periods: npt.NDArray[np.floating]) -> float:
    """Standard deviation of periods that differ by whole frames; 0 of others."""
    if periods.size < _CYCLES or not np.std(periods) > _DIFFER:
        return 0.0
    alike = abs(np.mean(np.exp(2j * np.pi * periods)))
    return float(np.std(periods)) if alike > _ALIKE else 0.0


def _size(one: Floats, other: Floats) -> Floats:
    """(k) root mean square of the rows of both (k, n)."""
    return np.asarray(np.sqrt((np.mean(np.square(one), axis=1) + np.mean(np.square(other), axis=1)) / 2))
