"""Frames that are missing from a recording, or there twice, by how the folds move.

A voice repeats itself: after two frames that look like two of another cycle comes one that looks like the
one after those. With x_t the widths of the slit along the folds in frame t, s the frames of other cycles
whose (x_{s-1}, x_s) are nearest to (x_{t-1}, x_t), and x'_k the median of x_{s+k} over them, a frame is
*missing* after t where x_{t+1} and x_{t+2} are far nearer to x'_2 and x'_3 than to x'_1 and x'_2, and t + 1
is t *repeated* where they are far nearer to x_t and x'_1; both where the folds move by more than what is
otherwise left of the prediction, and where the x_{s+1} agree (they do not while the folds touch), and x_t
and x_{t+3} are as expected (they are not in a cycle that is all faster). Of the rest of the time nothing is
seen: there are as many more as it is longer.

A frame that is lost makes its cycle shorter by a whole one, each that is there twice longer, which no voice
does. So what the motion shows counts where its cycle is shorter, or longer, than those in which it shows
nothing; and periods T (in frames) speak by themselves. About a common fraction c there is a commonest number
of whole frames; of the n periods that are not within 0.1 of it, k lie within 0.1 of another whole number
beside c, and p is the probability of k or more where fractions are as they come, the smallest over c.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import numpy.typing as npt
from scipy import special

from plica.measures.measure import Measure

__all__ = ["FrameSequence", "frame_sequence"]

Floats = npt.NDArray[np.float64]

_NEIGHBOURS = 5
_CLEARLY = 0.4  # of the other distance
_MOVES = 2.0  # times the median of what is left of the prediction
_AGREE = 3.0  # times the scatter of what follows elsewhere
_WHOLE = 0.1  # frames: periods differ by whole ones to within this
_CHANGED = 0.4  # frames, by which a cycle with a fault is shorter or longer than others
_CYCLES = 4  # fewer say nothing
_CERTAIN, _LIKELY = 0.005, 0.1  # p that speaks alone, and with a frame that the motion shows
_LEAST = 0.4  # px, root mean square over the widths: less motion shows nothing
_SHOWN = 6  # frames that are named
_IRREGULAR, _UNSURE = 0.02, 0.3  # of a period, and frames: less does not hide lost frames


@dataclass(frozen=True)
class FrameSequence:
    """What is wrong with the sequence of the frames.

    Attributes
    ----------
    missing : (k) int
        Frames after which one is missing, by the motion and by the length of the cycle.
    repeated : (k) int
        Frames that show the one before them, by both.
    chance : float
        Of periods that differ by whole frames as these do where none is missing or there twice.
    spread : float
        Standard deviation of the periods, frames.
    count : int
        Of frames.
    irregular : float
        Standard deviation of a period, in periods, by its difference from the next.
    period : float
        Mean of the cycles, frames.
    """

    missing: npt.NDArray[np.int_]
    repeated: npt.NDArray[np.int_]
    chance: float
    spread: float
    count: int
    irregular: float = 0.0
    period: float = 0.0

    def doubts(self) -> list[str]:
        """A sentence for each, if it is certain enough."""
        found = []
        certain = self.missing.size + self.repeated.size >= 2 or self.chance < _LIKELY
        for frames, said, made in (
            (self.missing, "missing: the folds jump two frames ahead after", "higher"),
            (self.repeated, "there twice: the folds stand still in", "lower"),
        ):
            if not (frames.size and certain):
                continue
            shown = ", ".join(map(str, frames[:_SHOWN].tolist())) + (", ..." if frames.size > _SHOWN else "")
            share = 100 * frames.size / self.count
            found.append(
                f"{frames.size} or more of {self.count} frames are {said} {shown}. So the frequency is at "
                f"least {share:.2g} % {made} than it was (it has no interval, nor has jitter), and jitter, "
                "shimmer and quotients are not those of the voice. Take the recording from the camera once "
                "more, with all frames"
            )
        if self.chance < _CERTAIN and not found:
            found.append(
                f"the cycles differ by whole frames (standard deviation {self.spread:.2g} frames), as "
                "no voice's do: frames are missing, or there twice, so that frequency and jitter, which have "
                "no interval, shimmer and quotients are not those of the voice. Take it from the camera "
                "again, with all frames"
            )
        return found

    def doubted(self, found: list[Measure]) -> list[Measure]:
        """The measures; where frames are lost, those of the cycles' lengths (frequency, jitter) without an
        interval, since how many more there are is not known."""
        if not self.doubts():
            return found
        return [
            replace(item, replicates=None) if item.quantity.recorded_from == "marks" else item
            for item in found
        ]

    def caution(self) -> str:
        """Of the frequency of cycles so irregular that lost frames among them would not show; empty where
        they are regular, or where `doubts` speak."""
        if self.irregular < _IRREGULAR or self.irregular * self.period < _UNSURE or self.doubts():
            return ""
        return (
            f"the cycles' lengths scatter by {100 * self.irregular:.2g} %, in which frames that a camera "
            "drops, and which shift the frequency by their share, would not show. Its own file tells whether "
            "it has all"
        )


def frame_sequence(width: Floats, starts: npt.NDArray[np.floating]) -> FrameSequence:
    """What is wrong with the frames.

    Parameters
    ----------
    width : (places, frames) px
        Of the slit; not a number where it is not known.
    starts : (cycles + 1)
        Frames at which cycles start, and the last ends; of fewer than four nothing is said.
    """
    count, periods = width.shape[1], np.diff(starts)
    none = np.zeros(0, dtype=int)
    if periods.size < _CYCLES:
        return FrameSequence(none, none, 1.0, 0.0, count)
    missing, repeated = _by_motion(width, float(np.median(periods)))
    faulty = _cycles_of(missing, starts), _cycles_of(repeated, starts)
    others = np.delete(periods, np.unique(np.concatenate([part[part >= 0] for part in faulty])))
    usual = float(np.median(others if others.size > 1 else periods))
    change = [np.where(part < 0, 0.0, periods[part] - usual) for part in faulty]
    kept = missing[change[0] < -_CHANGED], repeated[change[1] > _CHANGED]
    inside = sum(int(np.count_nonzero(part >= 0)) for part in faulty)
    if 2 * (kept[0].size + kept[1].size) < inside:
        kept = none, none
    spread, period = float(np.std(periods)), float(np.mean(periods))
    irregular = float(np.sqrt(np.mean(np.square(np.diff(periods))) / 2)) / period
    return FrameSequence(*kept, chance_of_whole_frames(periods), spread, count, irregular, period)


def _cycles_of(frames: npt.NDArray[np.int_], starts: npt.NDArray[np.floating]) -> npt.NDArray[np.int_]:
    """(k) the cycle that each frame and the next are in; -1 outside."""
    place = np.searchsorted(starts, frames + 0.5, side="right") - 1
    return np.asarray(np.where(place < starts.size - 1, place, -1))


def _by_motion(width: Floats, period: float) -> tuple[npt.NDArray[np.int_], npt.NDArray[np.int_]]:
    """Frames after which one is missing, and those that show the one before (module docstring)."""
    count, none = width.shape[1], np.zeros(0, dtype=int)
    if count < 3 * period:
        return none, none
    x = width.T
    known = np.asarray(np.isfinite(x).all(axis=1))
    x = np.where(known[:, None], x, 0.0)
    t = np.arange(1, count - 3)
    t = t[np.all([known[t + k] for k in range(-1, 4)], axis=0)]
    if t.size <= 2 * _NEIGHBOURS:
        return none, none
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
    return missing, repeated


def _alone(t: npt.NDArray[np.int_], left: Floats) -> npt.NDArray[np.bool_]:
    """(k) whether what is left of the prediction (k, n) in these frames t is large there alone, and not in
    the frame before and the second one after it, as it is in a cycle that is all faster."""
    size = np.sqrt(np.mean(np.square(left), axis=1))
    of_frame = dict(zip(t.tolist(), size.tolist(), strict=True))
    beside = [max(of_frame.get(frame - 1, 0.0), of_frame.get(frame + 2, 0.0)) for frame in t.tolist()]
    return np.asarray(np.array(beside) < _CLEARLY * size)


def chance_of_whole_frames(periods: npt.NDArray[np.floating]) -> float:
    """p of the module docstring, of periods (cycles) in frames; 1 where no two differ by whole frames."""
    least = 1.0
    for fraction in periods % 1:
        whole = np.round(periods - fraction)
        alike = np.abs(periods - fraction - whole) < _WHOLE
        numbers, counts = np.unique(whole[alike], return_counts=True)
        besides = alike & (whole != numbers[counts.argmax()])
        k, n = int(np.count_nonzero(besides)), int(np.count_nonzero(~alike | besides))
        if k:
            least = min(least, float(special.bdtrc(k - 1, n, 2 * _WHOLE)))
    return least


def _size(one: Floats, other: Floats) -> Floats:
    """(k) root mean square of the rows of both (k, n)."""
    return np.asarray(np.sqrt((np.mean(np.square(one), axis=1) + np.mean(np.square(other), axis=1)) / 2))
